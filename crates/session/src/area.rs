//! The area of a pixel: what a picture that looks at a few points of each pixel is off from one that looks at many.

use glam::{DVec3, Vec3};
use pellucid_core::color::{ColorSpace, decode_srgb_f64, encode_srgb_f64};
use pellucid_core::image::LinearImage;
use pellucid_core::metrics::{error_text, rmse};
use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Frame, Renderer, linear};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::plan;
use pellucid_reference::ReferencePicture;
use pellucid_scene::Method;
use serde::{Deserialize, Serialize};

/// Samples of the exact picture that stands for the areas of pixels.
pub const MOST: u32 = 64;
/// Samples of that picture where there is no time for [`MOST`].
pub const FEWER: u32 = 16;
/// Samples that a comparison gives each method.
pub const COMPARED: [u32; 3] = [1, 4, 16];
/// Samples among which a choice is made.
pub const CHOSEN: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// The picture that errors are measured against.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Against {
    /// The exact picture with the scene's own samples: by default the center of each pixel.
    #[default]
    Center,
    /// The exact picture with [`MOST`] samples in a pixel.
    Area,
}

impl Against {
    /// Returns the word of the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Center => "center",
            Self::Area => "area",
        }
    }

    /// Returns what a word of the command line names.
    pub fn from_word(word: &str) -> Option<Self> {
        [Self::Center, Self::Area].into_iter().find(|against| against.word() == word)
    }
}

/// The sampling error of a picture: that of looking at some points of a pixel in place of its area.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PixelArea {
    /// Name of the exact method, of which both pictures are.
    pub method: String,
    /// Samples in a pixel of the picture, from 1.
    pub samples: u32,
    /// Samples in a pixel of the picture that it is compared with: [`MOST`], or [`FEWER`] for lack of time.
    pub against: u32,
    /// RMSE between the two, on composed linear R, G, B of all pixels.
    pub rmse: f64,
}

impl PixelArea {
    /// Returns the error as a line of a report.
    pub fn text(&self) -> String {
        let Self { method, samples, against, rmse } = self;
        let s = if *samples == 1 { "" } else { "s" };
        let rmse = error_text(*rmse);
        format!(
            "pixel area: {method} with {samples} sample{s} in a pixel has RMSE {rmse} against itself with {against}"
        )
    }
}

/// Returns the samples of the picture that stands for the area, for a picture with `samples` of which one image takes
/// so many seconds: the most that fit `limit` seconds, if any do.
pub fn affordable(image_seconds: f64, samples: u32, limit: f64) -> Option<u32> {
    let fits = |count: &u32| *count > samples && f64::from(*count) * image_seconds <= limit;
    [MOST, FEWER].into_iter().find(fits)
}

/// The sampling error of a picture, as far as it was measured.
#[derive(Debug, Clone, PartialEq)]
pub enum Sampling {
    /// Known value.
    Known(PixelArea),
    /// The fewest samples to compare with would take about so many seconds.
    TooSlow(f64),
    /// The picture has as many samples as there are, or no picture is exact for its method.
    Nothing,
}

/// Returns the method whose picture is exact for a frame's, if there is one that draws no random numbers.
fn exact(frame: &Frame, points: &Points) -> Option<Method> {
    let own = Some(frame.method).filter(|_| frame.shading.edl.edl || frame.method.takes_shadows());
    let exact = own.or_else(|| plan::exact(&frame.method, points)).unwrap_or(frame.method);
    (!exact.is_sampled()).then_some(exact)
}

/// Measures the sampling error of a frame, by pictures of its exact method that take about `limit` seconds at most.
///
/// # Errors
/// Returns the errors of [`Renderer::render`].
pub fn sampling(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    points: &Points,
    (frame, background): (&Frame, Vec3),
    limit: f64,
) -> Result<Sampling, Error> {
    let Some(method) = exact(frame, points).filter(|_| frame.samples < MOST) else { return Ok(Sampling::Nothing) };
    let frame = Frame { method, fragments: false, depths: false, max_error: None, spread: false, ..*frame };
    let mut picture = |samples: u32| -> Result<(LinearImage, f64), Error> {
        let rendered = renderer.render(cloud, &Frame { samples, ..frame })?;
        let image = linear(&rendered.image, background, frame.color)?;
        renderer.recycle(rendered.image);
        Ok((image, rendered.profile.wall.as_secs_f64() / f64::from(samples)))
    };
    let (own, first) = picture(frame.samples)?;
    // The first one may have paid for shaders.
    let seconds = if f64::from(FEWER) * first > limit { picture(frame.samples)?.1.min(first) } else { first };
    let Some(against) = affordable(seconds, frame.samples, limit) else {
        return Ok(Sampling::TooSlow(f64::from(if frame.samples < FEWER { FEWER } else { MOST }) * seconds));
    };
    let rmse = rmse(&picture(against)?.0.pixels, &own.pixels);
    let method = method.name().to_owned();
    Ok(Sampling::Known(PixelArea { method, samples: frame.samples, against, rmse }))
}

/// Returns the light that a premultiplied pixel shows, and its A: what means over the samples of a pixel are of.
pub fn light(frame: &Frame, [r, g, b, a]: [f64; 4]) -> [f64; 4] {
    if frame.color == ColorSpace::Linear {
        return [r, g, b, a];
    }
    let shown = DVec3::new(r, g, b) + (1.0 - a) * behind(frame);
    let [r, g, b] = shown.to_array().map(decode_srgb_f64);
    [r, g, b, a]
}

