//! Colors of Gaussians: real spherical harmonics of the direction from the eye to the center.
//!
//! Degrees 0 to 3 have the constants and signs of Kerbl et al. 2023 (`cuda_rasterizer/forward.cu`), degree 4 those of
//! SPZ, which goes on in the same basis: Y_lm with sin(mφ) for m < 0, the Condon–Shortley phase included, in the order
//! of m.

use std::f64::consts::PI;

use glam::DVec3;

use super::is_orthographic;
use pellucid_core::camera::Camera;
use pellucid_core::color::{decode_srgb_f64, encode_srgb_f64};
use pellucid_core::points::Points;
use pellucid_scene::ColorSpace;

/// Returns the color of the Gaussian that a point is, in the space that blending runs in; `None` of a point that is
/// none. It is max(0, base + Σ Y·coefficient), a display value or linear as the splat's colors are, seen from the eye,
/// or along the viewing direction by an orthographic camera.
pub fn color(points: &Points, index: usize, camera: &Camera, space: ColorSpace) -> Option<DVec3> {
    let all = points.gaussians.as_ref().filter(|all| all.is_one(index))?;
    let toward = points.positions[index] - camera.eye;
    let direction = if is_orthographic(camera) { camera.forward } else { toward.normalize_or_zero() };
    let values = basis(direction, all.degree);
    let sum: DVec3 = values[1..].iter().zip(all.harmonics_of(index)).map(|(y, f)| *y * f.as_dvec3()).sum();
    let color = (all.bases[index].as_dvec3() + sum).max(DVec3::ZERO);
    Some(match (space, all.is_linear(index)) {
        (ColorSpace::Encoded, false) | (ColorSpace::Linear, true) => color,
        (ColorSpace::Encoded, true) => color.map(encode_srgb_f64),
        (ColorSpace::Linear, false) => color.map(decode_srgb_f64),
    })
}

/// Returns all basis functions up to a degree (0 to 4) for a unit vector, (degree + 1)² of them, degree by degree.
pub fn basis(direction: DVec3, degree: u32) -> Vec<f64> {
    let all = [zero(), one(direction), two(direction), three(direction), four(direction)];
    all.into_iter().take(degree as usize + 1).flatten().collect()
}

/// The factor √(n / (dπ)).
fn root(n: f64, d: f64) -> f64 {
    (n / (d * PI)).sqrt()
}

/// 1 / (2√π).
fn zero() -> Vec<f64> {
    vec![root(1.0, 4.0)]
}

fn one(DVec3 { x, y, z }: DVec3) -> Vec<f64> {
    let c = root(3.0, 4.0);
    vec![-c * y, c * z, -c * x]
}

fn two(DVec3 { x, y, z }: DVec3) -> Vec<f64> {
    let c = root(15.0, 4.0);
    vec![c * x * y, -c * y * z, root(5.0, 16.0) * (2.0 * z * z - x * x - y * y), -c * x * z, 0.5 * c * (x * x - y * y)]
}

fn three(DVec3 { x, y, z }: DVec3) -> Vec<f64> {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (c3, c2, c1) = (root(35.0, 32.0), root(105.0, 4.0), root(21.0, 32.0));
    vec![
        -c3 * y * (3.0 * xx - yy),
        c2 * x * y * z,
        -c1 * y * (4.0 * zz - xx - yy),
        root(7.0, 16.0) * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
        -c1 * x * (4.0 * zz - xx - yy),
        0.5 * c2 * z * (xx - yy),
        -c3 * x * (xx - 3.0 * yy),
    ]
}

/// Degree 4 on the unit sphere, where x² + y² + z² = 1.
fn four(DVec3 { x, y, z }: DVec3) -> Vec<f64> {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (c4, c3, c2, c1) = (root(315.0, 16.0), root(315.0, 32.0), root(45.0, 16.0), root(45.0, 32.0));
    vec![
        c4 * x * y * (xx - yy),
        -c3 * y * z * (3.0 * xx - yy),
        c2 * x * y * (7.0 * zz - 1.0),
        -c1 * y * z * (7.0 * zz - 3.0),
        root(9.0, 256.0) * (35.0 * zz * zz - 30.0 * zz + 3.0),
        -c1 * x * z * (7.0 * zz - 3.0),
        0.5 * c2 * (xx - yy) * (7.0 * zz - 1.0),
        -c3 * x * z * (xx - 3.0 * yy),
        0.25 * c4 * (xx * (xx - 3.0 * yy) - yy * (3.0 * xx - yy)),
    ]
}
