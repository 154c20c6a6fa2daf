//! Structural similarity.

use super::finite;
use crate::image::LinearImage;
use crate::parallel;

/// Standard deviation of the window's weights, in pixels.
const SIGMA: f64 = 1.5;
/// The window reaches as far from its center, in pixels: 11 × 11.
const RADIUS: usize = 5;
/// (K₁·L)² and (K₂·L)² with K₁ = 0.01, K₂ = 0.03 and the range L = 1 of linear light.
const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// The averages of one channel over a window: x, y, x² + y², xy.
type Moments = [f64; 4];

/// Returns the mean structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004, Eq. 13) of linear values, over
/// windows of 11 × 11 pixels with Gaussian weights of σ = 1.5 and over R, G, B; K₁ = 0.01, K₂ = 0.03, L = 1. No unit; 1
/// for equal images, less for others, at least −1.
///
/// A window's similarity is (2μxμy + C₁)(2σxy + C₂) / ((μx² + μy² + C₁)(σx² + σy² + C₂)). Windows lie wholly in the
/// image; where a side is shorter than 11 pixels, they are cut to the longest odd length that fits, with weights
/// normalized to 1. The order of the images does not matter. Differing values give −1 if one of them is not finite.
///
/// # Panics
/// The images differ in size.
pub fn ssim(a: &LinearImage, b: &LinearImage) -> f64 {
    assert_eq!((a.width, a.height), (b.width, b.height), "images to compare are equally large");
    let (width, height) = (a.width as usize, a.height as usize);
    let Some([x, y]) = finite(a, b) else { return -1.0 };
    if x.is_empty() {
        return 1.0;
    }
    let (across, down) = (weights(width), weights(height));
    let rows: Vec<f64> = parallel::map(height - down.len() + 1, |row| {
        let moments = vertical(&x[row * width..], &y[row * width..], width, &down);
        moments.windows(across.len()).map(|window| horizontal(window, &across)).sum()
    });
    // Summed in order, so that the last bit depends on no scheduling.
    let windows = (width - across.len() + 1) * rows.len();
    rows.iter().sum::<f64>() / (3 * windows) as f64
}

/// Gaussian weights that sum to 1: 11, or the largest odd number of pixels within `side`.
fn weights(side: usize) -> Vec<f64> {
    let radius = RADIUS.min((side - 1) / 2);
    let gauss = |i: usize| (-0.5 * ((i as f64 - radius as f64) / SIGMA).powi(2)).exp();
    let weights: Vec<f64> = (0..=2 * radius).map(gauss).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

/// Weighted means down the columns of the first rows of both images, as many as weights.
fn vertical(x: &[[f32; 3]], y: &[[f32; 3]], width: usize, weights: &[f64]) -> Vec<[Moments; 3]> {
    let mut means = vec![[Moments::default(); 3]; width];
    for ((x, y), weight) in x.chunks(width).zip(y.chunks(width)).zip(weights) {
        for ((mean, x), y) in means.iter_mut().zip(x).zip(y) {
            for channel in 0..3 {
                let (x, y) = (f64::from(x[channel]), f64::from(y[channel]));
                for (mean, moment) in mean[channel].iter_mut().zip([x, y, x * x + y * y, x * y]) {
                    *mean += weight * moment;
                }
            }
        }
    }
    means
}

/// The similarity of one window, summed over the channels.
fn horizontal(columns: &[[Moments; 3]], weights: &[f64]) -> f64 {
    let mut means = [Moments::default(); 3];
    for (column, weight) in columns.iter().zip(weights) {
        for (mean, moment) in means.as_flattened_mut().iter_mut().zip(column.as_flattened()) {
            *mean += weight * moment;
        }
    }
    means.map(similarity).iter().sum()
}

fn similarity([x, y, squares, product]: Moments) -> f64 {
    let (both, cross) = (x * x + y * y, x * y);
    (2.0 * cross + C1) * (2.0 * (product - cross) + C2) / ((both + C1) * (squares - both + C2))
}
