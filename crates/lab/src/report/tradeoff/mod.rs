//! Accuracy against time: every applicable method and setting on one scene, against the exact image of the same image
//! formation; what lies on the Pareto front; how the error of stochastic methods falls with their samples.

mod analytic;
mod figures;
mod files;
mod findings;
mod measure;
mod page;
mod partial;
mod pictures;
pub(crate) mod renderers;
mod repeats;
pub mod settings;
mod summary;
mod surfaces;

use serde::{Deserialize, Serialize};

pub use files::write;
pub use measure::{ALONE_SHARE, FRAME_SHARE, Options, Subject, run};
pub use partial::discard;

use super::fit::PowerLaw;
use super::stress::Spread;

/// How far an image is from the reference, on composed linear R, G, B of all pixels; see [`pellucid_engine::metrics`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Squared difference over the reference's squares (Uchida et al. 2020, Eq. 10).
    pub nmse: f64,
    /// In decibels; infinite for equal images (`null` in JSON).
    pub psnr: Option<f64>,
    /// In [−1, 1]; 1 for equal images.
    pub ssim: f64,
    /// In [0, 1]; 0 for equal images.
    pub flip: f64,
    /// Largest difference in any channel.
    pub max: f64,
    /// Share of pixels with a channel off by more than 1/255.
    pub above_1_255: f64,
}

/// What repeating a stochastic setting with other seeds told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Images behind it, each with a seed of its own.
    pub seeds: u32,
    /// RMSE of one image against the mean over the seeds: the noise, with Bessel's correction.
    pub noise: f64,
    /// RMSE of the mean over the seeds against the reference, less what the noise alone leaves in a mean of so many (by
    /// squares, at least 0).
    pub bias: f64,
    /// What the noise alone leaves in the mean: noise / √seeds. A bias below it can't be told from none.
    pub bias_floor: f64,
}

/// One method with one setting, measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The method's name.
    pub method: String,
    /// Its setting as options of the command line would give it, as in `method.samples=64`; empty for the defaults.
    pub setting: String,
    /// What is turned, and how far, as in `("samples", 64.0)`; `None` for a method without a ladder.
    pub step: Option<(String, f64)>,
    /// One point of so many was drawn; 1: all.
    pub thinning: u32,
    /// Whether the image depends on the seed.
    pub stochastic: bool,
    /// Device time of all passes, frames of all settings taken in turns.
    pub gpu_ms: Spread,
    /// From the first submission to the end of read-back, on the host's clock.
    pub wall_ms: Spread,
    /// Frames behind the medians.
    pub frames: usize,
    /// Largest number of device bytes at any time of a frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// Bytes of the fragment buffer; 0 of methods that have none.
    pub fragment_bytes: u64,
    /// Against the reference; for stochastic methods the root of the mean square (rmse) or means (the others) over the seeds.
    pub errors: Errors,
    /// Of stochastic methods.
    pub repeats: Option<Repeats>,
    /// RMSE against the analytic image ([`Tradeoff::analytic`]), where there is one: root of the mean square over the seeds.
    pub rmse_analytic: Option<f64>,
    /// Of opaque points: share of the pixels inside the surfaces' silhouette ([`Surveyed::silhouette`]) on which nothing is
    /// drawn.
    pub holes: Option<f64>,
    /// RMSE of those pixels alone: what is said of a surface's detail, and not of how far splats reach over its outline.
    pub rmse_inside: Option<f64>,
    /// Whether no other row is at least as fast and as accurate, and better in one of the two.
    pub front: bool,
    /// File names, relative to the report's folder: the picture (PNG over the scene's background) and the absolute
    /// difference from the reference, [`DIFFERENCE_GAIN`] times as bright.
    pub picture: String,
    /// See `picture`.
    pub difference: String,
    /// Median device time of each pass, in the order of its first run.
    pub passes: Vec<(String, f64)>,
}

/// How much the difference pictures are brightened.
pub const DIFFERENCE_GAIN: f64 = 10.0;

/// A setting that was not measured, and why.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Skipped {
    /// The method's name.
    pub method: String,
    /// As in [`Row`].
    pub setting: String,
    /// Why.
    pub reason: String,
}

/// How the error of a method falls along its ladder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// The method's name.
    pub method: String,
    /// What is turned, as in `samples`.
    pub key: String,
    /// RMSE over that key; −1/2 for independent samples.
    pub rmse: PowerLaw,
    /// RMSE over median device time.
    pub over_time: PowerLaw,
    /// Rows behind the fit.
    pub rows: usize,
}

