//! The surfaces that opaque points sample, as accurately as the points permit: blended splats with many samples per
//! pixel.

use glam::Vec3;
use rayon::prelude::*;

use pellucid_core::image::{Image, LinearImage, MAX_SIDE};
use pellucid_core::metrics::rmse;
use pellucid_core::parallel;
use pellucid_engine::methods::{Error, Frame, Renderer, linear};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::{BlendedSplats, Method, ScreenSplats};

/// Samples across a pixel, if the image is not too large for them.
const SAMPLES_ACROSS: u32 = 4;
/// Samples of all pixels at most: half a gibibyte of colors, coverage and depths.
const MAX_SAMPLES: u64 = 1 << 25;

/// A picture of the surfaces.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Supersampled {
    /// Image over the background, in linear light: the means over each pixel's samples.
    pub image: LinearImage,
    /// The pixels the surfaces cover.
    pub silhouette: Silhouette,
    /// Samples across a pixel.
    pub samples_across: u32,
}

/// Renders a frame of three-pass splats with several samples per pixel. The camera is the frame's; its image is larger.
///
/// # Errors
/// Rendering fails.
pub(in crate::report) fn supersampled(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    background: Vec3,
) -> Result<Supersampled, Error> {
    let samples_across = samples_across(frame.size);
    let size = frame.size.map(|side| side * samples_across);
    let mut fine = Frame { size, method: scaled(frame.method, samples_across), ..*frame };
    // Eye-dome lighting looks as far as in the smaller image.
    fine.shading.edl.edl_radius *= samples_across as f32;
    let image = renderer.render(cloud, &fine)?.image;
    let silhouette = Silhouette::from_image(&image, samples_across);
    let image = averaged(&linear(&image, background, frame.color)?, samples_across);
    Ok(Supersampled { image, silhouette, samples_across })
}

/// The largest possible number of samples across a pixel.
fn samples_across(size: [u32; 2]) -> u32 {
    let fits = |across: &u32| {
        let [width, height] = size.map(|side| u64::from(side) * u64::from(*across));
        width.max(height) <= u64::from(MAX_SIDE) && width * height <= MAX_SAMPLES
    };
    (2..=SAMPLES_ACROSS).rev().find(fits).unwrap_or(1)
}

/// Scales a method's splats to pixels that are smaller by this factor.
fn scaled(method: Method, factor: u32) -> Method {
    let scale = |settings: BlendedSplats| {
        let max_pixel_radius = (settings.splats.max_pixel_radius * factor as f32).min(f32::MAX);
        BlendedSplats { splats: ScreenSplats { max_pixel_radius, ..settings.splats }, ..settings }
    };
    match method {
        Method::Hqs(settings) => Method::Hqs(scale(settings)),
        Method::Splats(settings) => Method::Splats(scale(settings)),
        other => other,
    }
}

/// The means of blocks of `factor` × `factor` pixels; both sides are multiples of it.
fn averaged(image: &LinearImage, factor: u32) -> LinearImage {
    let (width, height) = (image.width / factor, image.height / factor);
    let (pitch, side) = (image.width as usize, factor as usize);
    let share = 1.0 / (side * side) as f32;
    let row = |y: usize| {
        (0..width as usize).map(move |x| {
            let samples = (0..side).flat_map(|dy| {
                let start = (y * side + dy) * pitch + x * side;
                &image.pixels[start..start + side]
            });
            let sum: Vec3 = samples.map(|sample| Vec3::from_array(*sample)).sum();
            (share * sum).to_array()
        })
    };
    let pixels = (0..height as usize).into_par_iter().flat_map_iter(row).collect();
    LinearImage { width, height, pixels }
}

/// The pixels that surfaces cover for certain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::report) struct Silhouette {
    inside: Vec<bool>,
    /// The number of pixels inside.
    pub pixels: u64,
}

impl Silhouette {
    /// Returns the silhouette of an image with `factor` × `factor` samples per pixel: the pixels whose samples are all
    /// covered, and whose eight neighbors in the image are, too. Splats extend over the rim of a surface by a part of
    /// their radius, so only pixels at least one pixel inside the rim certainly show the surface.
    fn from_image(image: &Image, factor: u32) -> Self {
        let (width, height) = ((image.width / factor) as usize, (image.height / factor) as usize);
        let (pitch, side) = (image.width as usize, factor as usize);
        let is_covered = |x: usize, y: usize| {
            let mut rows = (y * side..(y + 1) * side).map(|row| row * pitch + x * side);
            rows.all(|start| image.rgba[start..start + side].iter().all(|rgba| rgba[3] > 0.0))
        };
        let full = parallel::map(width * height, |at| is_covered(at % width, at / width));
        let is_inside = |at: usize| {
            let (x, y) = (at % width, at / width);
            let mut rows = y.saturating_sub(1)..height.min(y + 2);
            rows.all(|row| (x.saturating_sub(1)..width.min(x + 2)).all(|column| full[row * width + column]))
        };
        let inside = parallel::map(width * height, is_inside);
        let pixels = inside.iter().filter(|inside| **inside).count() as u64;
        Self { inside, pixels }
    }

