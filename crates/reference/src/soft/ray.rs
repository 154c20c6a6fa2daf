//! A pixel's ray against a sphere.

use glam::{DVec2, DVec3};

use crate::View;
use pellucid_core::camera::Projection;

/// The ray through a pixel's center, in camera coordinates (right, up, z).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The point with s = 0: the eye (perspective), or the pixel's position on the plane z = 0.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// 1/cos φ: s is this times z.
    pub stretch: f64,
}

/// The intersection of a ray and a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Distance d of the ray from the sphere's center.
    pub distance: f64,
    /// s of the chord's middle.
    pub middle: f64,
    /// Half the chord's length.
    pub half: f64,
}

impl Ray {
    /// Makes the ray through the center of pixel (x, y).
    pub fn new(view: View, [x, y]: [u32; 2]) -> Self {
        let DVec2 { x: right, y: up } = view.on_plane(DVec2::new(f64::from(x), f64::from(y)) + 0.5);
        match view.camera.projection {
            Projection::Perspective { .. } => {
                let through = DVec3::new(right, up, 1.0);
                Self { origin: DVec3::ZERO, direction: through.normalize(), stretch: through.length() }
            }
            Projection::Orthographic { .. } => {
                Self { origin: DVec3::new(right, up, 0.0), direction: DVec3::Z, stretch: 1.0 }
            }
        }
    }

    /// Returns the chord through a sphere, `None` unless d < r. Its position along the ray doesn't matter.
    pub fn meet(&self, center: DVec3, radius: f64) -> Option<Chord> {
        let to_center = center - self.origin;
        let distance = to_center.cross(self.direction).length();
        let half = ((radius - distance) * (radius + distance)).sqrt();
        (distance < radius).then(|| Chord { distance, middle: to_center.dot(self.direction), half })
    }
}
