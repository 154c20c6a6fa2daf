//! Moment-based order-independent transparency (Münstermann et al. 2018) in float64: how a pixel's light fades with
//! depth is known by a few power moments of its optical depth, and estimated from them by the bounds of the moment
//! problem.

use glam::DVec3;

use super::fragments::{Composite, Fragment, coverage, nearest};
use pellucid_scene::Moments;

/// Most optical depth of a fragment: that of an opaque one.
pub const MOST_DEPTH: f64 = 10.0;

/// Less than this a pivot is rounding.
const LEAST_PIVOT: f64 = 1e-17;

/// Moments toward which those of a pixel are moved, from the first on, by their number.
fn bias_vector(count: u32) -> &'static [f64] {
    match count {
        4 => &[0.0, 0.375, 0.0, 0.375],
        6 => &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45],
        _ => &[0.0, 0.75, 0.0, 0.676_667, 0.0, 0.63, 0.0, 0.600_303],
    }
}

/// Returns where a depth lies between near (−1) and far (1), by logarithms; both must be above 0.
pub fn place_of(z: f64, [near, far]: [f64; 2]) -> f64 {
    2.0 * (z.clamp(near, far) / near).ln() / (far / near).ln() - 1.0
}

/// −ln(1−α), at most [`MOST_DEPTH`].
pub fn optical_depth(alpha: f64) -> f64 {
    (-(-alpha).ln_1p()).min(MOST_DEPTH)
}

/// Σaᵢzᵢᵏ for k from 0 to `count`, of pairs of place and optical depth.
pub fn power_moments(pairs: &[(f64, f64)], count: u32) -> Vec<f64> {
    (0..=count as i32).map(|k| pairs.iter().map(|(z, a)| a * z.powi(k)).sum()).collect()
}

/// The share of a pixel's optical depth that lies before a place, as far as its moments say.
#[derive(Debug, Clone)]
pub struct Absorption {
    /// The optical depth itself.
    pub total: f64,
    /// Row by row below the diagonal: the Hankel matrix of the moments is L D Lᵀ.
    lower: Vec<Vec<f64>>,
    pivots: Vec<f64>,
}

impl Absorption {
    /// Makes the distribution from moments, the first of which is above 0, moved toward those of a smooth distribution
    /// by the share `bias`.
    pub fn new(moments: &[f64], bias: f64) -> Self {
        let total = moments[0];
        let toward = bias_vector(moments.len() as u32 - 1);
        let moved = moments[1..].iter().zip(toward).map(|(b, to)| (1.0 - bias) * b / total + bias * to);
        let b: Vec<f64> = std::iter::once(1.0).chain(moved).collect();
        let size = b.len() / 2 + 1;
        let (mut lower, mut pivots) = (vec![vec![0.0; size]; size], vec![0.0; size]);
        for j in 0..size {
            let known = |i: usize| (0..j).map(|k| lower[i][k] * lower[j][k] * pivots[k]).sum::<f64>();
            let pivot = (b[2 * j] - known(j)).max(LEAST_PIVOT);
            let column: Vec<f64> = (j + 1..size).map(|i| (b[i + j] - known(i)) / pivot).collect();
            pivots[j] = pivot;
            column.iter().zip(j + 1..).for_each(|(value, i)| lower[i][j] = *value);
        }
        Self { total, lower, pivots }
    }

    /// L⁻¹(1, z, z², …)ᵀ: the monic orthogonal polynomials at z.
    fn orthogonal(&self, z: f64) -> Vec<f64> {
        let mut p: Vec<f64> = Vec::new();
        for (i, row) in self.lower.iter().enumerate() {
            let known: f64 = p.iter().zip(row).map(|(p, l)| p * l).sum();
            p.push(z.powi(i as i32) - known);
        }
        p
    }

    /// Σpₖ(z)² / Dₖ: no measure with these moments has more than the inverse of it at z.
    fn kernel(&self, z: f64) -> f64 {
        self.orthogonal(z).iter().zip(&self.pivots).map(|(p, d)| p * p / d).sum()
    }

