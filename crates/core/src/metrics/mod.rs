//! Image metrics on linear float32 images, accumulated in float64.
//!
//! They agree on values that are not finite: NaN equals NaN and an infinity itself, which are left out, and next to
//! anything else such a value takes a metric to its worst, so that it can't pass for close. [`share_above`] counts it.

mod flip;
mod ssim;

pub use flip::flip;
pub use ssim::ssim;

use crate::image::LinearImage;

/// The step of an 8-bit image: differences above it are counted as visible.
pub const STEP: f64 = 1.0 / 255.0;

/// The largest difference and the first pixel, row by row, that has it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Largest {
    /// |a − b| of the channel that differs most; at least 0, infinite where only one value is finite.
    pub value: f64,
    /// Column, from 0 at the left.
    pub x: u32,
    /// Row, from 0 at the top.
    pub y: u32,
}

/// The differences of two images.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// See [`rmse`].
    pub rmse: f64,
    /// See [`nmse`]; the first image is the reference.
    pub nmse: f64,
    /// See [`psnr`].
    pub psnr: f64,
    /// See [`ssim`].
    pub ssim: f64,
    /// See [`flip`].
    pub flip: f64,
    /// See [`largest`].
    pub max: Largest,
    /// See [`share_above`], with [`STEP`].
    pub above_1_255: f64,
}

/// Returns all metrics of an image `b` against its reference `a`; `None` if they are not equally large.
///
/// Only [`nmse`] asks which of the two is the reference.
pub fn compare(a: &LinearImage, b: &LinearImage) -> Option<Comparison> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let rmse = rmse(&a.pixels, &b.pixels);
    Some(Comparison {
        rmse,
        nmse: nmse(&a.pixels, &b.pixels),
        psnr: psnr(rmse),
        ssim: ssim(a, b),
        flip: flip(a, b),
        max: largest(a, b),
        above_1_255: share_above(&a.pixels, &b.pixels, STEP),
    })
}

/// Returns the root of the mean squared difference over R, G, B of all pixels: in units of linear light, 0 for equal
/// images.
pub fn rmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let (sum, count) = pairs(a, b)
        .map(|(a, b)| differences(a, b).iter().map(|d| d * d).sum::<f64>())
        .fold((0.0, 0.0), |(sum, count), squares| (sum + squares, count + 3.0));
    if count == 0.0 { 0.0 } else { (sum / count).sqrt() }
}

/// Returns the normalized mean square error, Σ(I − K)² / ΣI² with reference I and image K (Uchida et al. 2020, Eq. 10),
/// here over R, G and B of linear light: no unit, 0 for equal images, 1 for a black K, unbounded.
///
/// Infinite if only the reference is black.
pub fn nmse(reference: &[[f32; 3]], image: &[[f32; 3]]) -> f64 {
    let (mut error, mut signal) = (0.0, 0.0);
    for (i, k) in pairs(reference, image) {
        error += differences(i, k).iter().map(|d| d * d).sum::<f64>();
        signal += i.map(f64::from).iter().filter(|i| i.is_finite()).map(|i| i * i).sum::<f64>();
    }
    if error == 0.0 { 0.0 } else { error / signal }
}

/// Returns the peak signal-to-noise ratio in decibels, −20·log₁₀(RMSE) with a peak of 1: infinite for equal images.
pub fn psnr(rmse: f64) -> f64 {
    -20.0 * rmse.log10()
}

/// Returns the largest absolute difference in any channel, and where.
pub fn largest(a: &LinearImage, b: &LinearImage) -> Largest {
    let mut largest = Largest { value: 0.0, x: 0, y: 0 };
    for (index, (p, q)) in pairs(&a.pixels, &b.pixels).enumerate() {
        let value = differences(p, q).into_iter().fold(0.0, f64::max);
        if value > largest.value {
            let width = a.width as usize;
            // Both are below the image's sides, which are u32.
            largest = Largest { value, x: (index % width) as u32, y: (index / width) as u32 };
        }
    }
    largest
}

/// Returns the share of pixels, in [0, 1], with a channel that differs by more than `step`.
pub fn share_above(a: &[[f32; 3]], b: &[[f32; 3]], step: f64) -> f64 {
    let above = pairs(a, b).filter(|(a, b)| differences(*a, *b).iter().any(|d| *d > step)).count();
    above as f64 / a.len().max(1) as f64
}

/// |a − b| per pixel and channel, times `factor`.
pub fn difference_picture(a: &[[f32; 3]], b: &[[f32; 3]], factor: f64) -> Vec<[f32; 3]> {
    pairs(a, b).map(|(a, b)| differences(a, b).map(|d| (factor * d) as f32)).collect()
}

/// Returns both images with equal non-finite values replaced by 0; `None` if a non-finite value meets a different one.
fn finite(a: &LinearImage, b: &LinearImage) -> Option<[Vec<[f32; 3]>; 2]> {
    let differ = pairs(&a.pixels, &b.pixels).any(|(a, b)| differences(a, b).iter().any(|d| d.is_infinite()));
    let clean =
        |image: &LinearImage| image.pixels.iter().map(|p| p.map(|v| if v.is_finite() { v } else { 0.0 })).collect();
    (!differ).then(|| [clean(a), clean(b)])
}

fn pairs<'a>(a: &'a [[f32; 3]], b: &'a [[f32; 3]]) -> impl Iterator<Item = ([f32; 3], [f32; 3])> {
    a.iter().copied().zip(b.iter().copied())
}

/// Absolute differences. NaN equals NaN; next to anything else it differs without bound, so that it can't pass a limit.
fn differences(a: [f32; 3], b: [f32; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (a, b) = (f64::from(a[i]), f64::from(b[i]));
        match (a - b).abs() {
            _ if a == b || (a.is_nan() && b.is_nan()) => 0.0,
            difference if difference.is_nan() => f64::INFINITY,
            difference => difference,
        }
    })
}

/// Returns an error for people: three digits, and `0` for none at all.
pub fn error_text(error: f64) -> String {
    if error == 0.0 { "0".to_owned() } else { format!("{error:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_is_a_plain_zero() {
        assert_eq!([0.0, -0.0, 0.0123456, 1e-9].map(error_text), ["0", "0", "1.23e-2", "1.00e-9"]);
    }
}
