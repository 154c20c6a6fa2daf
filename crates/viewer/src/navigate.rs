//! The camera's position and movements, in float64, independent of the window.
//!
//! The camera turns about a pivot as on a turntable: around the vertical, and up and down until it looks straight down
//! or up, where it stops. Its axes follow from the two angles, so they never flip.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};

use pellucid_core::camera::{Camera, Projection, path};
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_scene::{CameraSettings, DEFAULT_FOV_Y, Vertical, View, camera_at};

/// Distances in this range, in reaches of the scene, are as far as one gets.
const DISTANCES: [f64; 2] = [1e-6, 1e3];

/// Cosine of the elevation above which the vertical defines up. Closer to straight views that would magnify rounding.
const LEVEL: f64 = 0.05;

/// The axes the camera turns around.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turntable {
    vertical: DVec3,
    /// The direction of azimuth 0.
    front: DVec3,
    /// The direction of azimuth 90°.
    side: DVec3,
}

impl Turntable {
    fn with_vertical(vertical: Vertical) -> Self {
        Self { vertical: vertical.up(), front: vertical.front(), side: vertical.right() }
    }

    /// The vertical of the scene if the camera is level with it, else +Z or +Y if it is with that, else the image's.
    fn level_with(camera: &Camera, vertical: Vertical) -> Self {
        let level =
            |table: &Self| camera.right.dot(table.vertical).abs() < 1e-6 && camera.up.dot(table.vertical) > -1e-9;
        let own = Self { vertical: camera.up, front: -camera.forward, side: camera.right };
        let verticals = [vertical, UpAxis::Z.into(), UpAxis::Y.into()];
        verticals.map(Self::with_vertical).into_iter().find(level).unwrap_or(own)
    }
}

/// Where a picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pose {
    /// The scene's own camera.
    Scene,
    /// A camera with perspective that sees everything from the direction of a view.
    View(View),
    /// A camera whose eye, target and up are given.
    At(CameraSettings),
}

/// The extent of the scene the camera looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSubject {
    /// The box around all points.
    pub bounds: Bounds,
    /// The largest radius of a point.
    pub radius: f64,
    /// The vertical of the files.
    pub up: UpAxis,
    /// The vertical of the scene: that of its camera's `up` if it gives one, else that of the files.
    pub vertical: Vertical,
}

impl CameraSubject {
    /// The distance from its center to its farthest part, above 0.
    pub fn reach(&self) -> f64 {
        let reach = 0.5 * self.bounds.diagonal() + self.radius;
        if reach > 0.0 && reach.is_finite() { reach } else { 1.0 }
    }
}

/// The camera's place, direction and projection, and the point that it turns about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Navigator {
    table: Turntable,
    subject: CameraSubject,
    eye: DVec3,
    /// Radians around the vertical.
    azimuth: f64,
    /// Radians above the horizon, from −π/2 to π/2.
    elevation: f64,
    pivot: DVec3,
    /// Degrees, in (0, 180).
    fov_y: f64,
    /// World units over the image's height, of an orthographic camera.
    height: Option<f64>,
}

impl Navigator {
    /// The navigator that starts from a camera of the scene. Its pivot lies in the middle of the picture, at the
    /// distance of the scene's center.
    pub fn new(camera: &Camera, fov_y: Option<f64>, subject: CameraSubject) -> Self {
        let table = Turntable::level_with(camera, subject.vertical);
        let (vertical, forward) = (table.vertical, camera.forward);
        let sine = -forward.dot(vertical);
        let elevation = sine.atan2((forward + sine * vertical).length());
        let level = |direction: DVec3| direction - direction.dot(vertical) * vertical;
        // In straight views the first term defines the azimuth, in level views the second.
        let outward = -(level(forward) * elevation.cos() + level(camera.up) * elevation.sin());
        let azimuth = outward.dot(table.side).atan2(outward.dot(table.front));
        let (eye, height) = match camera.projection {
            Projection::Perspective { .. } => (camera.eye, None),
            Projection::Orthographic { height } => (camera.eye, Some(height)),
        };
        let to_center = (subject.bounds.center() - eye).dot(forward);
        let depth = if to_center > 0.0 { to_center } else { subject.reach() };
        let pivot = eye + forward * depth;
        Self { table, subject, eye, azimuth, elevation, pivot, fov_y: fov_y.unwrap_or(DEFAULT_FOV_Y), height }
    }

    /// The navigator of a camera with eye, target and up; it turns about the target. `None` if these make no camera.
    pub fn at(settings: &CameraSettings, subject: CameraSubject) -> Option<Self> {
        let camera = camera_at(settings, &subject.bounds, subject.radius)?;
        let mut navigator = Self::new(&camera, settings.fov_y, subject);
        navigator.pivot = settings.target?;
        Some(navigator)
    }

