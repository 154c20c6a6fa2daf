//! The camera of a picture.

use glam::DVec3;
use pellucid_engine::scene::CameraSettings;

/// A camera in world units: a right-handed world, +Y of the camera toward the top of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera(pub(crate) CameraSettings);

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` toward the top of the image and a vertical field of view of
    /// 45°.
    ///
    /// Near and far are chosen so that all points in front of the camera are drawn.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Self {
        let [eye, target, up] = [eye, target, up].map(|v| Some(DVec3::from_array(v)));
        Self(CameraSettings { eye, target, up, ..CameraSettings::default() })
    }

    /// A perspective view with a full vertical angle in degrees, above 0 and below 180.
    #[must_use]
    pub fn perspective(self, fov_y: f64) -> Self {
        Self(CameraSettings { fov_y: Some(fov_y), height: None, ..self.0 })
    }

    /// An orthographic view: world units over the image's height, above 0.
    #[must_use]
    pub fn orthographic(self, height: f64) -> Self {
        Self(CameraSettings { fov_y: None, height: Some(height), ..self.0 })
    }

    /// Limits drawing to depths between these two along the view, in world units; near is above 0 and below far.
    #[must_use]
    pub fn depths(self, near: f64, far: f64) -> Self {
        Self(CameraSettings { near: Some(near), far: Some(far), ..self.0 })
    }

    pub(crate) fn is_valid(&self) -> bool {
        let CameraSettings { fov_y, height, near, far, .. } = self.0;
        fov_y.is_none_or(|degrees| degrees > 0.0 && degrees < 180.0)
            && height.is_none_or(|height| height > 0.0 && height.is_finite())
            && near.zip(far).is_none_or(|(near, far)| near > 0.0 && near < far && far.is_finite())
    }
}
