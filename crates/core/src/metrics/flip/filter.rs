//! The filters of FLIP, each a product of one along the columns and one along the rows.

use std::f64::consts::PI;

/// Widths b of the Gaussians e^(−π²x²/b) of the contrast sensitivity, in square degrees: for Y, for Cx, and two for Cz.
const WIDTHS: [f64; 4] = [0.0047, 0.0053, 0.04, 0.025];
/// Factors of the two for Cz.
const FACTORS: [f64; 2] = [34.1, 13.5];
/// Width of a feature in degrees, two standard deviations.
const FEATURE: f64 = 0.082;

/// Weights at a place along an axis: of the Gaussians for Y and Cx and of both for Cz; then, for features in Y, of a
/// Gaussian, its slope and its curvature.
pub type Weights = [f64; 7];

/// Weights along an axis.
#[derive(Debug)]
pub struct Filters {
    /// An odd number, the middle one for the pixel itself. A Gaussian's weights sum to 1, the positive ones of slope
    /// and curvature to 1 and the negative ones to −1.
    pub taps: Vec<Weights>,
    /// The weights of the two filters of Cz.
    pub shares: [f64; 2],
}

impl Filters {
    pub fn new(pixels_per_degree: f64) -> Self {
        let sigma = 0.5 * FEATURE * pixels_per_degree;
        // All that measure contrast reach as far as the widest.
        let contrast = (3.0 * pixels_per_degree * (0.5 * WIDTHS[2]).sqrt() / PI).ceil();
        let feature = (3.0 * sigma).ceil();
        let radius = contrast.max(feature) as i32;
        let kernel = |reach: f64, f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (-radius..=radius).map(f64::from).map(|x| if x.abs() <= reach { f(x) } else { 0.0 }).collect()
        };
        let gauss = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
        let gaussians = WIDTHS.map(|b| kernel(contrast, &|x| (-(PI * x / pixels_per_degree).powi(2) / b).exp()));
        let features = [
            kernel(feature, &gauss),
            kernel(feature, &|x| x * gauss(x)),
            kernel(feature, &|x| ((x / sigma).powi(2) - 1.0) * gauss(x)),
        ];
        // The sum over both axes, before each was normalized.
        let volume = |i: usize| FACTORS[i] * (PI / WIDTHS[2 + i]).sqrt() * gaussians[2 + i].iter().sum::<f64>().powi(2);
        let shares = [0, 1].map(|i| volume(i) / (volume(0) + volume(1)));
        let kernels: Vec<Vec<f64>> = gaussians.iter().chain(&features).map(|kernel| normalized(kernel)).collect();
        let taps = (0..kernels[0].len()).map(|x| std::array::from_fn(|i| kernels[i][x])).collect();
        Self { taps, shares }
    }
}

/// Positive weights that sum to 1 and negative ones that sum to −1.
fn normalized(kernel: &[f64]) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f64 = kernel.iter().filter(|weight| **weight < 0.0).sum();
    kernel
        .iter()
        .map(|weight| if *weight > 0.0 { weight / positive } else { weight / negative.abs().max(f64::MIN_POSITIVE) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_reaches_by_hand() {
        let filters = Filters::new(67.0);
        // 3·67·√(0.04/2)/π = 9.05 and 3·0.5·0.082·67 = 8.24 pixels.
        assert_eq!(filters.taps.len(), 2 * 10 + 1);
        assert!(filters.taps[0][0] > 0.0 && filters.taps[0][4..] == [0.0; 3] && filters.taps[1][4] > 0.0);
        for i in 0..7 {
            let sum =
                |positive: bool| filters.taps.iter().map(|t| t[i]).filter(|t| (*t > 0.0) == positive).sum::<f64>();
            let negative = if i < 5 { 0.0 } else { -1.0 };
            assert!((sum(true) - 1.0).abs() < 1e-14 && (sum(false) - negative).abs() < 1e-14, "{i}");
        }
        // Slopes are odd, all others even.
        for (left, right) in filters.taps.iter().zip(filters.taps.iter().rev()) {
            for i in 0..7 {
                let sign = if i == 5 { -1.0 } else { 1.0 };
                assert!((left[i] - sign * right[i]).abs() < 1e-16);
            }
        }
        // A Gaussian's integral is √(πb)/π per axis: the volumes are as a√(π/b)·b, so a√b: 34.1·0.2 to 13.5·0.158.
        let expected = 34.1 * 0.2 / (34.1 * 0.2 + 13.5 * 0.025f64.sqrt());
        // Filters are cut off at 3 standard deviations.
        assert!((filters.shares[0] - expected).abs() < 1e-3, "{}", filters.shares[0]);
        assert!((filters.shares[0] + filters.shares[1] - 1.0).abs() < 1e-15);
    }
}
