//! Blocks of points that may show in a window: those of which anything reaches it, and no other ones as far as their
//! boxes tell.

use glam::DVec3;
use rayon::prelude::*;

use crate::camera::{Camera, Projection};
use crate::cloud::gaussians::REACH;
use crate::passes::bands::Window;
use crate::scene::{GaussianSettings, Kernel};
use crate::supply::Block;

/// Reach of a point beyond its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointExtent {
    /// Radius in the frame over that of the cloud.
    pub radius: f64,
    /// Pixels of the image to each side.
    pub pixels: f64,
}

/// The half of a pixel that roundings may take, and another half for the pixel around a center.
const ONE: f64 = 1.0;
/// Largest distance that roundings of float32 and here may move a point, as a share of its coordinates from the eye.
const ROUNDING: f64 = 1e-6;

/// Slopes of a Gaussian's center are clamped to so many times those of the image's sides (`clamped_slopes` in WGSL).
const SLOPE: f64 = 1.3;

impl PointExtent {
    /// Discs of the cloud's radii times a factor.
    pub fn discs(factor: f32) -> Self {
        Self { radius: factor.into(), pixels: ONE }
    }

    /// Squares whose half sides are these.
    pub fn squares(factor: f32) -> Self {
        Self { radius: std::f64::consts::SQRT_2 * f64::from(factor), pixels: ONE }
    }

    /// Returns Gaussians whose radii are their [`REACH`], at the least opacity of a fragment that settings name.
    pub fn gaussians(settings: &GaussianSettings, camera: &Camera, size: [u32; 2]) -> Self {
        let GaussianSettings { alpha_min, dilation, kernel, .. } = *settings;
        // Standard deviations at which opacity 1 falls to the least one.
        let deviations = (-2.0 * f64::from(alpha_min).ln()).max(0.0).sqrt();
        let radius = deviations / f64::from(REACH);
        match kernel {
            // Where a ray passes the ellipsoid, and where it is densest along the ray, is a matter of space alone.
            Kernel::Ray => Self { radius, pixels: ONE },
            // Its semi-axes are the standard deviations, whatever the least opacity.
            Kernel::Ellipsoid => Self { radius: 1.0 / f64::from(REACH), pixels: ONE },
            // Along an axis of the screen an ellipse reaches √(σ²·(1 + slope²)·(focal / z)² + dilation) deviations at
            // most. The slope is that of the center, but at most 1.3 times that of the image's side.
            Kernel::Ewa => {
                let slope = match camera.projection {
                    Projection::Perspective { .. } => {
                        let side = f64::from(size[0].max(size[1]));
                        SLOPE * 0.5 * side / camera.focal_px(size[1])
                    }
                    Projection::Orthographic { .. } => 0.0,
                };
                Self { radius: radius * slope.hypot(1.0), pixels: ONE + deviations * f64::from(dilation).sqrt() }
            }
        }
    }

    /// Returns the farther of two reaches.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { radius: self.radius.max(other.radius), pixels: self.pixels.max(other.pixels) }
    }

    /// Returns points without a radius that show this many pixels around their own.
    pub fn pixels(around: f64) -> Self {
        Self { radius: 0.0, pixels: ONE + around }
    }
}

/// A half-space a·p + b ≥ 0 in camera coordinates (right, down, forward), |a| its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    normal: DVec3,
    offset: f64,
    length: f64,
}

impl Side {
    fn new(normal: DVec3, offset: f64) -> Self {
        Self { normal, offset, length: normal.length() }
    }
}

/// The part of space that a window shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    axes: [DVec3; 3],
    eye: DVec3,
    sides: [Side; 6],
    /// The factor on radii.
    radius: f64,
}

