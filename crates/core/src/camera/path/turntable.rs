//! A turn around a point.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::Pose;
use crate::camera::Camera;

/// A full turn of a camera around an axis through a point: counter-clockwise as seen against the axis, so that the
/// azimuth of the eye ascends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turntable {
    /// The first camera.
    pub start: Pose,
    /// A point of the axis, in world units.
    pub center: DVec3,
    /// Unit direction of the axis.
    pub axis: DVec3,
}

impl Turntable {
    /// Returns the turn of a camera; its depths are left to be found for each pose.
    pub fn new(camera: &Camera, center: DVec3, axis: DVec3) -> Self {
        let Camera { eye, right, up, forward, projection, .. } = *camera;
        let start = Pose { eye, right, up, forward, projection, near: None, far: None, stated: None };
        Self { start, center, axis: axis.normalize_or(DVec3::Z) }
    }

    /// `count` poses: the first is the camera's own, the last one step before it.
    pub fn frames(&self, count: usize) -> Vec<Pose> {
        let Pose { eye, right, up, forward, projection, near, far, .. } = self.start;
        let pose = |i: usize| {
            // Without the rounding of the way to the center and back.
            if i == 0 {
                return self.start;
            }
            let turn = DQuat::from_axis_angle(self.axis, TAU * (i as f64 / count as f64));
            Pose {
                eye: self.center + turn * (eye - self.center),
                right: turn * right,
                up: turn * up,
                forward: turn * forward,
                projection,
                near,
                far,
                stated: None,
            }
        };
        (0..count).map(pose).collect()
    }
}
