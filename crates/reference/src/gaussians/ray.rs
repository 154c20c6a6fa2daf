//! The kernel `ray`: a Gaussian's largest density along a pixel's ray (Moënne-Loccoz et al. 2024, "3D Gaussian Ray
//! Tracing").
//!
//! With g = S⁻¹Rᵀ(e − μ) and h = S⁻¹Rᵀd that is ρ² = |h×g|² / |h|² at t = −g·h / |h|². Hahlbohm et al. 2024 ("Efficient
//! Perspective-Correct 3D Gaussian Splatting Using Hybrid Transparency") get the same without an inverse, also of flat
//! splats: the ray is where two planes meet. In coordinates y of the Gaussian, x = μ + M y, these are aᵢ·y + cᵢ = 0.
//! With k = a₁ × a₂ and m = c₁a₂ − c₂a₁ the point of the ray nearest to y = 0 is (k × m) / |k|², and ρ² = |m|² / |k|².

use glam::{DMat3, DVec2, DVec3};

use super::{Hit, PlacedGaussian, alpha, is_orthographic, largest_rho2};
use crate::coverage::on_screen;
use pellucid_scene::{GaussianSettings, Order};

/// Place at which a Gaussian is densest along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Densest {
    /// Distance from the center in standard deviations, squared; not finite where the ray is in the plane of a flat
    /// Gaussian.
    pub rho2: f64,
    /// Depth along the viewing axis; of a line, not of a ray that ends at the eye.
    pub depth: f64,
}

/// Returns where a Gaussian with these axes in camera coordinates is densest along the ray through a pixel's center.
pub fn densest(placed: &PlacedGaussian, axes: DMat3, pixel: [u32; 2]) -> Densest {
    let rows = axes.transpose();
    let on_plane = placed.on_plane(pixel);
    let center = placed.center;
    // Perspective: x − slope·z = 0. Orthographic: x = place.
    let (a, c) = if is_orthographic(placed.view.camera) {
        ([rows.x_axis, rows.y_axis], center.truncate() - on_plane)
    } else {
        let a = [rows.x_axis - on_plane.x * rows.z_axis, rows.y_axis - on_plane.y * rows.z_axis];
        (a, center.truncate() - on_plane * center.z)
    };
    let k = a[0].cross(a[1]);
    let m = c.x * a[1] - c.y * a[0];
    let nearest = k.cross(m) / k.length_squared();
    Densest { rho2: m.length_squared() / k.length_squared(), depth: center.z + rows.z_axis.dot(nearest) }
}

/// Returns a box on the screen around the ellipsoid of this ρ²: that of its box in camera coordinates. Everything if
/// that reaches the eye.
pub(super) fn bounds(placed: &PlacedGaussian, rho2: f64) -> [DVec2; 2] {
    let rows = placed.axes.transpose();
    let half = rho2.sqrt() * DVec3::from([rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.length()));
    on_screen(placed.view, placed.center - half, placed.center + half)
}

pub(super) fn footprint(placed: &PlacedGaussian, settings: &GaussianSettings, order: Order) -> Vec<Hit> {
    let rho2 = largest_rho2(placed.opacity, settings);
    if rho2.is_nan() || rho2 < 0.0 {
        return Vec::new();
    }
    let hit = |[x, y]: [u32; 2]| {
        let Densest { rho2, depth } = densest(placed, placed.axes, [x, y]);
        let alpha = alpha(placed.opacity, rho2, settings)?;
        let visible = depth >= placed.view.camera.near && depth <= placed.view.camera.far;
        visible.then(|| Hit { x, y, alpha, key: placed.key(order, depth), z: placed.shown(order, depth) })
    };
    placed.window(bounds(placed, rho2)).filter_map(hit).collect()
}
