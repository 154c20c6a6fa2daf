//! LDR-FLIP: how visible the difference of two pictures is to somebody who flips between them.
//!
//! Computed here rather than by NVIDIA's C++ (crate nv-flip), whose binding takes 8-bit pictures: in those, what is
//! below half a step is no difference. Constants and the filters' amplitudes are those of that code, and so are the
//! values, to float32's rounding, as crates/core/tests/host/metrics.rs shows.

mod color;
mod filter;

use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;

use super::finite;
use crate::image::LinearImage;
use crate::parallel;
use color::Colors;
use filter::{Filters, Weights};

/// Pixels per degree: a screen 0.7 m and 3840 pixels wide, seen from 0.7 m. About 67.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;
/// Rows that one task does; the rows around them that its filters need are converted once more for each.
const STRIP: usize = 32;

/// Returns the mean LDR-FLIP error (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: a
/// difference evaluator for alternating images") of two images, clamped to [0, 1], on a screen of 67 pixels per degree:
/// no unit, 0 for equal images, at most 1.
///
/// Per pixel (ΔE_c)^(1 − ΔE_f). ΔE_c is the HyAB distance of Hunt-adjusted CIELAB colors after filters of the eye's
/// contrast sensitivity in YCxCz, ΔE_f the difference of the edges and points in their luminance. Beyond its sides an
/// image repeats its border pixels, so images of any size can be compared. The paper takes sRGB-encoded pictures and
/// decodes them; here linear light is used directly, unrounded. The order of the images does not matter. Differing
/// values give 1 if one of them is not finite.
///
/// # Panics
/// The images differ in size.
pub fn flip(a: &LinearImage, b: &LinearImage) -> f64 {
    assert_eq!((a.width, a.height), (b.width, b.height), "images to compare are equally large");
    let (width, height) = (a.width as usize, a.height as usize);
    let Some(images) = finite(a, b) else { return 1.0 };
    if images[0].is_empty() {
        return 0.0;
    }
    let eye = Eye::new(PIXELS_PER_DEGREE);
    let strips: Vec<f64> = parallel::map(height.div_ceil(STRIP), |strip| {
        let rows = strip * STRIP..height.min((strip + 1) * STRIP);
        let [a, b] = images.each_ref().map(|pixels| eye.features(pixels, width, rows.clone()));
        a.iter().zip(&b).map(|(a, b)| eye.error(a, b)).sum()
    });
    // Summed in order, so that the last bit depends on no scheduling.
    strips.iter().sum::<f64>() / (width * height) as f64
}

/// The filtered features of one pixel.
struct PixelFeatures {
    /// Filtered color, Hunt-adjusted CIELAB.
    color: DVec3,
    /// Strength of edges and of points.
    features: [f64; 2],
}

/// The filters shared by all pixels.
struct Eye {
    filters: Filters,
    colors: Colors,
    /// The greatest color difference within RGB, that of green and blue.
    greatest: f64,
}

impl Eye {
    fn new(pixels_per_degree: f64) -> Self {
        let colors = Colors::new();
        let greatest = color_difference(colors.hunt_lab(DVec3::Y), colors.hunt_lab(DVec3::Z));
        Self { filters: Filters::new(pixels_per_degree), colors, greatest }
    }

    /// The features of some rows of an image, pixel by pixel.
    fn features(&self, pixels: &[[f32; 3]], width: usize, rows: Range<usize>) -> Vec<PixelFeatures> {
        let length = self.filters.taps.len();
        let radius = length / 2;
        let last = pixels.len() / width - 1;
        // Row `i` of the image is element `i + radius - rows.start`, and so it is with columns: both repeat at the
        // sides.
        let padded: Vec<Vec<DVec3>> = (rows.start..rows.end + 2 * radius)
            .map(|row| {
                let row = row.saturating_sub(radius).min(last) * width;
                let color = |x: usize| self.colors.opponent(pixels[row + x.saturating_sub(radius).min(width - 1)]);
                (0..width + 2 * radius).map(color).collect()
            })
            .collect();
        let filtered = padded.windows(length).map(|rows| self.vertical(rows));
        filtered
            .flat_map(|row| row.windows(length).map(|columns| self.horizontal(columns)).collect::<Vec<_>>())
            .collect()
    }

    /// Weighted sums down the columns, one for each weight and the channel it is for.
    fn vertical(&self, rows: &[Vec<DVec3>]) -> Vec<Weights> {
        let mut sums = vec![Weights::default(); rows[0].len()];
        for (row, tap) in rows.iter().zip(&self.filters.taps) {
            for (sum, color) in sums.iter_mut().zip(row) {
                let [y, cx, cz] = color.to_array();
                for (i, channel) in [y, cx, cz, cz, y, y, y].into_iter().enumerate() {
                    sum[i] += tap[i] * channel;
                }
            }
        }
        sums
    }

    /// Applies the filter along a row, and the resulting features.
    fn horizontal(&self, columns: &[Weights]) -> PixelFeatures {
        let mut colors = [0.0; 4];
        let (mut edge, mut point) = ([0.0; 2], [0.0; 2]);
        for (column, tap) in columns.iter().zip(&self.filters.taps) {
            for i in 0..4 {
                colors[i] += tap[i] * column[i];
            }
            let [smooth, slope, curve] = [column[4], column[5], column[6]];
            edge = [edge[0] + tap[5] * smooth, edge[1] + tap[4] * slope];
            point = [point[0] + tap[6] * smooth, point[1] + tap[4] * curve];
        }
        let cz = self.filters.shares[0] * colors[2] + self.filters.shares[1] * colors[3];
        let rgb = self.colors.linear(DVec3::new(colors[0], colors[1], cz)).clamp(DVec3::ZERO, DVec3::ONE);
        // The luminance is (Y + 16) / 116, and these filters sum to 0.
        let features = [edge, point].map(|[x, y]: [f64; 2]| x.hypot(y) / 116.0);
        PixelFeatures { color: self.colors.hunt_lab(rgb), features }
    }

    /// The error of one pixel, in [0, 1].
    fn error(&self, a: &PixelFeatures, b: &PixelFeatures) -> f64 {
        let color = spread(color_difference(a.color, b.color) / self.greatest);
        let [edges, points] = [0, 1].map(|i| (a.features[i] - b.features[i]).abs());
        let feature = (edges.max(points) / 2f64.sqrt()).sqrt().min(1.0);
        color.powf(1.0 - feature)
    }
}

/// The HyAB distance (city block for lightness, Euclidean for hue and chroma) to the power of 0.7.
fn color_difference(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    (d.x.abs() + d.y.hypot(d.z)).powf(0.7)
}

/// Color differences in units of the greatest: those up to 0.4 take [0, 0.95], the rest what is left.
fn spread(difference: f64) -> f64 {
    const KNEE: f64 = 0.4;
    const AT_KNEE: f64 = 0.95;
    if difference < KNEE {
        difference * AT_KNEE / KNEE
    } else {
        (AT_KNEE + (difference - KNEE) / (1.0 - KNEE) * (1.0 - AT_KNEE)).min(1.0)
    }
}
