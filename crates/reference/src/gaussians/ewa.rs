//! The kernel `ewa`: a Gaussian's projection, linear around its center (Zwicker et al. 2001, "EWA Splatting"; Kerbl et
//! al. 2023).
//!
//! Σ′ = P Pᵀ + `dilation`·I with P = J M in pixels. With the columns p_k of P and d from the center to the pixel's
//! center, det Σ′ = Σ_{j<k} (p_j × p_k)² + dilation·Σ|p_k|² + dilation² (Cauchy and Binet), and
//! ρ² = dᵀΣ′⁻¹d = (Σ(p_k × d)² + dilation·|d|²) / det Σ′. No term is negative, so nothing cancels however thin a splat
//! is.

use glam::{DMat3, DVec2, DVec3};

use super::{Hit, PlacedGaussian, alpha, is_orthographic, largest_rho2, ray};
use pellucid_scene::{GaussianSettings, Order};

/// Largest distance beyond the border of the image at which J still follows the center, over the image's half side
/// (Kerbl et al. 2023).
const CLAMP: f64 = 1.3;

/// The least opacity factor for the dilation, squared (Yu et al. 2023, "Mip-Splatting").
const LEAST_FACTOR2: f64 = 2.5e-5;

/// Scales are at least this share of the largest where a depth along a ray is asked for (Radl et al. 2024).
const THINNEST: f64 = 1e-3;

/// A Gaussian on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// μ′ in pixels.
    pub center: DVec2,
    /// The columns of P in pixels, x to the right and y down.
    pub columns: [DVec2; 3],
    /// The slope that J goes along, x/z and y/z: that of the center, within its bounds. 0 of an orthographic camera.
    pub slope: DVec2,
    /// Addition to both variances, in px².
    pub dilation: f64,
    /// o, with the factor for the dilation.
    pub opacity: f64,
}

impl Projected {
    /// Projects a Gaussian.
    pub fn new(placed: &PlacedGaussian, settings: &GaussianSettings) -> Self {
        let (jacobian, slope) = jacobian(placed);
        let columns = [0, 1, 2].map(|k| (jacobian * placed.axes.col(k)).truncate());
        let dilation = f64::from(settings.dilation);
        let mut projected = Self { center: center(placed), columns, slope, dilation, opacity: placed.opacity };
        if settings.antialias && dilation > 0.0 {
            let bare = Self { dilation: 0.0, ..projected };
            projected.opacity *= dilation_factor(bare.determinant() / projected.determinant());
        }
        projected
    }

    /// det Σ′.
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = self.columns;
        let squares: f64 = [a.perp_dot(b), b.perp_dot(c), c.perp_dot(a)].iter().map(|cross| cross * cross).sum();
        let trace: f64 = self.columns.iter().map(|column| column.length_squared()).sum();
        squares + self.dilation * (trace + self.dilation)
    }

    /// ρ² at an offset from the center; NaN or infinite where Σ′ has no inverse.
    pub fn rho2(&self, offset: DVec2) -> f64 {
        let crosses: f64 = self.columns.iter().map(|column| column.perp_dot(offset).powi(2)).sum();
        (crosses + self.dilation * offset.length_squared()) / self.determinant()
    }

    /// Returns the box around all places with at most this ρ².
    pub(super) fn bounds(&self, rho2: f64) -> [DVec2; 2] {
        let variance = self.columns.iter().fold(DVec2::splat(self.dilation), |sum, column| sum + column * column);
        let half = (rho2 * variance).map(f64::sqrt);
        [self.center - half, self.center + half]
    }
}

/// μ′ in pixels.
fn center(placed: &PlacedGaussian) -> DVec2 {
    let scale = placed.view.pixels_per_unit(placed.center.z);
    placed.view.middle() + scale * DVec2::new(placed.center.x, -placed.center.y)
}

/// Returns the factor of the opacity for a ratio of determinants, without and with the dilation.
pub(super) fn dilation_factor(ratio: f64) -> f64 {
    ratio.max(LEAST_FACTOR2).sqrt()
}

/// J, pixels to the right and down by units to the right, up and away, and the slope that it goes along. That follows
/// the center to 1.3 times the half field of view.
fn jacobian(placed: &PlacedGaussian) -> (DMat3, DVec2) {
    let scale = placed.view.pixels_per_unit(placed.center.z);
    let across = DMat3::from_diagonal(DVec3::new(scale, -scale, 0.0));
    if is_orthographic(placed.view.camera) {
        return (across, DVec2::ZERO);
    }
    let focal = placed.view.camera.focal_px(placed.view.size[1]);
    let most = 0.5 * CLAMP * DVec2::new(f64::from(placed.view.size[0]), f64::from(placed.view.size[1])) / focal;
    let slope = (placed.center.truncate() / placed.center.z).clamp(-most, most);
    (DMat3 { z_axis: scale * DVec3::new(-slope.x, slope.y, 0.0), ..across }, slope)
}

/// M with each scale at least a share of the largest. Axes of length 0 get the direction that is missing.
pub(super) fn thickened(axes: DMat3) -> DMat3 {
    let columns = [0, 1, 2].map(|k| axes.col(k));
    let lengths = columns.map(DVec3::length);
    let least = THINNEST * lengths.iter().copied().fold(0.0, f64::max);
    let mut directions = columns.map(DVec3::normalize_or_zero);
    for k in 0..3 {
        if directions[k] == DVec3::ZERO {
            let [next, last] = [directions[(k + 1) % 3], directions[(k + 2) % 3]];
            // Two may be missing. Of a needle any direction across it will do.
            directions[k] = match (next == DVec3::ZERO, last == DVec3::ZERO) {
                (false, false) => next.cross(last),
                (false, true) => next.any_orthonormal_vector(),
                _ => last.any_orthonormal_vector(),
            };
        }
    }
    let scaled = |k: usize| directions[k] * lengths[k].max(least);
    DMat3::from_cols(scaled(0), scaled(1), scaled(2))
}

pub(super) fn footprint(placed: &PlacedGaussian, settings: &GaussianSettings, order: Order) -> Vec<Hit> {
    let projected = Projected::new(placed, settings);
    let rho2 = largest_rho2(projected.opacity, settings);
    if rho2.is_nan() || rho2 < 0.0 {
        return Vec::new();
    }
    let thick = thickened(placed.axes);
    let hit = |[x, y]: [u32; 2]| {
        let offset = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - projected.center;
        let alpha = alpha(projected.opacity, projected.rho2(offset), settings)?;
        let densest = ray::densest(placed, thick, [x, y]).depth;
        Some(Hit { x, y, alpha, key: placed.key(order, densest), z: placed.shown(order, densest) })
    };
    placed.window(projected.bounds(rho2)).filter_map(hit).collect()
}
