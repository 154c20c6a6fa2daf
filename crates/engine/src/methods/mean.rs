//! The picture of several samples per pixel: the mean of ordinary images, each moved by a fraction of a pixel.
//!
//! Sample i of N lies at x = (i + ½)/N, y = v(i) + 1/(2N) of its pixel, v the radical inverse of i in base 2: N points
//! of which each column and each row of N × N cells has one (Hammersley). Image i is that of the same scene with every
//! projected position moved by (½ − x, ½ − y) pixels, so that the centers of its pixels are these samples.
//!
//! Let N be at least 4, and call the samples that have all bits of i in common but the first and the last one a four.
//! One of each four lies in each quarter of a pixel, since the first bit of i says which half it is in x, and the last
//! one in y. So four images can be drawn at once, as one of twice as many columns and rows, each of whose pixels has
//! its sample where that of its image lies in its quarter (shaders/shared/sample_place.wgsl).

use std::cmp::Ordering;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::Frame;
use super::engine::Counts;
use crate::camera::Camera;
use crate::color::{ColorSpace, decode_srgb, encode_srgb};
use crate::image::Image;
use crate::passes::bands::Window;
use crate::passes::project::SamplePlaces;

/// The numbers of samples that a frame may have.
pub const SAMPLES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Name of the override of stages that is 1 where pixels are quarters of those of the picture.
pub(crate) const QUARTERS: &str = "QUARTERS";

/// Returns where in a pixel sample `index` of `count` lies: at multiples of 1/128.
fn place(index: u32, count: u32) -> DVec2 {
    let of = f64::from(count);
    let inverse = f64::from(index.reverse_bits()) / f64::from(1u32 << 31) / 2.0;
    DVec2::new((f64::from(index) + 0.5) / of, inverse + 0.5 / of)
}

/// Returns the pixels by which image `index` of `count` is moved, within half a pixel.
fn shift(index: u32, count: u32) -> DVec2 {
    0.5 - place(index, count)
}

/// Longest side of a picture whose images are drawn four at once, in pixels. The middle of such an image is as many
/// away from its border, and splats have whole pixels and fractions up to there (shared/locate.wgsl).
const LARGEST: u32 = 16_000;

impl Frame {
    /// Returns the frame of one of the images whose mean is this frame's.
    #[must_use]
    pub fn image(&self, index: u32) -> Self {
        let camera = Camera { shift: shift(index, self.samples), ..self.camera };
        Self { camera, only: Some(index), ..*self }
    }

    /// Returns the frames of all images, that whose depths the picture has last: number N/2.
    pub fn images(&self) -> Vec<Self> {
        if !self.is_mean() {
            return vec![*self];
        }
        let middle = self.samples / 2;
        let others = (0..self.samples).filter(|index| *index != middle);
        others.chain([middle]).map(|index| self.image(index)).collect()
    }

    /// Returns the frames of all images, four at a time; `None` if there are fewer, if the picture is too large, or if
    /// a pixel is lit by those around it, which needs each image by itself.
    pub(super) fn fours(&self) -> Option<Vec<Self>> {
        let [width, height] = self.size;
        let fits = self.is_mean() && self.samples >= 4 && width.max(height) <= LARGEST && !self.shading.edl.edl;
        let (size, camera) = ([2 * width, 2 * height], Camera { shift: DVec2::ZERO, ..self.camera });
        fits.then(|| (0..self.samples / 4).map(|four| Self { size, camera, four: Some(four), ..*self }).collect())
    }

    /// Returns where the samples of pixels lie.
    pub(super) fn places(&self) -> SamplePlaces {
        self.four.map_or(SamplePlaces::MIDDLE, |four| {
            let [first, step] = [place(2 * four, self.samples), DVec2::splat(1.0 / f64::from(self.samples))];
            let [first, step] = [2.0 * first, 2.0 * step];
            let most = (first - 0.5).abs().max((first + step - 0.5).abs()).max_element();
            SamplePlaces { first: first.as_vec2().to_array(), step: step.x as f32, most: most as f32 }
        })
    }

    /// Returns a window of the picture as one of the images that are drawn.
    pub(super) fn part(&self, window: Window) -> Window {
        if self.four.is_some() { window.map(|side| 2 * side) } else { window }
    }

    /// Returns the place of the image among those of [`Self::images`]: how many are drawn before.
    pub(super) fn turn(&self) -> u32 {
        let (number, middle) = (self.number(), self.samples / 2);
        match number.cmp(&middle) {
            Ordering::Less => number,
            Ordering::Equal => self.samples - 1,
            Ordering::Greater => number - 1,
        }
    }

    /// Returns the number of the image: each draws random numbers of its own.
    pub(super) fn number(&self) -> u32 {
        self.only.unwrap_or(0)
    }

    /// Returns `true` if the picture is a mean of several images.
    pub fn is_mean(&self) -> bool {
        self.samples > 1 && self.only.is_none() && self.four.is_none()
    }
}

