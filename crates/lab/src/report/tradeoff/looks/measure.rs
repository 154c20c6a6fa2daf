//! The parts of an error.

use glam::DVec3;
use pellucid_core::image::LinearImage;

use super::{Look, worst};

/// Luminance of linear R, G and B (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);
/// Two images that are nearer to each other show no direction, but how they were rounded.
const LEAST_DISTANCE: f64 = 1e-5;

/// The images by which errors are distinguished, all of one size.
#[derive(Clone, Copy)]
pub(in super::super) struct Exact<'a> {
    /// The reference.
    pub reference: &'a LinearImage,
    /// True where it shows more than background.
    pub covered: &'a [bool],
    /// Fragments of the reference with their order lost: the mean of their colors by opacity, with the exact coverage.
    pub unordered: Option<&'a LinearImage>,
}

/// A covered pixel.
#[derive(Clone, Copy)]
struct Pixel {
    /// Number of the pixel in the image.
    index: usize,
    error: DVec3,
    /// Vector from the reference to the image without order.
    toward: DVec3,
}

/// Returns the parts of an image's error; `None` if no pixel is covered.
pub(in super::super) fn look(exact: &Exact<'_>, image: &LinearImage) -> Option<Look> {
    let pixels = || exact.pixels(image);
    let count = pixels().count() as f64;
    if count == 0.0 {
        return None;
    }
    let mean = pixels().map(|pixel| pixel.error).sum::<DVec3>() / count;
    let even = mean - spill(pixels, mean, count);
    let rest = |pixel: &Pixel| pixel.error - even;
    let [toward, away] = along(pixels(), rest);
    let squares: f64 = pixels().map(|pixel| rest(&pixel).length_squared()).sum();
    let even = count * even.length_squared();
    let whole = (even + squares).max(f64::MIN_POSITIVE);
    let leak = (toward - away) / whole;
    // Of what lies along that direction as much is leak as does not cancel.
    let part = (toward - away).abs() / (toward + away).max(f64::MIN_POSITIVE);
    let left = |pixel: &Pixel| {
        let rest = rest(pixel);
        pixel.direction().map_or(rest, |way| rest - part * rest.dot(way) * way)
    };
    let others = (1.0 - even / whole - leak.abs()).max(0.0);
    let ghost = others * coherence(pixels().map(|pixel| (pixel.index, left(&pixel))), image);
    Some(Look {
        bias: mean.dot(LUMINANCE),
        even: even / whole,
        leak: exact.unordered.map(|_| leak),
        ghost,
        noise: others - ghost,
        worst: worst(exact.reference, image),
    })
}

impl Exact<'_> {
    /// The covered pixels whose error is a number.
    fn pixels(&self, image: &LinearImage) -> impl Iterator<Item = Pixel> {
        let covered = self.covered.iter().enumerate().filter(|(_, covered)| **covered).map(|(index, _)| index);
        let pixel = |index: usize| {
            let truth = linear(self.reference, index);
            let toward = self.unordered.map_or(DVec3::ZERO, |unordered| linear(unordered, index) - truth);
            Pixel { index, error: linear(image, index) - truth, toward }
        };
        covered.map(pixel).filter(|pixel| pixel.error.is_finite() && pixel.toward.is_finite())
    }
}

impl Pixel {
    /// The direction in which hidden colors come through; `None` where order does not matter.
    fn direction(&self) -> Option<DVec3> {
        (self.toward.length() > LEAST_DISTANCE).then(|| self.toward.normalize())
    }
}

fn linear(image: &LinearImage, index: usize) -> DVec3 {
    DVec3::from_array(image.pixels[index].map(f64::from))
}

/// Returns the mean error explained by a uniform leak; leak and offset are fitted by least squares.
fn spill<I: Iterator<Item = Pixel>>(pixels: impl Fn() -> I, mean: DVec3, count: f64) -> DVec3 {
    let middle = pixels().map(|pixel| pixel.toward).sum::<DVec3>() / count;
    let (mut both, mut squares) = (0.0, 0.0);
    for pixel in pixels() {
        both += (pixel.error - mean).dot(pixel.toward - middle);
        squares += (pixel.toward - middle).length_squared();
    }
    if squares > count * LEAST_DISTANCE * LEAST_DISTANCE { both / squares * middle } else { DVec3::ZERO }
}

