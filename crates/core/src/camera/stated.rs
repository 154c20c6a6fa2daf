//! Cameras that a few numbers give again, to the last bit.

use std::ops::Deref;

use glam::DVec3;

use super::{Camera, Projection};

/// The least distance of a target that is made, as a share of the eye's coordinates: nearer ones would be lost in the
/// rounding of theirs.
const LEAST_REACH: f64 = 1e-6;

/// Units in the last place that an angle in degrees is searched among.
const SEARCHED: u32 = 4;

/// A camera, and the numbers of `[camera]` in a scene file that give it again, to the last bit.
///
/// Axes of unit length can't be written as a target without rounding. Therefore the numbers come first, and the axes
/// follow from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedCamera {
    camera: Camera,
    target: DVec3,
    stated_up: DVec3,
}

impl StatedCamera {
    /// Returns the camera at `eye` that looks at `target`, with depths from `near` to `far`. `None` if the two points
    /// coincide or `up` is parallel to the view. An angle should be one of [`in_degrees`].
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, projection: Projection, near: f64, far: f64) -> Option<Self> {
        let forward = (target - eye).try_normalize()?;
        // Axes are computed around the origin: far from it, eye + direction would be rounded.
        let axes = Camera::look_at(DVec3::ZERO, forward, up, projection, near, far)?;
        Some(Self { camera: Camera { eye, ..axes }, target, stated_up: up })
    }

    /// Returns the camera nearest to another one: its axes are those of a target at about this distance, and of an `up`
    /// that has the direction of the image's top, though perhaps not at a right angle to the view. `None` if rounding
    /// leaves nothing of the distance, or for an `up` along the view.
    pub fn nearest(camera: &Camera, distance: f64, up: DVec3) -> Option<Self> {
        let Camera { eye, forward, projection, near, far, .. } = *camera;
        let projection = match projection {
            Projection::Perspective { fov_y } => Projection::Perspective { fov_y: in_degrees(fov_y).to_radians() },
            orthographic => orthographic,
        };
        Self::look_at(eye, eye + forward * reach(eye, distance), up, projection, near, far)
    }

    /// Returns the same camera with other depths.
    #[must_use]
    pub fn with_depths(self, near: f64, far: f64) -> Self {
        Self { camera: Camera { near, far, ..self.camera }, ..self }
    }

    /// Returns the camera alone.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Returns the point at the middle of the image, in world units.
    pub fn target(&self) -> DVec3 {
        self.target
    }

    /// Returns the direction that points up in the image, of any length, and not always at a right angle to the view.
    pub fn stated_up(&self) -> DVec3 {
        self.stated_up
    }

    /// Returns the full vertical angle in degrees, of a perspective camera.
    pub fn fov_y(&self) -> Option<f64> {
        match self.camera.projection {
            Projection::Perspective { fov_y } => Some(in_degrees(fov_y)),
            Projection::Orthographic { .. } => None,
        }
    }

    /// Returns the height of the image in world units, of an orthographic camera.
    pub fn height(&self) -> Option<f64> {
        match self.camera.projection {
            Projection::Perspective { .. } => None,
            Projection::Orthographic { height } => Some(height),
        }
    }

    /// Returns the keys of `[camera]` that give this camera, as lines of TOML.
    pub fn to_toml(&self) -> String {
        let Self { camera: Camera { eye, near, far, .. }, target, stated_up: up } = self;
        let [eye, target, up] = [eye, target, up].map(|v| v.to_array());
        let lens = match (self.fov_y(), self.height()) {
            (Some(fov_y), _) => format!("fov_y = {fov_y:?}"),
            (None, height) => format!("height = {:?}", height.unwrap_or_default()),
        };
        format!("eye = {eye:?}\ntarget = {target:?}\nup = {up:?}\n{lens}\nnear = {near:?}\nfar = {far:?}\n")
    }
}

impl Deref for StatedCamera {
    type Target = Camera;

    fn deref(&self) -> &Camera {
        &self.camera
    }
}

impl From<StatedCamera> for Camera {
    fn from(stated: StatedCamera) -> Self {
        stated.camera
    }
}

/// Returns a distance at which a target can be told from an eye: this one, if it is positive and not too short.
pub fn reach(eye: DVec3, distance: f64) -> f64 {
    let distance = if distance > 0.0 && distance.is_finite() { distance } else { 1.0 };
    distance.max(LEAST_REACH * eye.abs().max_element())
}

/// Returns the angle in degrees that becomes this one in radians, the shortest if there are several. Of angles that no
/// number of degrees becomes exactly it returns the nearest.
pub fn in_degrees(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    let steps = |step: fn(f64) -> f64| std::iter::successors(Some(degrees), move |x| Some(step(*x)));
    let around = steps(f64::next_up).zip(steps(f64::next_down)).take(1 + SEARCHED as usize);
    let rounded = [1e6, 1e9].map(|scale| (degrees * scale).round() / scale);
    let mut tried = rounded.into_iter().chain(around.flat_map(|(above, below)| [above, below]));
    tried.find(|degrees| degrees.to_radians() == radians).unwrap_or(degrees).clamp(f64::MIN_POSITIVE, BELOW_STRAIGHT)
}

/// The largest number below 180.
const BELOW_STRAIGHT: f64 = f64::from_bits(180f64.to_bits() - 1);

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn degrees_come_back_as_they_were_given() {
        for degrees in [45.0, 33.3, 60.0, 0.1, 1e-5, 54.432_222_311_465_3, 179.999, 90.000_000_1] {
            assert_eq!(in_degrees(f64::to_radians(degrees)), degrees);
        }
        // Neighbors of each angle, of which some become the same radians.
        let mut degrees = 1.234_567_890_123_4;
        while degrees < 180.0 {
            let radians = f64::to_radians(degrees);
            assert_eq!(in_degrees(radians).to_radians(), radians, "{degrees}");
            degrees = degrees.next_up() * 1.000_37;
        }
        // Every angle becomes one that comes back.
        for radians in [1.2, 2.0, 1.999_999_999_9, PI.next_down(), 1e-300] {
            let snapped = in_degrees(radians).to_radians();
            assert!((snapped - radians).abs() <= 1e-15 * radians && in_degrees(snapped).to_radians() == snapped);
        }
        assert!(in_degrees(PI) < 180.0);
    }
}
