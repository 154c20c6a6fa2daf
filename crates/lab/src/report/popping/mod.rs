//! Popping: how much the error of a method changes from one frame of a camera path to the next.
//!
//! A picture that moves shows an error twice: by what is wrong in each frame, and by how that jumps. The first is the
//! error of [`tradeoff`](super::tradeoff); an error that stays as it is looks like another scene, and is not counted
//! here.

mod follower;
mod measure;
mod methods;
mod page;

use serde::{Deserialize, Serialize};

pub use follower::Follower;
pub use measure::{Film, measure, named};
pub use methods::{Candidate, candidates, exact};
pub use page::{csv, popping_table, write};

pub(super) use page::{over_frames, section};

/// Error of a method in a single frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameError {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// RMSE of the frame against the exact one.
    pub error: f64,
    /// RMSE of the change of the error since the frame before; `None` for the first frame.
    pub rmse: Option<f64>,
    /// FLIP of that change ([`Follower::add`]), in [0, 1].
    pub flip: Option<f64>,
}

/// The frames of a method, and the figures over all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the method.
    pub method: String,
    /// Setting of the method as options of the command line would give it; empty for the scene's own.
    pub setting: String,
    /// Errors of the frames, in the order of the path.
    pub frames: Vec<FrameError>,
    /// Mean of the errors.
    pub mean_error: f64,
    /// Mean and greatest RMSE of the changes; 0 for a single frame.
    pub mean_rmse: f64,
    /// See `mean_rmse`.
    pub worst_rmse: f64,
    /// The frame with the greatest RMSE: the change came with it.
    pub worst_frame: u32,
    /// Mean and greatest FLIP of the changes.
    pub mean_flip: f64,
    /// See `mean_flip`.
    pub worst_flip: f64,
}

impl Curve {
    /// The curve of some frames.
    pub fn new(candidate: &Candidate, frames: Vec<FrameError>) -> Self {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let errors: Vec<f64> = frames.iter().map(|frame| frame.error).collect();
        let changes: Vec<f64> = frames.iter().filter_map(|frame| frame.rmse).collect();
        let flips: Vec<f64> = frames.iter().filter_map(|frame| frame.flip).collect();
        // The first one of equals.
        let worst =
            frames.iter().filter(|frame| frame.rmse.is_some()).rev().max_by(|a, b| a.rmse().total_cmp(&b.rmse()));
        Self {
            method: candidate.method.name().to_owned(),
            setting: candidate.setting.clone(),
            mean_error: mean(&errors),
            mean_rmse: mean(&changes),
            worst_rmse: worst.map_or(0.0, FrameError::rmse),
            worst_frame: worst.map_or(0, |frame| frame.frame),
            mean_flip: mean(&flips),
            worst_flip: flips.iter().copied().fold(0.0, f64::max),
            frames,
        }
    }

    /// Method and setting, as one would say it.
    pub fn name(&self) -> String {
        format!("{} {}", self.method, self.setting.replace("method.", "")).trim_end().to_owned()
    }
}

impl FrameError {
    fn rmse(&self) -> f64 {
        self.rmse.unwrap_or(0.0)
    }
}

/// A method that could not be measured, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Method and setting, as one would say it.
    pub method: String,
    /// Reason for the omission.
    pub reason: String,
}

/// The popping of some methods along a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Popping {
    /// The method that made the exact frames, with its settings where they are not the scene's.
    pub exact: String,
    /// Number of frames.
    pub frames: u32,
    /// A curve for each method.
    pub curves: Vec<Curve>,
    /// The methods without one.
    pub refused: Vec<Refused>,
}
