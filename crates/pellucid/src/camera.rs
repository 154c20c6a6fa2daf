//! Camera of a picture.

use std::path::Path;

use glam::DVec3;
use pellucid_scene::{CameraSettings, PictureCamera};

use crate::Result;
use crate::error::of_engine;

/// Camera in world units. The world is right-handed, and +Y of the camera points to the top of the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera(pub(crate) CameraSettings);

impl Camera {
    /// Creates a camera at `eye` that looks at `target`, with `up` toward the top of the image and a vertical field of
    /// view of 45°.
    ///
    /// The near and far limits are chosen so that all points in front of the camera are drawn.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Self {
        let [eye, target, up] = [eye, target, up].map(|v| Some(DVec3::from_array(v)));
        Self(CameraSettings { eye, target, up, ..CameraSettings::default() })
    }

    /// Returns the camera with which a picture was rendered, from the metadata of its PNG or EXR. Rendered through it,
    /// the same scene at the same size has the same pixels.
    ///
    /// # Errors
    /// Returns an error if the file can't be read, is no picture, or holds no camera.
    pub fn of_picture(path: impl AsRef<Path>) -> Result<Self> {
        Ok(Self(PictureCamera::read(path.as_ref()).map_err(of_engine)?.camera))
    }

    /// Makes the view a perspective one with a full vertical angle in degrees, above 0 and below 180.
    #[must_use]
    pub fn perspective(self, fov_y: f64) -> Self {
        Self(CameraSettings { fov_y: Some(fov_y), height: None, ..self.0 })
    }

    /// Makes the view an orthographic one. `height` is the height of the image in world units, above 0.
    #[must_use]
    pub fn orthographic(self, height: f64) -> Self {
        Self(CameraSettings { fov_y: None, height: Some(height), ..self.0 })
    }

    /// Limits drawing to depths from `near` to `far` along the view, in world units. `near` must be above 0 and below
    /// `far`.
    #[must_use]
    pub fn clip(self, near: f64, far: f64) -> Self {
        Self(CameraSettings { near: Some(near), far: Some(far), ..self.0 })
    }

    pub(crate) fn is_valid(&self) -> bool {
        let CameraSettings { fov_y, height, near, far, .. } = self.0;
        fov_y.is_none_or(|degrees| degrees > 0.0 && degrees < 180.0)
            && height.is_none_or(|height| height > 0.0 && height.is_finite())
            && near.zip(far).is_none_or(|(near, far)| near > 0.0 && near < far && far.is_finite())
    }
}
