//! Transparency by wavelets (Aizenshtein et al. 2022) in float64: how a pixel's light fades with depth is known by the
//! coefficients of Haar wavelets of its optical depth.

use glam::DVec3;

use super::fragments::{Composite, Fragment, coverage, nearest};
use super::moments::{optical_depth, place_of, weighed};

/// The optical depth before each place of a pixel. Places go from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Absorption {
    rank: u32,
    /// Coefficients of the wavelets, level by level, and of the constant one: 2^(rank + 1).
    coefficients: Vec<f64>,
}

impl Absorption {
    /// Transforms pairs of place and optical depth.
    pub fn new(pairs: &[(f64, f64)], rank: u32) -> Self {
        let mut absorption = Self { rank, coefficients: vec![0.0; 2 << rank] };
        pairs.iter().for_each(|(place, depth)| absorption.add(*place, *depth));
        absorption
    }

    /// Returns the coefficients, from the widest wavelet on, that of the constant one last.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Cells, one for each coefficient.
    fn cells(&self) -> usize {
        self.coefficients.len()
    }

    /// A place so that the last one, 1, begins the last cell.
    fn squeezed(&self, place: f64) -> f64 {
        place * (self.cells() - 1) as f64 / self.cells() as f64
    }

    /// The wavelets at a cell, finest first: level, number among all, and sign there.
    fn wavelets(&self, cell: usize) -> impl Iterator<Item = (u32, usize, f64)> + use<> {
        let mut i = cell + (2 << self.rank) - 1;
        (0..=self.rank).rev().map(move |level| {
            let sign = if i & 1 == 1 { 1.0 } else { -1.0 };
            i = (i - 1) >> 1;
            (level, i, sign)
        })
    }

    fn add(&mut self, place: f64, depth: f64) {
        let d = self.squeezed(place);
        let cell = (d * self.cells() as f64).floor() as usize;
        for (level, j, sign) in self.wavelets(cell) {
            let width = 0.5f64.powi(level as i32);
            let k = (j + 1) & ((1 << level) - 1);
            let phase = if sign < 0.0 { width } else { 0.0 };
            let height = f64::from(1u32 << level).sqrt();
            self.coefficients[j] += ((d - width * k as f64) * sign + phase) * height * depth;
        }
        let constant = self.cells() - 1;
        self.coefficients[constant] += depth * (1.0 - d);
    }

    /// The mean optical depth over a cell.
    fn value(&self, cell: usize) -> f64 {
        let details =
            self.wavelets(cell).map(|(level, j, sign)| f64::from(1u32 << level).sqrt() * self.coefficients[j] * sign);
        self.coefficients[self.cells() - 1] - details.sum::<f64>()
    }

    /// Returns the optical depth before a place, linear between cells.
    pub fn before(&self, place: f64) -> f64 {
        let at = self.squeezed(place) * self.cells() as f64;
        let cell = at.floor() as usize;
        let last = if cell == 0 { 0.0 } else { self.value(cell - 1) };
        last + (at - at.floor()) * (self.value(cell) - last)
    }
}

/// Returns places of depths from that of the nearest to that of the farthest, by logarithms; 0 where all are the same.
pub fn places(depths: &[f64], depth_range: [f64; 2]) -> Vec<f64> {
    let at: Vec<f64> = depths.iter().map(|z| place_of(*z, depth_range)).collect();
    let [low, high] = at.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], z| [l.min(*z), h.max(*z)]);
    at.iter().map(|z| if high > low { (z - low) / (high - low) } else { 0.0 }).collect()
}

/// Returns the fragments of a pixel, depths between near and far. What has no opacity changes nothing.
pub fn wavelet(list: &[Fragment], colors: &[DVec3], depth_range: [f64; 2], rank: u32) -> Composite {
    let seen: Vec<Fragment> = list.iter().filter(|f| f.alpha > 0.0).copied().collect();
    if seen.is_empty() {
        return Composite::NOTHING;
    }
    let places = places(&seen.iter().map(|f| f.z).collect::<Vec<_>>(), depth_range);
    let pairs: Vec<_> = places.iter().zip(&seen).map(|(place, f)| (*place, optical_depth(f.alpha))).collect();
    let absorption = Absorption::new(&pairs, rank);
    let exponents: Vec<f64> = places.iter().map(|place| -absorption.before(*place)).collect();
    Composite { color: weighed(&seen, colors, &exponents), alpha: coverage(list), depth: nearest(list) }
}
