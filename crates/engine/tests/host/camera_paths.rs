//! Camera paths without a device: the file, the curve through its keys, the turntable, cameras of other programs.

mod curve;
mod exact;
mod file;
mod import;

use glam::DVec3;
use pellucid_engine::camera::Projection;
use pellucid_engine::camera::path::{CameraPath, Curve, Defaults, Key};

/// Z is up, 50° to see.
fn defaults() -> Defaults {
    Defaults { up: DVec3::Z, projection: Projection::Perspective { fov_y: 50f64.to_radians() } }
}

fn looking(eye: [f64; 3], target: [f64; 3]) -> Key {
    Key { target: Some(target), ..Key::at(eye) }
}

#[track_caller]
fn curve(path: &CameraPath) -> Curve {
    Curve::new(path, &defaults()).unwrap()
}
