//! Samples of a pixel's area: a picture as the mean of N pictures, each moved by a fraction of a pixel.
//!
//! Sample i of N lies at x = (i + ½)/N, y = v(i) + 1/(2N) of its pixel, v the radical inverse in base 2 (van der
//! Corput 1935; Hammersley 1960). Picture i is that of the same scene with every projected position moved by (½ − x,
//! ½ − y) pixels: its pixels' centers are these samples. Color and A are means of premultiplied linear light, counts
//! are means, and depths are those of picture ⌊N/2⌋.

use glam::{DVec2, DVec3};

use super::range::{ColorRange, PictureRange, Range};
use pellucid_core::camera::Camera;
use pellucid_core::color::decode_srgb_f64;

/// Returns the digits of a number in base 2, mirrored at the point: 0, ½, ¼, ¾, ⅛ and so on, in [0, 1).
pub fn radical_inverse(index: u32) -> f64 {
    let (mut rest, mut digit, mut sum) = (index, 0.5, 0.0);
    while rest > 0 {
        sum += digit * f64::from(rest % 2);
        rest /= 2;
        digit *= 0.5;
    }
    sum
}

/// Returns the places of N samples in their pixel, each in (0, 1)², in their order.
pub fn places(count: u32) -> Vec<DVec2> {
    let of = f64::from(count);
    let place = |index: u32| DVec2::new((f64::from(index) + 0.5) / of, radical_inverse(index) + 0.5 / of);
    (0..count).map(place).collect()
}

/// Returns the camera that moves every projected position so that this place of a pixel comes to its center.
pub fn moved(camera: &Camera, place: DVec2) -> Camera {
    Camera { shift: DVec2::splat(0.5) - place, ..*camera }
}

/// Returns the cameras of N pictures, in their order.
pub fn cameras(camera: &Camera, count: u32) -> Vec<Camera> {
    places(count).into_iter().map(|place| moved(camera, place)).collect()
}

/// Returns the picture of N pictures: means of colors, A and counts, and the depths of picture ⌊N/2⌋. None gives an
/// empty picture.
pub fn mean(pictures: &[PictureRange]) -> PictureRange {
    let Some(middle) = pictures.get(pictures.len() / 2) else { return PictureRange::default() };
    let share = 1.0 / pictures.len() as f64;
    let mean = |of: &dyn Fn(&PictureRange) -> Range| {
        pictures.iter().fold(Range::only(0.0), |sum, picture| sum + of(picture)).scaled(share)
    };
    PictureRange {
        width: middle.width,
        rgba: (0..middle.rgba.len()).map(|at| std::array::from_fn(|c| mean(&|picture| picture.rgba[at][c]))).collect(),
        depth: middle.depth.clone(),
        counts: (0..middle.counts.len()).map(|at| mean(&|picture| picture.counts[at])).collect(),
    }
}

/// Returns the linear colors that a picture of encoded values shows over a background, which is encoded too; A stays.
pub fn shown(picture: &PictureRange, background: DVec3) -> PictureRange {
    let pixel = |rgba: &ColorRange| {
        let behind = rgba[3].complement();
        std::array::from_fn(|c| match c {
            3 => rgba[3],
            _ => {
                let Range { low, high } = rgba[c] + behind.scaled(background[c]);
                Range { low: decode_srgb_f64(low), high: decode_srgb_f64(high) }
            }
        })
    };
    PictureRange { rgba: picture.rgba.iter().map(pixel).collect(), ..picture.clone() }
}

/// Returns the standard errors of the mean of N pictures, √(Σ stderr_i²)/N, from those of each.
pub fn stderr(errors: &[Vec<DVec3>]) -> Vec<DVec3> {
    let variance = |at: usize| errors.iter().map(|of| of[at] * of[at]).sum::<DVec3>();
    let pixels = errors.first().map_or(0, Vec::len);
    (0..pixels).map(|at| variance(at).map(f64::sqrt) / errors.len() as f64).collect()
}