    /// The extent of the scene.
    pub fn subject(&self) -> CameraSubject {
        self.subject
    }

    /// The direction around which it turns, a unit vector.
    pub fn vertical(&self) -> DVec3 {
        self.table.vertical
    }

    /// Unit vectors toward the image's right and top, and along the view.
    pub fn axes(&self) -> [DVec3; 3] {
        let (sin_a, cos_a) = self.azimuth.sin_cos();
        let (sin_e, cos_e) = self.elevation.sin_cos();
        let outward = self.table.front * cos_a + self.table.side * sin_a;
        let forward = -(outward * cos_e + self.table.vertical * sin_e);
        let up = self.table.vertical * cos_e - outward * sin_e;
        [forward.cross(up), up, forward]
    }

    /// The point that the camera turns about.
    pub fn pivot(&self) -> DVec3 {
        self.pivot
    }

    /// Lets the camera turn about another point; the picture stays.
    pub fn set_pivot(&mut self, point: DVec3) {
        if point.is_finite() {
            self.pivot = point;
        }
    }

    /// True if the projection is orthographic.
    pub fn is_orthographic(&self) -> bool {
        self.height.is_some()
    }

    /// The settings of a scene file for this camera; `near` and `far` are those of the scene.
    pub fn settings(&self, near: Option<f64>, far: Option<f64>) -> CameraSettings {
        let [_, up, forward] = self.axes();
        // Cameras of one vertical keep their horizon level when a path leads from one to the other. In straight views
        // the vertical is along the view and turns nothing, but it becomes the axis nearest to `up`, which views of a
        // saved scene refer to.
        let vertical = self.table.vertical;
        let up = if self.elevation.cos() > LEVEL { vertical } else { up + 2.0 * vertical };
        let eye = self.eye - forward * self.retreat();
        let target = eye + forward * self.depth(self.pivot, eye);
        CameraSettings {
            eye: Some(eye),
            target: Some(target),
            up: Some(up),
            fov_y: self.height.is_none().then_some(self.fov_y),
            height: self.height,
            near,
            far,
            ..CameraSettings::default()
        }
    }

    /// Returns the distance by which an orthographic eye must move back to have all of the scene in front of it; the
    /// picture doesn't change.
    fn retreat(&self) -> f64 {
        let [.., forward] = self.axes();
        let center = (self.subject.bounds.center() - self.eye).dot(forward);
        if self.height.is_some() { (1.1 * self.subject.reach() - center).max(0.0) } else { 0.0 }
    }

    /// Depth of a point before an eye; for one behind it that of something there.
    fn depth(&self, point: DVec3, eye: DVec3) -> f64 {
        let [.., forward] = self.axes();
        let (depth, reach) = ((point - eye).dot(forward), self.subject.reach());
        if depth > DISTANCES[0] * reach { depth } else { reach }
    }

    /// World units of a pixel at the pivot, in an image of this height.
    fn unit(&self, image_height: f64) -> f64 {
        match self.height {
            Some(height) => height / image_height,
            None => 2.0 * self.depth(self.pivot, self.eye) * (0.5 * self.fov_y.to_radians()).tan() / image_height,
        }
    }

    /// Turns by a drag of the pointer, in pixels to the right and down: half a turn over the image's height. The pivot
    /// stays where it is in the picture.
    pub fn orbit(&mut self, drag: DVec2, image_height: f64) {
        let [right, up, forward] = self.axes();
        let arm = self.pivot - self.eye;
        let arm = DVec3::new(arm.dot(right), arm.dot(up), arm.dot(forward));
        let angle = drag * PI / image_height.max(1.0);
        self.azimuth = (self.azimuth - angle.x).rem_euclid(TAU);
        self.elevation = (self.elevation + angle.y).clamp(-FRAC_PI_2, FRAC_PI_2);
        let [right, up, forward] = self.axes();
        self.eye = self.pivot - (right * arm.x + up * arm.y + forward * arm.z);
    }

    /// Moves the picture with the pointer, in pixels to the right and down: points at the pivot's distance follow it
    /// exactly.
    pub fn pan(&mut self, drag: DVec2, image_height: f64) {
        let [right, up, _] = self.axes();
        let shift = (up * drag.y - right * drag.x) * self.unit(image_height.max(1.0));
        self.move_by(shift);
    }

    fn move_by(&mut self, shift: DVec3) {
        let eye = self.eye + shift;
        let far = DISTANCES[1] * self.subject.reach();
        if eye.is_finite() && (eye - self.subject.bounds.center()).length() < far {
            self.eye = eye;
            self.pivot += shift;
        }
    }