/// Sums over the images of a frame: of colors in linear light, as the picture shows them, of counts, and of squared
/// standard errors. Every pixel sums its images in their order, wherever windows are cut.
pub struct Mean {
    samples: u32,
    /// The encoded background, where colors are blended as encoded values.
    encoded: Option<Vec3>,
    colors: Vec<[f64; 4]>,
    fragments: Vec<u32>,
    layers: Vec<u32>,
    variances: Vec<[f64; 3]>,
}

/// Bytes of a pixel's sums, without counts and errors.
pub(super) const PIXEL_BYTES: u64 = 32;

impl Mean {
    /// Returns the sums of no image.
    pub fn new(frame: &Frame, image: &Image) -> Self {
        let encoded = (frame.color == ColorSpace::Encoded)
            .then(|| Vec3::from_array(frame.background.to_array().map(encode_srgb)));
        Self {
            samples: frame.samples,
            encoded,
            colors: vec![[0.0; 4]; image.depth.len()],
            fragments: vec![0; image.fragments.as_ref().map_or(0, Vec::len)],
            layers: vec![0; image.layers.as_ref().map_or(0, Vec::len)],
            variances: vec![[0.0; 3]; image.stderr.as_ref().map_or(0, Vec::len)],
        }
    }

    /// Adds a window of an image; the `first` one replaces what was there.
    pub fn add(&mut self, image: &Image, window: Window, first: bool) {
        let [x0, y0, x1, y1] = window.map(|v| v as usize);
        let pitch = image.width as usize;
        let (at, encoded) = (|row: usize| row * pitch + x0..row * pitch + x1, self.encoded);
        let rows = |from: usize| from * pitch..y1 * pitch;
        self.colors[rows(y0)].par_chunks_mut(pitch).zip(image.rgba[rows(y0)].par_chunks(pitch)).for_each(
            |(to, from)| {
                for (to, from) in to[x0..x1].iter_mut().zip(&from[x0..x1]) {
                    let from = encoded.map_or(*from, |background| shown(*from, background));
                    *to = std::array::from_fn(|c| if first { 0.0 } else { to[c] } + f64::from(from[c]));
                }
            },
        );
        for row in y0..y1 {
            let counts = [(&mut self.fragments, &image.fragments), (&mut self.layers, &image.layers)];
            for (to, from) in counts.into_iter().filter_map(|(to, from)| Some((to, from.as_ref()?))) {
                let sums = to[at(row)].iter_mut().zip(&from[at(row)]);
                sums.for_each(|(to, from)| *to = if first { 0 } else { *to } + from);
            }
            if let Some(errors) = &image.stderr {
                for (to, error) in self.variances[at(row)].iter_mut().zip(&errors[at(row)]) {
                    *to = std::array::from_fn(|c| if first { 0.0 } else { to[c] } + f64::from(error[c]).powi(2));
                }
            }
        }
    }

    /// Adds a window of four images that were drawn at once, in pixels of the picture, of which `pitch` are a row; the
    /// `first` four replaces what was there.
    pub(super) fn add_four(
        &mut self,
        (rgba, counts): (&[[f32; 4]], &Counts),
        window: Window,
        first: bool,
        pitch: usize,
    ) {
        let [x0, y0, x1, y1] = window.map(|v| v as usize);
        let (width, encoded) = (2 * (x1 - x0), self.encoded);
        let rows = self.colors[y0 * pitch..y1 * pitch].par_chunks_mut(pitch).zip(rgba.par_chunks(2 * width));
        rows.for_each(|(to, from)| {
            for (x, to) in to[x0..x1].iter_mut().enumerate() {
                let mut sum = if first { [0.0; 4] } else { *to };
                for from in quarters(from, width, x) {
                    let from = encoded.map_or(from, |background| shown(from, background));
                    sum = std::array::from_fn(|c| sum[c] + f64::from(from[c]));
                }
                *to = sum;
            }
        });
        let counts = [(&mut self.fragments, &counts.fragments), (&mut self.layers, &counts.layers)];
        for (to, from) in counts.into_iter().filter_map(|(to, from)| Some((to, from.as_ref()?))) {
            for (to, from) in to[y0 * pitch..y1 * pitch].chunks_mut(pitch).zip(from.chunks(2 * width)) {
                for (x, to) in to[x0..x1].iter_mut().enumerate() {
                    *to = if first { 0 } else { *to } + quarters(from, width, x).iter().sum::<u32>();
                }
            }
        }
    }

    /// Gives an image, the last one that was added, the means. Its depths stay, and of counts it gets the sums.
    pub fn finish(self, image: &mut Image) {
        let (count, encoded) = (f64::from(self.samples), self.encoded);
        image.rgba.par_iter_mut().zip(self.colors).for_each(|(to, sum)| {
            let mean = sum.map(|v| (v / count) as f32);
            *to = encoded.map_or(mean, |background| unshown(mean, background));
        });
        image.samples = self.samples;
        image.fragments.iter_mut().for_each(|to| to.copy_from_slice(&self.fragments));
        image.layers.iter_mut().for_each(|to| to.copy_from_slice(&self.layers));
        for (to, sum) in image.stderr.iter_mut().flatten().zip(self.variances) {
            *to = sum.map(|variance| (variance.sqrt() / count) as f32);
        }
    }
}