/// Returns the premultiplied pixel that shows a light, with its A: the inverse of [`light`].
pub fn pixel(frame: &Frame, [r, g, b, a]: [f64; 4]) -> [f64; 4] {
    if frame.color == ColorSpace::Linear {
        return [r, g, b, a];
    }
    let [r, g, b] = (DVec3::from_array([r, g, b].map(encode_srgb_f64)) - (1.0 - a) * behind(frame)).to_array();
    [r, g, b, a]
}

/// The background as an encoded color.
fn behind(frame: &Frame) -> DVec3 {
    DVec3::from_array(frame.background.as_dvec3().to_array().map(encode_srgb_f64))
}

/// Returns pixels of the mean over a frame's images, in float64; `pixels` are those of one of them.
pub fn mean(frame: &Frame, mut pixels: impl FnMut(&Frame) -> Vec<[f64; 4]>) -> Vec<[f64; 4]> {
    if frame.samples == 1 || frame.only.is_some() {
        return pixels(frame);
    }
    let mut sums: Vec<[f64; 4]> = Vec::new();
    for index in 0..frame.samples {
        let image = pixels(&frame.image(index));
        sums.resize(image.len(), [0.0; 4]);
        for (sum, value) in sums.iter_mut().zip(image) {
            let value = light(frame, value);
            *sum = std::array::from_fn(|channel| sum[channel] + value[channel]);
        }
    }
    sums.into_iter().map(|sum| pixel(frame, sum.map(|value| value / f64::from(frame.samples)))).collect()
}

/// Returns the mean over the pictures of a frame's images, in float64, with depths and counts of number N/2.
pub fn mean_picture(frame: &Frame, mut picture: impl FnMut(&Frame) -> ReferencePicture) -> ReferencePicture {
    let mut middle = None;
    let rgba = mean(frame, |image| {
        let mut found = picture(image);
        let rgba = std::mem::take(&mut found.rgba);
        if image.only.is_none_or(|index| index == frame.samples / 2) {
            middle = Some(found);
        }
        rgba
    });
    let middle = middle.unwrap_or_else(|| picture(frame));
    ReferencePicture { rgba, ..middle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::camera::{Camera, Projection};
    use pellucid_scene::Discs;

    fn frame(samples: u32, color: ColorSpace) -> Frame {
        let flat = Projection::Orthographic { height: 1.0 };
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y, flat, 0.1, 2.0).unwrap();
        let frame = Frame::new(camera, [2, 1], Method::ABuffer(Discs::default()));
        Frame { samples, color, background: Vec3::ONE, ..frame }
    }

    #[test]
    fn as_many_samples_are_compared_with_as_there_is_time_for() {
        assert_eq!(affordable(0.5, 1, 32.0), Some(64));
        assert_eq!(affordable(0.5, 1, 31.0), Some(16));
        assert_eq!(affordable(0.5, 16, 31.0), None, "16 samples are no reference for 16");
        assert_eq!(affordable(0.5, 1, 7.0), None);
        assert_eq!(affordable(0.0, 64, 7.0), None);
    }

    #[test]
    fn a_line_names_both_numbers_of_samples() {
        let area = PixelArea { method: "abuffer".to_owned(), samples: 1, against: 64, rmse: 0.0271 };
        assert_eq!(area.text(), "pixel area: abuffer with 1 sample in a pixel has RMSE 2.71e-2 against itself with 64");
        assert!(PixelArea { samples: 4, ..area }.text().contains("with 4 samples in a pixel"));
    }

    #[test]
    fn the_mean_of_white_and_black_is_half_the_light() {
        let one = |image: &Frame| vec![[f64::from(image.only == Some(1)); 4].map(|v| v.min(1.0)), [0.5; 4]];
        // In one of four images the first pixel is white and opaque, and nothing in the others.
        assert_eq!(mean(&frame(4, ColorSpace::Linear), one), [[0.25; 4], [0.5; 4]]);
        // As encoded values over white every image shows white there.
        let found = mean(&frame(4, ColorSpace::Encoded), one);
        let shown: Vec<f64> = found[0][..3].iter().map(|v| v + 0.75).collect();
        assert!(shown.iter().all(|v| (v - 1.0).abs() < 1e-12), "{found:?}");
        assert!(found[1].iter().all(|v| (v - 0.5).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn black_over_white_shows_the_encoded_mean_of_light() {
        let one = |image: &Frame| vec![[0.0, 0.0, 0.0, f64::from(image.only == Some(0))]];
        let [[r, _, _, a]] = mean(&frame(2, ColorSpace::Encoded), one)[..] else { panic!("one pixel") };
        // Half of the light of white, encoded, is 0.7354 (IEC 61966-2-1).
        assert!((r + (1.0 - a) - (1.055 * 0.5f64.powf(1.0 / 2.4) - 0.055)).abs() < 1e-12 && a == 0.5, "{r} {a}");
    }

    #[test]
    fn depths_are_those_of_the_middle_image() {
        let picture = |image: &Frame| ReferencePicture {
            width: 1,
            height: 1,
            rgba: vec![[1.0; 4]],
            depth: vec![f64::from(image.only.unwrap_or(9))],
            counts: vec![0],
        };
        assert_eq!(mean_picture(&frame(4, ColorSpace::Linear), picture).depth, [2.0]);
        assert_eq!(mean_picture(&frame(1, ColorSpace::Linear), picture).depth, [9.0]);
    }
}