    /// Shrinks the distance to a point by a factor (below 1: nearer); the point stays where it is in the picture.
    pub fn zoom(&mut self, point: DVec3, factor: f64) {
        let reach = self.subject.reach();
        let [right, up, forward] = self.axes();
        let arm = self.eye - point;
        let size = self.height.unwrap_or(arm.length());
        let factor = (factor * size).clamp(DISTANCES[0] * reach, DISTANCES[1] * reach) / size.max(f64::MIN_POSITIVE);
        if !(factor.is_finite() && point.is_finite()) {
            return;
        }
        match &mut self.height {
            Some(height) => {
                *height *= factor;
                self.eye += (right * arm.dot(right) + up * arm.dot(up)) * (factor - 1.0);
            }
            None => {
                self.eye = point + arm * factor;
                self.pivot = point + (self.pivot - point) * factor;
                // A pivot that fell behind the eye is of no use.
                if (self.pivot - self.eye).dot(forward) <= 0.0 {
                    self.pivot = self.eye + forward * self.depth(self.pivot, self.eye);
                }
            }
        }
    }

    /// Flies for `seconds`: to the right, up and ahead, each from −1 to 1, at a speed of the pivot's distance per
    /// second. In orthographic projection nothing gets closer, so flying ahead zooms.
    pub fn fly(&mut self, direction: DVec3, seconds: f64) {
        let [right, up, forward] = self.axes();
        let speed = match self.height {
            Some(height) => height,
            None => self.depth(self.pivot, self.eye).max(0.05 * self.subject.reach()),
        };
        let step = direction * seconds;
        if self.height.is_some() {
            self.zoom(self.pivot, (-step.z).exp());
            self.move_by((right * step.x + up * step.y) * speed);
        } else {
            self.move_by((right * step.x + up * step.y + forward * step.z) * speed);
        }
    }

    /// Switches between perspective and orthographic; objects at the pivot's distance keep their size.
    pub fn toggle_projection(&mut self) {
        let [.., forward] = self.axes();
        let slope = 2.0 * (0.5 * self.fov_y.to_radians()).tan();
        let depth = self.depth(self.pivot, self.eye);
        match self.height.take() {
            Some(height) => self.eye += forward * (depth - height / slope),
            None => self.height = Some(slope * depth),
        }
    }
}

/// The scene-file settings for a camera on a path; its target is as far away as the middle of the scene.
pub fn settings_of(pose: &path::Pose, subject: &CameraSubject) -> CameraSettings {
    let (fov_y, height) = match pose.projection {
        Projection::Perspective { fov_y } => (Some(fov_y.to_degrees()), None),
        Projection::Orthographic { height } => (None, Some(height)),
    };
    let to_center = (subject.bounds.center() - pose.eye).dot(pose.forward);
    let depth = if to_center > 0.0 { to_center } else { subject.reach() };
    CameraSettings {
        eye: Some(pose.eye),
        target: Some(pose.eye + pose.forward * depth),
        up: Some(pose.up),
        fov_y,
        height,
        near: pose.near,
        far: pose.far,
        ..CameraSettings::default()
    }
}

/// The point of the world that a pixel position shows at depth `z`, in an image of this size: the inverse of
/// [`Camera::project`].
pub fn unproject(camera: &Camera, size: [u32; 2], pixel: DVec2, z: f64) -> DVec3 {
    let center = DVec2::new(f64::from(size[0]), f64::from(size[1])) * 0.5;
    let offset = (pixel - center) / camera.pixels_per_unit(z, size[1]);
    camera.eye + camera.right * offset.x - camera.up * offset.y + camera.forward * z
}

/// The depth of an image at a pixel position, or at the nearest pixel that has one within `reach` pixels. `depths` are
/// row by row; values that aren't finite mean no depth.
pub fn depth_at(depths: &[f32], size: [u32; 2], pixel: DVec2, reach: i64) -> Option<f64> {
    let [width, height] = size.map(i64::from);
    let (x, y) = (pixel.x.floor() as i64, pixel.y.floor() as i64);
    let depth = |(dx, dy): (i64, i64)| {
        let (x, y) = (x.checked_add(dx)?, y.checked_add(dy)?);
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        let depth = inside.then(|| depths.get((y * width + x) as usize)).flatten()?;
        depth.is_finite().then_some((dx * dx + dy * dy, f64::from(*depth)))
    };
    let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
    let found = around.filter(|(dx, dy)| dx * dx + dy * dy <= reach * reach).filter_map(depth);
    found.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(_, depth)| depth)
}

#[cfg(test)]
mod tests;