impl Beam {
    /// Returns what a window of an image of this size shows of points with this extent.
    pub fn new(camera: &Camera, size: [u32; 2], window: Window, extent: PointExtent) -> Self {
        let Camera { eye, right, up, forward, near, far, .. } = *camera;
        let focal = camera.focal_px(size[1]);
        let middle = size.map(|side| 0.5 * f64::from(side));
        let low = [0, 1].map(|axis| f64::from(window[axis]) - extent.pixels - middle[axis]);
        let high = [0, 1].map(|axis| f64::from(window[axis + 2]) + extent.pixels - middle[axis]);
        // Pixels from the middle: focal · x / z, or focal · x.
        let side = |axis: DVec3, edge: f64, sign: f64| match camera.projection {
            Projection::Perspective { .. } => Side::new(sign * (focal * axis - edge * DVec3::Z), 0.0),
            Projection::Orthographic { .. } => Side::new(sign * focal * axis, -sign * edge),
        };
        let sides = [
            side(DVec3::X, low[0], 1.0),
            side(DVec3::X, high[0], -1.0),
            side(DVec3::Y, low[1], 1.0),
            side(DVec3::Y, high[1], -1.0),
            Side::new(DVec3::Z, -near),
            Side::new(DVec3::NEG_Z, far),
        ];
        // A millionth more than the radius, for roundings here and in float32.
        Self { axes: [right, -up, forward], eye, sides, radius: 1.000_001 * extent.radius }
    }

    fn view(&self, p: DVec3) -> DVec3 {
        let p = p - self.eye;
        DVec3::from(self.axes.map(|axis| p.dot(axis)))
    }

    /// Returns `true` if anything of a block may show.
    pub fn meets(&self, block: &Block) -> bool {
        let corners = block.bounds.corners().map(|corner| self.view(corner));
        let size = corners.iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
        let slack = self.radius * f64::from(block.radius) + ROUNDING * size;
        self.sides.iter().all(|side| {
            let most = corners.iter().map(|corner| side.normal.dot(*corner)).fold(f64::NEG_INFINITY, f64::max);
            most + side.offset >= -slack * side.length
        })
    }

    /// Returns `true` if anything of a point with this radius may show.
    pub fn meets_point(&self, position: DVec3, radius: f32) -> bool {
        let p = self.view(position);
        let slack = self.radius * f64::from(radius) + ROUNDING * p.abs().max_element();
        self.sides.iter().all(|side| side.normal.dot(p) + side.offset >= -slack * side.length)
    }

    /// Returns the blocks of which anything may show, in ascending order.
    pub fn pick(&self, blocks: &[Block]) -> Vec<u32> {
        let all = blocks.par_iter().enumerate().with_min_len(1 << 8);
        all.filter(|(_, block)| self.meets(block)).map(|(i, _)| i as u32).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::cloud::Bounds;

    fn camera(projection: Projection) -> Camera {
        let eye = DVec3::new(1.0, -6.0, 2.0);
        Camera::look_at(eye, DVec3::ZERO, DVec3::Z, projection, 0.5, 20.0).expect("a camera")
    }

    #[test]
    fn whatever_shows_is_picked_and_little_else() {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        for projection in [Projection::Perspective { fov_y: 0.8 }, Projection::Orthographic { height: 5.0 }] {
            let (camera, size) = (camera(projection), [64, 48]);
            let window = [10, 20, 30, 25];
            let beam = Beam::new(&camera, size, window, PointExtent::discs(1.0));
            let (mut picked, mut showing) = (0, 0);
            for _ in 0..20_000 {
                let place = |random: &mut Pcg64Mcg| DVec3::from([(); 3].map(|()| random.random_range(-4.0..4.0)));
                let min = place(&mut random);
                let max = min + DVec3::from([(); 3].map(|()| random.random_range(0.0..0.3)));
                let radius = random.random_range(0.0..0.2f32);
                let block = Block { bounds: Bounds { min, max }, radius, points: 1, branch: None };
                let is_picked = beam.meets(&block);
                picked += u32::from(is_picked);
                // Discs at places of the block that face the viewer.
                let shows = (0..20).any(|_| {
                    let inside = min + (max - min) * DVec3::from([(); 3].map(|()| random.random::<f64>()));
                    let (pixel, z) = camera.project(inside, size);
                    let reach = f64::from(radius) * camera.pixels_per_unit(z, size[1]);
                    let beyond = |axis: usize, at: f64| {
                        let (low, high) = (f64::from(window[axis]), f64::from(window[axis + 2]));
                        at - at.clamp(low, high)
                    };
                    let apart = beyond(0, pixel.x).hypot(beyond(1, pixel.y));
                    let shows = z >= camera.near && z <= camera.far && apart <= reach;
                    assert!(beam.meets_point(inside, radius) || !shows, "{inside}");
                    shows
                });
                showing += u32::from(shows);
                assert!(is_picked || !shows, "{block:?}");
            }
            // Boxes and balls are larger than what shows of them.
            assert!(showing > 50 && picked < 3 * showing, "{showing} of {picked}");
        }
    }
}
