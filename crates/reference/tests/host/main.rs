//! Cases worked by hand that check the float64 references. No device is needed.
//!
//! Most of them look through a camera at the origin along −Z whose image plane has one pixel per world unit
//! ([`orthographic`]), so that a point's z is minus its third coordinate and offsets in pixels are plain differences.

use glam::{DVec3, Vec3};

use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_reference::abuffer::{Composite, Fragment, composite, depth_margin, lists, lists_at};
use pellucid_reference::coverage::{Coverage, Shape, Splat, footprint, margin_px};
use pellucid_reference::{ReferencePicture, View, abuffer, scan, shading, sorted};
use pellucid_scene::{
    ColorSpace, DiscShape, Discs, Edl, Falloff, GaussianSettings, Light, Relief, ScreenSplats, Shading, ShadingModel,
};

/// Rounding of a few dozen float64 operations on values of order 10.
const ROUNDING: f64 = 1e-12;
/// The image of most cases; pixel (4, 4) is in the middle, its center on the optical axis.
const SIZE: [u32; 2] = [9, 9];

fn camera(projection: Projection) -> Camera {
    Camera::look_at(DVec3::ZERO, -DVec3::Z, DVec3::Y, projection, 0.5, 100.0).unwrap()
}

fn orthographic() -> Camera {
    camera(Projection::Orthographic { height: 9.0 })
}

/// 90° over 9 pixels: 4.5 pixels per unit at z = 1.
fn perspective() -> Camera {
    camera(Projection::Perspective { fov_y: std::f64::consts::FRAC_PI_2 })
}

fn flat(shape: Shape, position: DVec3, radius: f64) -> Splat {
    Splat { position, radius, normal: None, shape, max_pixel_radius: f64::INFINITY }
}

fn oriented(position: DVec3, radius: f64, normal: DVec3) -> Splat {
    Splat { normal: Some(normal), ..flat(Shape::Oriented, position, radius) }
}

/// The normal of a disc turned by `degrees` about the vertical; on it z grows by tan(degrees) per unit to the right.
fn tilted(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(sin, 0.0, cos)
}

fn pixels(covered: &[Coverage]) -> Vec<(u32, u32)> {
    covered.iter().map(|c| (c.x, c.y)).collect()
}

fn at(covered: &[Coverage], x: u32, y: u32) -> Coverage {
    *covered.iter().find(|c| (c.x, c.y) == (x, y)).unwrap_or_else(|| panic!("({x}, {y}) is not covered"))
}

#[track_caller]
fn assert_close(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{got} differs from {want} by more than {tolerance}");
}

mod abuffer_lists;
mod approximations;
mod blended_splats;
mod compositing;
mod coverage;
mod edl;
mod gaussians;
mod image_space;
mod margins;
mod mlab;
mod moments;
mod opaque;
mod oriented_discs;
mod peel_layers;
mod peeling;
mod random_stacks;
mod ranges;
mod samples;
mod shaded;
mod shadows;
mod soft_approximations;
mod soft_density;
mod soft_spheres;
mod sorted_splats;
mod spbr_images;
mod stochastic_samples;
mod wavelet;

#[test]
fn prefix_sums() {
    assert_eq!(scan::exclusive(&[]), [0]);
    assert_eq!(scan::exclusive(&[3, 0, 4]), [0, 3, 3, 7]);
    // Beyond 32 bits without wrapping.
    assert_eq!(scan::exclusive(&[u32::MAX; 3]), [0, 0xffff_ffff, 0x1_ffff_fffe, 0x2_ffff_fffd]);
}