/// Squared error along the directions in which hidden colors come through, and against them.
fn along(pixels: impl Iterator<Item = Pixel>, rest: impl Fn(&Pixel) -> DVec3) -> [f64; 2] {
    let lengths = pixels.filter_map(|pixel| Some(rest(&pixel).dot(pixel.direction()?)));
    lengths.fold([0.0; 2], |[toward, away], length| {
        let square = length * length;
        if length > 0.0 { [toward + square, away] } else { [toward, away + square] }
    })
}

/// Returns the correlation of errors with those of the pixels to the right and below, as products over mean squares: 1
/// for a plane, 0 for noise, at least 0.
fn coherence(errors: impl Iterator<Item = (usize, DVec3)>, image: &LinearImage) -> f64 {
    let (width, mut field) = (image.width as usize, vec![[f32::NAN; 3]; image.pixels.len()]);
    errors.for_each(|(index, error)| field[index] = error.as_vec3().to_array());
    let at = |index: usize| field.get(index).map(|error| DVec3::from_array(error.map(f64::from)));
    let (mut products, mut squares) = (0.0, 0.0);
    for index in 0..field.len() {
        let right = ((index + 1) % width != 0).then_some(index + 1);
        let pairs = right.into_iter().chain([index + width]).filter_map(|other| Some((at(index)?, at(other)?)));
        for (a, b) in pairs.filter(|(a, b)| a.is_finite() && b.is_finite()) {
            products += a.dot(b);
            squares += 0.5 * (a.length_squared() + b.length_squared());
        }
    }
    if squares > 0.0 { (products / squares).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    const SIZE: [u32; 2] = [160, 128];

    fn image(mut pixel: impl FnMut(u32, u32) -> [f32; 3]) -> LinearImage {
        let [width, height] = SIZE;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
        LinearImage { width, height, pixels }
    }

    fn random(seed: u64, most: f32) -> LinearImage {
        let mut random = Pcg64::seed_from_u64(seed);
        image(|_, _| std::array::from_fn(|_| random.random_range(0.0..most)))
    }

    /// The reference with an error.
    fn with(reference: &LinearImage, mut error: impl FnMut(usize) -> [f32; 3]) -> LinearImage {
        let off = |(i, truth): (usize, &[f32; 3])| {
            let error = error(i);
            std::array::from_fn(|c| truth[c] + error[c])
        };
        LinearImage { pixels: reference.pixels.iter().enumerate().map(off).collect(), ..*reference }
    }

    struct Images {
        reference: LinearImage,
        covered: Vec<bool>,
        unordered: LinearImage,
    }

    fn images() -> Images {
        let (reference, unordered) = (random(1, 1.0), random(2, 1.0));
        Images { covered: vec![true; reference.pixels.len()], reference, unordered }
    }

    impl Images {
        fn look(&self, image: &LinearImage) -> Look {
            let exact = Exact { reference: &self.reference, covered: &self.covered, unordered: Some(&self.unordered) };
            look(&exact, image).unwrap()
        }

        fn toward(&self, i: usize) -> [f32; 3] {
            std::array::from_fn(|c| self.unordered.pixels[i][c] - self.reference.pixels[i][c])
        }
    }

    #[track_caller]
    fn assert_shares(look: Look, wanted: [f64; 4], most: f64) {
        let found = [look.even, look.leak.unwrap(), look.ghost, look.noise];
        let sum: f64 = found.iter().map(|share| share.abs()).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{look:?}");
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < most), "{look:?}, not {wanted:?}");
    }

    #[test]
    fn an_even_shift_is_bias_alone() {
        let images = images();
        let look = images.look(&with(&images.reference, |_| [0.02, -0.01, 0.03]));
        // 0.02 · 0.2126 - 0.01 · 0.7152 + 0.03 · 0.0722.
        assert!((look.bias + 0.000_734).abs() < 1e-6, "{look:?}");
        assert_shares(look, [1.0, 0.0, 0.0, 0.0], 1e-6);
    }

    #[test]
    fn a_step_toward_the_image_without_order_is_leak_alone() {
        let mut images = images();
        // Brighter without order, so that leak brightens, too.
        images.unordered = random(2, 2.0);
        let step = |share: f32| images.look(&with(&images.reference, |i| images.toward(i).map(|d| share * d)));
        let look = step(0.3);
        assert!((look.bias - 0.3 * 0.5).abs() < 0.01, "{look:?}");
        assert_shares(look, [0.0, 1.0, 0.0, 0.0], 1e-6);
        assert_shares(step(-0.1), [0.0, -1.0, 0.0, 0.0], 1e-6);
        // Of another strength on the other side.
        let uneven = |i: usize| images.toward(i).map(|d| if i % 160 < 80 { 0.4 * d } else { 0.02 * d });
        let look = images.look(&with(&images.reference, uneven));
        assert!(look.leak.unwrap() > 0.9, "{look:?}");
    }

    #[test]
    fn a_shape_is_ghost_and_noise_is_noise() {
        let images = images();
        // A disc whose color is none of those behind, and of which as much is too bright as too dark.
        let disc = |i: usize| {
            let (x, y) = ((i % 160) as f32 - 80.0, (i / 160) as f32 - 64.0);
            let error = if x < 0.0 { 0.1 } else { -0.1 };
            if x.hypot(y) < 40.0 { [error, -0.5 * error, error] } else { [0.0; 3] }
        };
        let look = images.look(&with(&images.reference, disc));
        assert!(look.bias.abs() < 2e-3 && look.ghost > 0.9, "{look:?}");
        let mut random = Pcg64::seed_from_u64(3);
        let noisy = with(&images.reference, |_| std::array::from_fn(|_| random.random_range(-0.1..0.1)));
        // 20 000 pixels: a hundredth is some three standard errors of a mean of them.
        assert_shares(images.look(&noisy), [0.0, 0.0, 0.0, 1.0], 0.02);
    }

    #[test]
    fn in_shades_of_grey_too() {
        let grey = |image: LinearImage| LinearImage {
            pixels: image.pixels.iter().map(|pixel| [pixel[0]; 3]).collect(),
            ..image
        };
        let (reference, unordered) = (grey(random(1, 1.0)), grey(random(2, 1.0)));
        let images = Images { covered: vec![true; reference.pixels.len()], reference, unordered };
        let mut random = Pcg64::seed_from_u64(3);
        let noisy = with(&images.reference, |_| [random.random_range(-0.1..0.1); 3]);
        assert_shares(images.look(&noisy), [0.0, 0.0, 0.0, 1.0], 0.03);
        let leaking = with(&images.reference, |i| images.toward(i).map(|d| 0.2 * d));
        assert_shares(images.look(&leaking), [0.0, 1.0, 0.0, 0.0], 1e-6);
    }

    #[test]
    fn background_and_what_is_no_number_do_not_count() {
        let mut images = images();
        images.covered = (0..images.covered.len()).map(|i| i % 160 < 40).collect();
        let shifted = |i: usize| if i % 160 >= 40 { [0.5, 0.5, f32::NAN] } else { [0.25; 3] };
        let look = images.look(&with(&images.reference, shifted));
        assert!((look.bias - 0.25).abs() < 1e-6, "{look:?}");
        let nothing = vec![false; images.covered.len()];
        let exact = Exact { reference: &images.reference, covered: &nothing, unordered: None };
        assert_eq!(super::look(&exact, &images.reference), None);
        let exact = Exact { covered: &images.covered, ..exact };
        let look = super::look(&exact, &images.reference).unwrap();
        assert_eq!((look.bias, look.leak, look.worst.share), (0.0, None, 0.0), "no error");
    }
}