/// Returns the quarters of a pixel, of two rows of `width` quarters: left and right above, then below.
fn quarters<T: Copy>(rows: &[T], width: usize, x: usize) -> [T; 4] {
    let [left, right] = [2 * x, 2 * x + 1];
    [rows[left], rows[right], rows[width + left], rows[width + right]]
}

/// Gives an image the depths of number N/2 of its images, which is in the first four: the upper right quarters.
pub(super) fn set_depths(image: &mut Image, window: Window, depths: &[f32]) {
    let [x0, y0, x1, y1] = window.map(|v| v as usize);
    let (pitch, width) = (image.width as usize, 2 * (x1 - x0));
    for (to, from) in image.depth[y0 * pitch..y1 * pitch].chunks_mut(pitch).zip(depths.chunks(2 * width)) {
        for (x, to) in to[x0..x1].iter_mut().enumerate() {
            let [_, upper_right, ..] = quarters(from, width, x);
            *to = upper_right;
        }
    }
}

/// Returns the linear color that encoded values show over a background, and A.
fn shown(pixel: [f32; 4], background: Vec3) -> [f32; 4] {
    let [r, g, b] = Image::over(pixel, background).map(decode_srgb);
    [r, g, b, pixel[3]]
}

/// Returns the encoded values, premultiplied, that show a linear color over a background.
fn unshown([r, g, b, a]: [f32; 4], background: Vec3) -> [f32; 4] {
    let [r, g, b] = (Vec3::from_array([r, g, b].map(encode_srgb)) - (1.0 - a) * background).to_array();
    [r, g, b, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radical inverses of 0 to 3 in base 2: 0, ½, ¼, ¾.
    #[test]
    fn samples_of_a_pixel_are_those_of_hammersley() {
        let of = |count: u32| (0..count).map(|i| (DVec2::splat(0.5) - shift(i, count)).to_array()).collect::<Vec<_>>();
        assert_eq!(of(1), [[0.5, 0.5]]);
        assert_eq!(of(2), [[0.25, 0.25], [0.75, 0.75]]);
        assert_eq!(of(4), [[0.125, 0.125], [0.375, 0.625], [0.625, 0.375], [0.875, 0.875]]);
    }

    /// Each quarter's sample is that of one image, and all fours have each image once.
    #[test]
    fn one_sample_of_each_four_lies_in_each_quarter_of_a_pixel() {
        use crate::camera::Projection;
        use crate::scene::Method;
        use glam::DVec3;

        let projection = Projection::Orthographic { height: 2.0 };
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, projection, 0.1, 2.0).expect("valid");
        for samples in SAMPLES.into_iter().filter(|samples| *samples >= 4) {
            let frame = Frame { samples, ..Frame::new(camera, [3, 2], Method::Points) };
            let mut left: Vec<DVec2> = (0..samples).map(|index| place(index, samples)).collect();
            for four in frame.fours().expect("at least four") {
                assert_eq!((four.size, four.is_mean()), ([6, 4], false));
                let SamplePlaces { first, step, most } = four.places();
                for [column, row] in [[0, 0], [1, 0], [0, 1], [1, 1]].map(|quarter: [u32; 2]| quarter.map(f64::from)) {
                    let within = DVec2::from_array(first.map(f64::from)) + f64::from(step) * DVec2::new(row, column);
                    assert!((within - 0.5).abs().max_element() <= f64::from(most) && most < 0.5, "{samples}");
                    let sample = (DVec2::new(column, row) + within) / 2.0;
                    let found = left.iter().position(|place| *place == sample).expect("an image's");
                    left.swap_remove(found);
                }
            }
            assert!(left.is_empty());
        }
    }

    #[test]
    fn depths_of_the_picture_are_those_of_the_upper_right_quarters() {
        for count in SAMPLES.into_iter().filter(|count| *count >= 4) {
            let middle = place(count / 2, count);
            assert!(middle.x >= 0.5 && middle.y < 0.5 && count / 2 < count, "{count}");
        }
        assert_eq!(quarters(&[0, 1, 2, 3, 4, 5, 6, 7], 4, 1), [2, 3, 6, 7]);
    }

    #[test]
    fn each_row_and_column_of_cells_has_one_sample() {
        for count in SAMPLES {
            for axis in 0..2 {
                let cells = (0..count).map(|i| ((0.5 - shift(i, count)[axis]) * f64::from(count)) as u32);
                let mut cells: Vec<u32> = cells.collect();
                cells.sort_unstable();
                assert!(cells.iter().copied().eq(0..count), "{count}");
            }
        }
    }
}
