//! Camera paths: key frames as a JSON file holds them, and the cameras between them.
//!
//! [`CameraPath`] is the file: what a program that records key frames fills in and writes with [`CameraPath::to_json`].
//! [`Curve`] is the motion through its keys (docs/camera-paths.md says how it is found, and why).
//!
//! ```
//! use glam::DVec3;
//! use pellucid_core::camera::Projection;
//! use pellucid_core::camera::path::{CameraPath, Curve, Defaults, Key};
//!
//! let key = |eye| Key { target: Some([0.0; 3]), ..Key::at(eye) };
//! let path = CameraPath::new(vec![key([4.0, 0.0, 1.0]), key([0.0, 4.0, 1.0])]);
//! let read = CameraPath::from_json(&path.to_json(), "turn.json".as_ref())?;
//! assert_eq!(read, path);
//!
//! let defaults = Defaults { up: DVec3::Z, projection: Projection::Perspective { fov_y: 0.8 } };
//! let poses = Curve::new(&path, &defaults)?.frames(9);
//! // An orbit: always as far from the target.
//! assert!(poses.iter().all(|pose| (pose.eye.length() - 17f64.sqrt()).abs() < 1e-12));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cubic;
mod curve;
mod direction;
mod file;
mod knot;
mod turntable;

pub use curve::Curve;
pub(super) use file::from_text;
pub use file::{CameraPath, Key, MAX_KEYS, VERSION};
pub use turntable::Turntable;

use std::path::PathBuf;

use glam::{DVec2, DVec3};

use super::{Camera, Projection};

/// Values for keys that leave them open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defaults {
    /// Direction of the image's top, of any length but 0.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
}

/// Position and orientation of a camera, in world units; the axes are orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The eye.
    pub eye: DVec3,
    /// Direction toward the image's right.
    pub right: DVec3,
    /// Direction toward the image's top.
    pub up: DVec3,
    /// The viewing direction.
    pub forward: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Nearest depth drawn, if the path gives it.
    pub near: Option<f64>,
    /// Farthest depth drawn, if the path gives it.
    pub far: Option<f64>,
    /// Target and `up` from which the axes were found, if they were.
    pub stated: Option<[DVec3; 2]>,
}

impl Pose {
    /// Returns the camera with these depths.
    pub fn camera(&self, near: f64, far: f64) -> Camera {
        let Self { eye, right, up, forward, projection, .. } = *self;
        Camera { eye, right, up, forward, projection, near, far, shift: DVec2::ZERO }
    }
}

/// A defect of a path, and the key that has it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}{problem}")]
pub struct Problem {
    /// A prefix like `keys[3].up: `, or empty.
    pub place: String,
    /// The defect, and a way to mend it.
    pub problem: String,
}

impl Problem {
    pub(crate) fn of_key(number: usize, name: &str, problem: impl Into<String>) -> Self {
        let dot = if name.is_empty() { "" } else { "." };
        Self { place: format!("keys[{number}]{dot}{name}: "), problem: problem.into() }
    }

    #[doc(hidden)]
    pub fn whole(problem: impl Into<String>) -> Self {
        Self { place: String::new(), problem: problem.into() }
    }
}

/// Reason why a file of cameras can't be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// The file can't be read.
    #[error("{path}: can't read the camera path: {source}", path = path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// The text is not valid, at this line and column, counted from 1; the column is 1 where only the line is known.
    #[error("{path}:{line}:{column}: {message}", path = path.display())]
    Syntax { path: PathBuf, line: usize, column: usize, message: String },
    /// The file is readable, but its content is not a valid path.
    #[error("{path}: {problem}", path = path.display())]
    Content { path: PathBuf, problem: Problem },
}

impl Error {
    /// 1 for a file that can't be read, 2 for one that is wrong.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Read { .. } => 1,
            _ => 2,
        }
    }
}
