//! The absorption of a sphere: λ, the integral of its density, and Eq. 22.

use pellucid_core::points::Points;
use pellucid_scene::{Density, Method, Soft};

/// λ and a₀ of a method's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// λ of Eq. 1, 14 or 19.
    pub lambda: f64,
    /// a₀, the opacity of a whole chord through the center of a sphere of median radius.
    pub peak: f64,
}

/// Optical depth of a chord that should be opaque; its transmittance can't be distinguished from 0.
const OPAQUE: f64 = 1e20;

impl Strength {
    /// Finds the density from the one that was asked for, and the median radius of the soft points.
    pub fn new(method: &Method, soft: &Soft, median_radius: f64) -> Self {
        // Optical depth of the central chord of a median sphere, for λ = 1.
        let central = match method {
            Method::SoftBase(_) => median_radius * median_radius,
            Method::SoftConcentric(_) => 2.0 * median_radius,
            _ => return Self::of_discs(soft),
        };
        match soft.density {
            Density::Softness(peak) => {
                let peak = f64::from(peak);
                let depth = (-(-peak).ln_1p()).min(OPAQUE);
                Self { lambda: if central > 0.0 { depth / central } else { 0.0 }, peak }
            }
            Density::Lambda(lambda) => {
                let lambda = f64::from(lambda);
                Self { lambda, peak: -(-lambda * central).exp_m1() }
            }
        }
    }

    /// Eq. 19: λ is the opacity itself.
    fn of_discs(soft: &Soft) -> Self {
        let (Density::Softness(peak) | Density::Lambda(peak)) = soft.density;
        let peak = f64::from(peak).min(1.0);
        Self { lambda: peak, peak }
    }
}

/// Returns the median radius of the points with F > t; the mean of the middle two for an even number, 0 for none.
pub fn median_radius(points: &Points, threshold: f32) -> f64 {
    let soft = points.fields.iter().zip(&points.radii).filter(|(field, _)| **field > threshold);
    let mut radii: Vec<f64> = soft.map(|(_, radius)| f64::from(*radius)).collect();
    radii.sort_by(f64::total_cmp);
    match radii.len() {
        0 => 0.0,
        n => 0.5 * (radii[(n - 1) / 2] + radii[n / 2]),
    }
}

/// Eq. 6 and 7 in a form that has a limit at d = 0: the integral of r − √(x² + d²) from 0 to `b`, odd in `b`.
///
/// ln(√(b² + d²) + b) − ln d is asinh(b/d). The difference of two of these is off by some 10⁻¹⁶·r², which is what
/// counts for an opacity; it is not accurate to as many digits where a segment is short.
pub fn antiderivative(radius: f64, distance: f64, b: f64) -> f64 {
    let squared = distance * distance;
    let logarithm = if squared > 0.0 { squared * (b / distance).asinh() } else { 0.0 };
    radius * b - 0.5 * (b * b.hypot(distance) + logarithm)
}

/// W of Eq. 22: 1 where nothing is modulated.
pub fn modulation(field: f32, soft: &Soft) -> f64 {
    match soft.modulation {
        Some(most) if field < most => {
            (f64::from(field) - f64::from(soft.threshold)) / (f64::from(most) - f64::from(soft.threshold))
        }
        _ => 1.0,
    }
}

/// Eq. 22: the opacity that takes the place of Φ.
pub fn modulated_opacity(opacity: f64, rho: f64, w: f64, peak: f64) -> f64 {
    peak * (1.0 - rho) * (1.0 - w) + opacity * w
}

/// ln(1 − Φ′)/ln(1 − Φ): the factor on a sphere's density that gives its whole chord of this optical depth the opacity
/// of Eq. 22. 1 where the quotient is undefined: a chord without density, or one that must be opaque.
pub fn density_factor(whole: f64, rho: f64, w: f64, peak: f64) -> f64 {
    if w == 1.0 {
        return 1.0;
    }
    let opacity = modulated_opacity(-(-whole).exp_m1(), rho, w, peak);
    // Either logarithm of a number that was not rounded to 1.
    let wanted = if opacity < 0.5 {
        -(-opacity).ln_1p()
    } else {
        -((1.0 - w) * (1.0 - peak + peak * rho) + w * (-whole).exp()).ln()
    };
    let factor = wanted / whole;
    if factor.is_finite() { factor } else { 1.0 }
}