/// A statement of a paper, and what was measured of it on this scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The statement.
    pub claim: String,
    /// What was measured.
    pub measured: String,
    /// Whether it holds here; `None` where it names no figure.
    pub holds: Option<bool>,
}

/// The image that all others are compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// The exact method that made it, and whether in float64.
    pub method: String,
    /// Its file name.
    pub picture: String,
    /// Pixels of it that were compared with the float64 reference, chosen at random; 0 of an image that is float64 itself.
    pub checked_pixels: usize,
    /// The largest difference found there in R, G, B and A.
    pub largest_error: f64,
}

/// The image of planes before each other that alpha blending of their opacities gives, α₁C₁ + (1 − α₁)(α₂C₂ + …): one color.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analytic {
    /// Those of the planes, the nearest first.
    pub opacities: Vec<f64>,
    /// Points on a pixel of the image, m, of each plane.
    pub points_per_pixel: Vec<f64>,
    /// Linear R, G, B, over the background.
    pub color: [f64; 3],
    /// Ensembles up to which no point is dealt twice: the least m / −ln(1 − α).
    pub dealt_once: f64,
    /// RMSE of a single ensemble, as expected: σ₁.
    pub expected_of_one: f64,
    /// RMSE that is left however many ensembles there are, since how many points lie on a pixel is left to chance: for one plane
    /// of color C before B it is (1 − α)·√(e^(ln²(1 − α) / m) − 1)·|C − B|.
    pub expected_floor: f64,
    /// The same as measured: RMSE of the reference, the limit of ever more ensembles of these points.
    pub floor: f64,
    /// RMSE over L of the settings up to [`Analytic::dealt_once`], if there are two of them: −1/2 is expected.
    pub slope: Option<PowerLaw>,
}

impl Analytic {
    /// RMSE as expected of so many ensembles: √(σ₁²/L) while no point is dealt twice, and then what the points leave besides,
    /// which any two ensembles have in common that are not of one pass through them. Of planes whose passes differ a little more
    /// than there is.
    pub fn expected(&self, ensembles: f64) -> f64 {
        let shared = (1.0 - self.dealt_once / ensembles).max(0.0);
        (self.expected_of_one.powi(2) / ensembles + shared * self.expected_floor.powi(2)).sqrt()
    }
}

/// What opaque points are held against.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surveyed {
    /// Samples across a pixel of the reference: so many times so many are averaged.
    pub samples_across: u32,
    /// Pixels inside the silhouette: all samples of the reference are covered, on the pixel and on its eight neighbors. One
    /// pixel off the rim, since splats reach over it by a part of their radius.
    pub silhouette: u64,
    /// Each cloud that was drawn: one point of how many, and how many that are.
    pub clouds: Vec<(u32, u64)>,
}

/// Shadows of an area light, with the scene's own method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shaded {
    /// Its name.
    pub method: String,
    /// Samples of the light in the image that the others are compared with.
    pub reference_samples: u32,
    /// By ascending samples.
    pub steps: Vec<ShadedStep>,
}

/// Shadows of so many samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ShadedStep {
    /// How many.
    pub samples: u32,
    /// Device time of the passes that find the shadows, once for a light and a cloud.
    pub ms: Spread,
    /// RMSE of the image.
    pub rmse: f64,
}

/// All that was measured on a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tradeoff {
    /// Version of this format: 1.
    pub version: u32,
    /// Version of pellucid.
    pub pellucid: String,
    /// The command line.
    pub command: String,
    /// The inputs as they were named.
    pub scene: String,
    /// Device and driver.
    pub device: String,
    /// See `device`.
    pub driver: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Points of the scene.
    pub points: u64,
    /// Fragments of all lists.
    pub fragments: u64,
    /// Longest list.
    pub max_list: u32,
    /// Runs of the command that it took, if it was interrupted: frames of all settings were timed in turns in each of them.
    pub sittings: u32,
    /// What the errors are against.
    pub reference: Reference,
    /// Of ensembles of planes that fill the image.
    pub analytic: Option<Analytic>,
    /// Of opaque points.
    pub surveyed: Option<Surveyed>,
    /// Of opaque points in the light of an area.
    pub shaded: Option<Shaded>,
    /// What was measured, in the order of the settings' ladder.
    pub rows: Vec<Row>,
    /// What was not.
    pub skipped: Vec<Skipped>,
    /// One for each method with at least three rows on its ladder.
    pub convergence: Vec<Convergence>,
    /// What a paper says of its methods, and what was measured here.
    pub findings: Vec<Finding>,
}
