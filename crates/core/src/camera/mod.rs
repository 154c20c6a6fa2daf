//! The camera in float64: a right-handed world, the camera looks along its −Z with +Y up.
//!
//! Everywhere in the crate `z` is the positive distance along the viewing axis and pixel (0, 0) is at the top left.

pub mod import;
pub mod path;
mod stated;

pub use stated::{StatedCamera, in_degrees, reach};

use glam::{DVec2, DVec3};

/// The effect of depth on size.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Projection {
    /// Vertical field of view in radians, in (0, π).
    Perspective {
        /// Full vertical angle in radians.
        fov_y: f64,
    },
    /// World units over the image's height.
    Orthographic {
        /// Positive height in world units.
        height: f64,
    },
}

/// A resolved camera: orthonormal axes, projection, depth range.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Camera {
    /// Eye in world units.
    pub eye: DVec3,
    /// Unit vector toward the image's right.
    pub right: DVec3,
    /// Unit vector toward the image's top.
    pub up: DVec3,
    /// Unit viewing direction.
    pub forward: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Points with z < near are not drawn.
    pub near: f64,
    /// Points with z > far are not drawn.
    pub far: f64,
    /// Pixels, x right and y down, by which every projected position is moved: (0, 0) except in the images whose mean
    /// is a picture of several samples per pixel. Near, far and the axes stay as they are.
    pub shift: DVec2,
}

impl Camera {
    /// Returns a camera at `eye` that looks at `target`. `None` if the two coincide or `up` is parallel to the view.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, projection: Projection, near: f64, far: f64) -> Option<Self> {
        let forward = (target - eye).try_normalize()?;
        let up = up.try_normalize()?;
        // The cross product of unit vectors is the sine of their angle: below 1e-6 the image's up is rounding noise.
        let right = forward.cross(up);
        if right.length() < 1e-6 {
            return None;
        }
        let right = right.normalize();
        Some(Self { eye, right, up: right.cross(forward), forward, projection, near, far, shift: DVec2::ZERO })
    }

    /// Returns camera coordinates (right, up, z) of a world position; z is positive before the camera.
    pub fn to_view(&self, world: DVec3) -> DVec3 {
        let p = world - self.eye;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.forward))
    }

    /// Returns pixels over one world unit at depth 1 (perspective) or anywhere (orthographic).
    pub fn focal_px(&self, image_height: u32) -> f64 {
        match self.projection {
            Projection::Perspective { fov_y } => f64::from(image_height) / (2.0 * (0.5 * fov_y).tan()),
            Projection::Orthographic { height } => f64::from(image_height) / height,
        }
    }

    /// Pixel position (x right, y down, pixel (i, j) has its center at (i + 0.5, j + 0.5)) and z of a world position.
    pub fn project(&self, world: DVec3, size: [u32; 2]) -> (DVec2, f64) {
        let view = self.to_view(world);
        let scale = self.pixels_per_unit(view.z, size[1]);
        (self.middle(size) + DVec2::new(view.x, -view.y) * scale, view.z)
    }

    /// Returns where the viewing axis meets an image of this size: pixels from its upper left corner, x right, y down.
    pub fn middle(&self, size: [u32; 2]) -> DVec2 {
        0.5 * DVec2::new(f64::from(size[0]), f64::from(size[1])) + self.shift
    }

    /// Returns pixels per world unit at depth `z`: the factor from a world radius to pixels.
    pub fn pixels_per_unit(&self, z: f64, image_height: u32) -> f64 {
        match self.projection {
            Projection::Perspective { .. } => self.focal_px(image_height) / z,
            Projection::Orthographic { .. } => self.focal_px(image_height),
        }
    }
}
