//! Bound on the difference of two drivers that both keep to Vulkan's precision of operations.
//!
//! All methods place and order fragments by additions, subtractions and multiplications, which every driver rounds
//! correctly and never fuses (NoContraction), by divisions and square roots, and by comparisons. Vulkan ("Precision and
//! Operation of SPIR-V Instructions") leaves 2.5 ulp to a division and what follows from 1 / inverseSqrt, 2 + 2.5 ulp,
//! to a square root; drivers that round both correctly, as all CPU drivers measured do, give the same bytes, since
//! exponentials, logarithms and powers are the shaders' own (shaders/shared/elementary.wgsl). Where a driver does not:
//!
//! - A fragment's opacity and color are off by e = [`FRAGMENT_ULP`] units in the last place: the longest chain (Phong's
//!   light: two normalizations, a power of exponent 32 whose argument's error it multiplies) has 2 · (4.5 + 2.5) + 32 ·
//!   1.5, rounded up.
//! - An image is composed of Σ Tᵢ αᵢ cᵢ with Σ Tᵢ αᵢ ≤ 1, so that errors of opacities and colors come out as at most 2
//!   e, and each of n additions adds half a unit: 2 e + n / 2 units of 1. Means of n samples or ensembles are no worse.
//! - Where a comparison falls within these errors (a pixel's center on a splat's rim, two depths that tie), it may come
//!   out the other way, and the pixel differs by whatever the fragment contributes. Rims are known to about 10⁻⁵
//!   pixels, so that of the 10⁵ decisions of such an image one or two flip: [`FLIPS`] of the pixels.

use crate::images::Met;

/// Units in the last place that a fragment's color may be off by.
const FRAGMENT_ULP: f64 = 64.0;
/// Share of the pixels that may be beyond the bound, since a comparison came out the other way.
pub const FLIPS: f64 = 0.002;

/// Largest difference of linear R, G, B and A, in pixels where no comparison came out the other way.
pub fn largest_difference(met: Met) -> f64 {
    (2.0 * FRAGMENT_ULP + 0.5 * met.longest as f64) * f64::from(f32::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // 128 units and a half for each of 100.
        assert_eq!(largest_difference(Met { longest: 100 }), 178.0 * 2f64.powi(-23));
        assert!(largest_difference(Met { longest: 1 }) < 1.6e-5);
    }
}
