//! Size of lengths in a picture, by how far from the eye they are.

use glam::DVec3;

use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;

/// Pixels of lengths in a picture: by the distance from the eye, so that looking around changes none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    eye: DVec3,
    focal_px: f64,
    /// Least distance that counts; `None` where distances don't.
    nearest: Option<f64>,
}

impl Scale {
    /// Scale of a camera's picture with so many rows of pixels.
    pub fn new(camera: &Camera, rows: u32) -> Self {
        let nearest = match camera.projection {
            Projection::Perspective { .. } => Some(camera.near.max(f64::MIN_POSITIVE)),
            Projection::Orthographic { .. } => None,
        };
        Self { eye: camera.eye, focal_px: camera.focal_px(rows), nearest }
    }

    fn px_from(&self, distance: f64) -> f64 {
        self.nearest.map_or(self.focal_px, |nearest| self.focal_px / distance.max(nearest))
    }

    /// Returns pixels of a world unit at a place.
    pub fn px(&self, place: DVec3) -> f64 {
        self.px_from(place.distance(self.eye))
    }

    /// Returns pixels of a world unit at the nearest place of a box.
    pub fn most_px(&self, bounds: &Bounds) -> f64 {
        self.px(self.eye.clamp(bounds.min, bounds.max))
    }

    /// Returns pixels of a world unit at the farthest place of a box.
    pub fn least_px(&self, bounds: &Bounds) -> f64 {
        let apart = (self.eye - bounds.min).abs().max((self.eye - bounds.max).abs());
        self.px_from(apart.length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_fall_with_the_distance_of_a_perspective_alone() {
        let camera =
            |projection| Camera::look_at(DVec3::ZERO, DVec3::X, DVec3::Z, projection, 0.5, 20.0).expect("a camera");
        // 100 rows over 2 units at distance 1.
        let scale = Scale::new(&camera(Projection::Perspective { fov_y: std::f64::consts::FRAC_PI_2 }), 100);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
        close(scale.px(DVec3::new(0.0, -4.0, 3.0)), 10.0);
        // Nothing is nearer than the near plane.
        close(scale.px(DVec3::ZERO), 100.0);
        let bounds = Bounds { min: DVec3::new(3.0, -4.0, -1.0), max: DVec3::new(5.0, 0.0, 12.0) };
        close(scale.most_px(&bounds), 50.0 / 3.0);
        close(scale.least_px(&bounds), 50.0 / (25f64 + 16.0 + 144.0).sqrt());
        let flat = Scale::new(&camera(Projection::Orthographic { height: 4.0 }), 100);
        assert_eq!([flat.px(DVec3::ZERO), flat.most_px(&bounds), flat.least_px(&bounds)], [25.0; 3]);
    }
}
