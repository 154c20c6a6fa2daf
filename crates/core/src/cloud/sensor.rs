//! The sensor that saw all points of a cloud from one place.

use glam::{DQuat, DVec3};

/// A depth camera or a laser scanner, in the coordinates of its cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Place of the sensor.
    pub position: DVec3,
    /// Unit vector along which it looks.
    pub forward: DVec3,
    /// Unit vector, orthogonal to `forward`, that points to the top of what it sees.
    pub up: DVec3,
    /// `true` of a scanner that turns about `up`, so that its points may lie all around.
    pub turns: bool,
}

impl Sensor {
    /// Returns a depth camera: it looks along +Z, and −Y is up.
    pub fn depth_camera(position: DVec3, rotation: DQuat) -> Self {
        Self { position, forward: rotation * DVec3::Z, up: rotation * DVec3::NEG_Y, turns: false }
    }

    /// Returns a laser scanner: it looks along +X, and +Z is up.
    pub fn laser(position: DVec3, rotation: DQuat) -> Self {
        Self { position, forward: rotation * DVec3::X, up: rotation * DVec3::Z, turns: true }
    }
}
