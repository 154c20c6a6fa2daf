//! Gaussian splats: the footprints of both kernels, what they are ordered by, their colors, and what float32 may make
//! of them.

use glam::{DMat3, DQuat, DVec2, Quat};

use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_reference::gaussians::{Gaussian, Hit, footprint, gaussian};
use pellucid_scene::{GaussianSettings, Kernel, Order};

use super::*;

mod bounds;
mod ellipsoid;
mod ewa;
mod harmonics;
mod lists;
mod ray;

/// A splat of a scene: position, standard deviations, rotation, opacity.
#[derive(Clone, Copy)]
struct Splatted(DVec3, Vec3, Quat, f32);

/// Gaussian that is the same in all directions.
fn ball(position: DVec3, extent: f32, opacity: f32) -> Splatted {
    Splatted(position, Vec3::splat(extent), Quat::IDENTITY, opacity)
}

/// A Gaussian without thickness, turned by `degrees` about the vertical: on it z grows by tan(degrees) per unit to the
/// right.
fn pancake(position: DVec3, extent: f32, degrees: f32, opacity: f32) -> Splatted {
    let turned = Quat::from_rotation_y(degrees.to_radians());
    Splatted(position, Vec3::new(extent, extent, 0.0), turned, opacity)
}

/// Points that are Gaussians, white without harmonics.
fn scene(all: &[Splatted]) -> Points {
    let gaussians = Gaussians {
        extents: all.iter().map(|s| s.1).collect(),
        rotations: all.iter().map(|s| s.2).collect(),
        bases: vec![Vec3::ONE; all.len()],
        ..Gaussians::default()
    };
    Points {
        positions: all.iter().map(|s| s.0).collect(),
        colors: vec![Vec3::ONE; all.len()],
        opacities: all.iter().map(|s| s.3).collect(),
        radii: all.iter().map(|s| 3.33 * s.1.max_element()).collect(),
        gaussians: Some(gaussians),
        ..Points::default()
    }
}

fn one(splat: Splatted) -> Gaussian {
    gaussian(&scene(&[splat]), 0).unwrap()
}

/// Nothing is added to the projection, and nothing cut at 0.99.
fn bare(kernel: Kernel) -> GaussianSettings {
    GaussianSettings { kernel, dilation: 0.0, alpha_max: 1.0, ..GaussianSettings::default() }
}

fn hit(hits: &[Hit], x: u32, y: u32) -> Hit {
    *hits.iter().find(|hit| (hit.x, hit.y) == (x, y)).unwrap_or_else(|| panic!("({x}, {y}) is not covered"))
}

/// Numbers in [0, 1) that are spread evenly, of many sequences: multiples of irrational numbers, less their whole part.
fn spread(step: usize, sequence: usize) -> f64 {
    const PRIMES: [f64; 12] = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0];
    (step as f64 * PRIMES[sequence].sqrt()).fract()
}

/// Splats of all shapes and tilts, from balls to needles and flat ones, in and around the image of [`perspective`].
fn varied(count: usize, thinnest: f64) -> Vec<Splatted> {
    let each = |i: usize| {
        let z = 2.0 + 10.0 * spread(i, 0);
        let place = DVec2::new(spread(i, 1) - 0.5, spread(i, 2) - 0.5) * 2.2 * z;
        let size = 0.05 * z * (1.0 + 6.0 * spread(i, 3));
        let extents = [4, 5, 6].map(|s| (size * thinnest.powf(spread(i, s))) as f32);
        let turn = [7, 8, 9, 10].map(|s| 2.0 * spread(i, s) - 1.0);
        let rotation = DQuat::from_array(turn).normalize().as_quat();
        Splatted(place.extend(-z), Vec3::from(extents), rotation, 0.05 + 0.95 * spread(i, 11) as f32)
    };
    (0..count).map(each).collect()
}

/// Σ in camera coordinates.
fn covariance(camera: &Camera, gaussian: &Gaussian) -> DMat3 {
    let to_view = DMat3::from_cols(camera.right, camera.up, camera.forward).transpose();
    let axes = to_view * gaussian.axes;
    axes * axes.transpose()
}

/// Start and direction of the ray through a pixel's center, in camera coordinates; z of the direction is 1.
fn ray_through(camera: &Camera, x: u32, y: u32) -> (DVec3, DVec3) {
    let place = DVec2::new(f64::from(x) - 4.0, 4.0 - f64::from(y)) / camera.focal_px(SIZE[1]);
    match camera.projection {
        Projection::Perspective { .. } => (DVec3::ZERO, place.extend(1.0)),
        Projection::Orthographic { .. } => (place.extend(0.0), DVec3::Z),
    }
}