    /// The share of these pixels that are empty, without depth, in an image of the same size with one sample per pixel.
    /// (Antialiasing of an edge colors pixels beside it, so color is no criterion.) `None` if no pixel is inside.
    pub fn holes(&self, image: &Image) -> Option<f64> {
        let pixels = self.inside.iter().zip(&image.depth);
        let holes = pixels.filter(|(inside, depth)| **inside && !depth.is_finite()).count();
        (self.pixels > 0).then(|| holes as f64 / self.pixels as f64)
    }

    /// RMSE of these pixels of an image against the reference. `None` if no pixel is inside.
    pub fn rmse(&self, reference: &LinearImage, image: &LinearImage) -> Option<f64> {
        let inside = |image: &LinearImage| -> Vec<[f32; 3]> {
            let pixels = image.pixels.iter().zip(&self.inside).filter(|(_, inside)| **inside);
            pixels.map(|(pixel, _)| *pixel).collect()
        };
        (self.pixels > 0).then(|| rmse(&inside(reference), &inside(image)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, alpha: impl Fn(u32, u32) -> f32) -> Image {
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Image {
            width,
            height,
            rgba: pixels().map(|(x, y)| [alpha(x, y); 4]).collect(),
            depth: pixels().map(|(x, y)| if alpha(x, y) > 0.0 { 1.0 } else { f32::INFINITY }).collect(),
            ..Image::default()
        }
    }

    #[test]
    fn holes_are_counted_off_the_rim() {
        // 6 × 4 pixels of 2 × 2 samples: the left five columns are covered, except for one sample of the fourth
        // column's second pixel from above.
        let is_hole = |x, y| (x, y) == (7, 3);
        let fine = image(12, 8, |x, y| if x < 10 && !is_hole(x, y) { 1.0 } else { 0.0 });
        let silhouette = Silhouette::from_image(&fine, 2);
        // Columns 0 and 1 touch nothing; 2 to 4 touch the pixel (3, 1) in rows 0 to 2, and column 4 touches 5; row 3 of
        // columns 2 and 3 is left.
        let expected: Vec<bool> = (0..24).map(|at| [0, 1].contains(&(at % 6)) || [20, 21].contains(&at)).collect();
        assert_eq!(silhouette, Silhouette { inside: expected, pixels: 10 });
        assert_eq!(silhouette.holes(&image(6, 4, |_, _| 1.0)), Some(0.0));
        // Empty pixels outside are not holes; one of ten inside is, whatever its color.
        let mut open = image(6, 4, |x, _| if x == 5 { 0.0 } else { 1.0 });
        assert_eq!(silhouette.holes(&open), Some(0.0));
        open.depth[7] = f32::INFINITY;
        assert_eq!(silhouette.holes(&open), Some(0.1));
        assert_eq!(silhouette.holes(&image(6, 4, |_, _| 0.0)), Some(1.0));
        assert_eq!(Silhouette::from_image(&image(12, 8, |_, _| 0.0), 2).holes(&open), None);
    }

    #[test]
    fn only_what_is_inside_counts() {
        let silhouette = Silhouette { inside: vec![true, false, true], pixels: 2 };
        let row = |values: [f32; 3]| LinearImage { width: 3, height: 1, pixels: values.map(|v| [v; 3]).into() };
        let rmse = |values| silhouette.rmse(&row([0.5; 3]), &row(values)).unwrap();
        assert_eq!(rmse([0.5, 9.0, 0.5]), 0.0);
        // One of the two pixels is off by 0.5.
        assert!((rmse([0.5, 9.0, 1.0]) - 0.125f64.sqrt()).abs() < 1e-12);
        let nowhere = Silhouette { inside: vec![false; 3], pixels: 0 };
        assert_eq!(nowhere.rmse(&row([0.0; 3]), &row([1.0; 3])), None);
    }

    #[test]
    fn samples_are_averaged() {
        let pixels = (0..16).map(|at| [at as f32, 0.0, if at == 5 { 4.0 } else { 0.0 }]).collect();
        let fine = LinearImage { width: 8, height: 2, pixels };
        let coarse = averaged(&fine, 2);
        assert_eq!((coarse.width, coarse.height), (4, 1));
        // 0, 1, 8, 9 and so on.
        let expected = [[4.5, 0.0, 0.0], [6.5, 0.0, 0.0], [8.5, 0.0, 1.0], [10.5, 0.0, 0.0]];
        assert_eq!(coarse.pixels, expected);
        assert_eq!(averaged(&fine, 1), fine);
    }

    #[test]
    fn large_images_get_fewer_samples() {
        let cases = [
            ([1024, 1024], 4),
            ([1920, 1080], 4),
            ([2048, 2048], 2),
            ([3840, 2160], 2),
            ([1, 16384], 1),
            ([1, 5000], 3),
        ];
        for (size, across) in cases {
            assert_eq!(samples_across(size), across, "{size:?}");
        }
        let splats = ScreenSplats { max_pixel_radius: 25.0, ..ScreenSplats::default() };
        let Method::Hqs(scaled) = scaled(Method::Hqs(BlendedSplats { splats, ..BlendedSplats::default() }), 4) else {
            panic!("another method")
        };
        assert_eq!((scaled.splats.max_pixel_radius, scaled.splats.size), (100.0, 1.0));
    }
}