    /// The coefficients of Σpₖ(x)pₖ(z) / Dₖ by powers of x.
    fn kernel_coefficients(&self, z: f64) -> Vec<f64> {
        let mut c: Vec<f64> = self.orthogonal(z).iter().zip(&self.pivots).map(|(p, d)| p / d).collect();
        for i in (0..c.len()).rev() {
            for j in i + 1..c.len() {
                c[i] -= self.lower[j][i] * c[j];
            }
        }
        c
    }

    /// Returns the places other than z, and the shares, z's first, of the only measure of `moments.len() / 2 + 1`
    /// points with these moments that has one at z.
    pub fn canonical(&self, z: f64) -> (Vec<f64>, Vec<f64>) {
        let places = real_roots(&self.kernel_coefficients(z));
        let shares = std::iter::once(&z).chain(&places).map(|z| 1.0 / self.kernel(*z)).collect();
        (places, shares)
    }

    /// Returns the least and the most share before and at z, by any measure with these moments (Chebyshev, Markov,
    /// Stieltjes).
    pub fn bounds(&self, z: f64) -> [f64; 2] {
        let (places, shares) = self.canonical(z);
        let before: f64 =
            places.iter().zip(&shares[1..]).filter(|(place, _)| **place < z).map(|(_, share)| share).sum();
        [before, before + shares[0]]
    }

    /// Returns the estimate at z: from the lower bound (`overestimation` 0, light is overestimated the most) to the
    /// upper one (1).
    pub fn share(&self, z: f64, overestimation: f64) -> f64 {
        let [least, most] = self.bounds(z);
        (least + overestimation * (most - least)).clamp(0.0, 1.0)
    }
}

/// Returns the roots of a polynomial, ascending, that has as many real ones as its degree says: between those of its
/// derivative. Coefficients by powers, from the constant on.
pub fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let degree = coefficients.iter().rposition(|c| *c != 0.0).unwrap_or(0);
    if degree == 0 {
        return Vec::new();
    }
    let c = &coefficients[..=degree];
    let at = |x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let derivative: Vec<f64> = c.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
    // No root is larger (Cauchy).
    let most = 1.0 + c[..degree].iter().map(|low| (low / c[degree]).abs()).fold(0.0, f64::max);
    let turns: Vec<f64> = [-most].into_iter().chain(real_roots(&derivative)).chain([most]).collect();
    turns.windows(2).map(|ends| bisected(at, ends[0], ends[1])).collect()
}

/// Returns where a function changes its sign, by halves until there is no number between.
fn bisected(at: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let rises = at(high) >= at(low);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if (at(middle) < 0.0) == rises {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Returns a · ΣcαT / ΣαT with exponents of T. Only their differences count, so that no pixel is too dark.
pub fn weighed(list: &[Fragment], colors: &[DVec3], exponents: &[f64]) -> DVec3 {
    let most = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = list.iter().zip(exponents).map(|(f, e)| f.alpha * (e - most).exp()).collect();
    let sum: DVec3 = list.iter().zip(&weights).map(|(f, w)| colors[f.index as usize] * *w).sum();
    coverage(list) * sum / weights.iter().sum::<f64>()
}

/// Returns the fragments of a pixel, depths between near and far. What has no opacity changes nothing.
pub fn moments(list: &[Fragment], colors: &[DVec3], depth_range: [f64; 2], settings: &Moments) -> Composite {
    let seen: Vec<Fragment> = list.iter().filter(|f| f.alpha > 0.0).copied().collect();
    if seen.is_empty() {
        return Composite::NOTHING;
    }
    let pairs: Vec<_> = seen.iter().map(|f| (place_of(f.z, depth_range), optical_depth(f.alpha))).collect();
    let absorption = Absorption::new(&power_moments(&pairs, settings.moments.get()), settings.bias().into());
    // Equal depths, which come one after the other, share their light: finding it takes far longer than everything
    // else.
    let mut last = (f64::NAN, 0.0);
    let exponent = |(z, _): &(f64, f64)| {
        if *z != last.0 {
            last = (*z, -absorption.total * absorption.share(*z, settings.overestimation.into()));
        }
        last.1
    };
    let exponents: Vec<f64> = pairs.iter().map(exponent).collect();
    Composite { color: weighed(&seen, colors, &exponents), alpha: coverage(list), depth: nearest(list) }
}
