//! Cost of each approximation of Gaussian splats by itself: images with one thing changed, against the exact image of
//! the scene's own kernel and order.

mod measure;
mod rows;
mod table;

use serde::{Deserialize, Serialize};

pub(super) use measure::{Effort, measure};
pub(super) use rows::{Change, changes};
pub use table::causes_table;
pub(super) use table::page;

/// The image of `abuffer` with one thing changed, or that of `hybrid`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Cause of the difference, in a few words.
    pub cause: String,
    /// The change as an option of the command line would give it, as in `method.order=center`; empty for the exact
    /// image itself.
    pub setting: String,
    /// Setting that the changed image is compared with, in the same form, in addition to the scene's own settings;
    /// empty for the exact image.
    pub against: String,
    /// Meaning of the figures, in one sentence.
    pub meaning: String,
    /// Root of the mean squared difference, on composed linear R, G, B of all pixels.
    pub rmse: f64,
    /// Range [0, 1]; 0 for equal images.
    pub flip: f64,
    /// Largest difference in any channel.
    pub max: f64,
    /// Share of pixels with a channel off by more than 1/255.
    pub above_1_255: f64,
    /// Device time of a frame of the changed image, once all was ready.
    pub gpu_ms: f64,
    /// File name of the absolute difference, [`DIFFERENCE_GAIN`](super::DIFFERENCE_GAIN) times as bright.
    pub difference: String,
}
