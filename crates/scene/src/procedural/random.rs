//! Random numbers and angles that are the same on every machine.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A seeded stream of random numbers.
pub(super) struct Random(Pcg64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.random()
    }

    /// Uniform in [low, high).
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0..count.
    pub(super) fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Nearly Gaussian, mean 0 and variance 1: twelve uniform numbers (Irwin–Hall), since ln and cos of the standard
    /// library differ between platforms. No value beyond ±6.
    pub(super) fn gauss(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    /// Uniform on the unit sphere.
    pub(super) fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (cos, sin) = unit_circle(self.unit());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// (cos, sin) of a fraction of a full turn, to about 1e-9, of exactly defined operations only: the standard library's
/// sine differs between platforms in the last bit, and a scene must not.
pub(super) fn unit_circle(turn: f64) -> (f64, f64) {
    let quarters = (turn * 4.0).round();
    // At most 45 degrees to either side of a quarter turn, where these Taylor terms leave less than 2e-10.
    let x = (turn * 4.0 - quarters) * std::f64::consts::FRAC_PI_2;
    let x2 = x * x;
    let sin = x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0 * (1.0 - x2 / 110.0)))));
    let cos = 1.0 - x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0 * (1.0 - x2 / 90.0))));
    match quarters.rem_euclid(4.0) as u8 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Returns a threshold in [0, 1) for the cell of a grid: neighbors differ (Roberts' R2 sequence), so that thinning a
/// grid by it leaves no clumps and gaps as independent random numbers do.
pub(super) fn dither(column: usize, row: usize) -> f64 {
    (0.754_877_666_246_692_8 * column as f64 + 0.569_840_290_998_053_2 * row as f64).fract()
}

/// Hash of three integers to [0, 1), by the finaliser of splitmix64.
pub(super) fn hash(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ (z as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((h ^ (h >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns the value noise in [0, 1], smooth over lengths of 1.
pub(super) fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * (DVec3::splat(3.0) - 2.0 * f);
    let (x, y, z) = (cell.x as i64, cell.y as i64, cell.z as i64);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let edge = |dy: i64, dz: i64| mix(hash(x, y + dy, z + dz), hash(x + 1, y + dy, z + dz), w.x);
    mix(mix(edge(0, 0), edge(1, 0), w.y), mix(edge(0, 1), edge(1, 1), w.y), w.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_circle_is_that_of_the_standard_library() {
        for i in -1000..=2000 {
            let turn = f64::from(i) / 997.0;
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let (c, s) = unit_circle(turn);
            // The next terms of the two series at 45 degrees: x¹²/12! = 1.2e-10 and x¹³/13! = 7e-12.
            assert!((c - cos).abs() < 2e-10 && (s - sin).abs() < 2e-10, "{turn}: {c} {s}");
        }
        assert_eq!(unit_circle(0.0), (1.0, 0.0));
        assert_eq!(unit_circle(0.25), (-0.0, 1.0));
    }

    #[test]
    fn gauss_has_mean_0_and_variance_1() {
        let mut random = Random::new(5);
        let n = 40_000;
        let values: Vec<f64> = (0..n).map(|_| random.gauss()).collect();
        let mean = values.iter().sum::<f64>() / f64::from(n);
        let variance = values.iter().map(|v| v * v).sum::<f64>() / f64::from(n);
        // Five standard errors: 1/√n of the mean, √2/√n of the variance.
        assert!(mean.abs() < 0.025 && (variance - 1.0).abs() < 0.036, "{mean} {variance}");
    }
}
