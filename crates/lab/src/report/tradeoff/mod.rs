//! Accuracy against time: measures every applicable method and setting on one scene against the exact image of the same
//! image formation, the Pareto front, and how the error of stochastic methods falls with their samples.

mod analytic;
mod causes;
mod figures;
mod files;
mod findings;
mod looks;
mod measure;
mod page;
mod partial;
mod pictures;
mod repeats;
mod summary;
mod surfaces;

pub use pellucid_session::area::{Against, PixelArea};
pub use pellucid_session::candidates::Skipped;
use serde::{Deserialize, Serialize};

pub use causes::{Cause, causes_table};
pub use files::{FILES, write};
pub use looks::{Look, Worst};
pub use measure::{ALONE_SHARE, FRAME_SHARE, MeasuredScene, Options, method_by_method, run};
pub use partial::discard;
pub(super) use surfaces::supersampled;

use super::fit::PowerLaw;
use super::popping::Popping;
use super::stress::Spread;

/// The error of an image against the reference, on composed linear R, G, B of all pixels; see
/// [`pellucid_core::metrics`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Squared difference over the reference's squares (Uchida et al. 2020, Eq. 10).
    pub nmse: f64,
    /// Peak signal-to-noise ratio in decibels; infinite for equal images (`null` in JSON).
    pub psnr: Option<f64>,
    /// Range [−1, 1]; 1 for equal images.
    pub ssim: f64,
    /// Range [0, 1]; 0 for equal images.
    pub flip: f64,
    /// Largest difference in any channel.
    pub max: f64,
    /// Share of pixels with a channel off by more than 1/255.
    pub above_1_255: f64,
}

/// Statistics of a stochastic setting repeated with other seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Images behind it, each with a seed of its own.
    pub seeds: u32,
    /// RMSE of one image against the mean over the seeds: the noise, with Bessel's correction.
    pub noise: f64,
    /// RMSE of the mean over the seeds against the reference, minus the noise that remains in a mean over this many
    /// seeds (by squares, at least 0).
    pub bias: f64,
    /// The noise that remains in the mean: noise / √seeds. A smaller bias can't be distinguished from zero.
    pub bias_floor: f64,
}

/// Measurements of one method with one setting.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The method's name.
    pub method: String,
    /// Setting as options of the command line would give it, as in `method.samples=64`; empty for the defaults.
    pub setting: String,
    /// The ladder's key and its value, as in `("samples", 64.0)`; `None` for a method without a ladder.
    pub step: Option<(String, f64)>,
    /// Thinning: only every n-th point was drawn; 1 means all.
    pub thinning: u32,
    /// True if the image depends on the seed.
    pub stochastic: bool,
    /// Device time of all passes; frames of all settings alternate.
    pub gpu_ms: Spread,
    /// Time from the first submission to the end of read-back, on the host's clock.
    pub wall_ms: Spread,
    /// Frames behind the medians.
    pub frames: usize,
    /// Largest number of device bytes at any time of a frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// Bytes of the fragment buffer; 0 for methods without one.
    pub fragment_bytes: u64,
    /// Errors against the reference; for stochastic methods the root of the mean square (rmse) or means (the others)
    /// over the seeds.
    pub errors: Errors,
    /// Noise and bias over several seeds, only for stochastic methods.
    pub repeats: Option<Repeats>,
    /// RMSE against the analytic image ([`Tradeoff::analytic`]), if it exists: root of the mean square over the seeds.
    pub rmse_analytic: Option<f64>,
    /// Only for opaque points: share of the pixels inside the surfaces' silhouette ([`Surveyed::silhouette`]) that are
    /// empty.
    pub holes: Option<f64>,
    /// RMSE of those pixels alone. It measures a surface's detail, and not how far splats extend beyond its outline.
    pub rmse_inside: Option<f64>,
    /// Parts of an approximation's error; `None` for exact images and for opaque points.
    #[serde(default)]
    pub look: Option<Look>,
    /// True if no other row is at least as fast and as accurate, and better in one of the two.
    pub front: bool,
    /// File names, relative to the report's folder: the picture (PNG over the scene's background) and the absolute
    /// difference from the reference, [`DIFFERENCE_GAIN`] times as bright.
    pub picture: String,
    /// See `picture`.
    pub difference: String,
    /// Median device time of each pass, in the order of its first run.
    pub passes: Vec<(String, f64)>,
}

impl Row {
    /// Method and setting, as one would say it.
    pub fn name(&self) -> String {
        format!("{} {}", self.method, figures::short(&self.setting)).trim_end().to_owned()
    }
}

/// Amplification of the difference pictures.
pub const DIFFERENCE_GAIN: f64 = 10.0;

/// The fall of a method's error along its ladder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// The method's name.
    pub method: String,
    /// The ladder's key, as in `samples`.
    pub key: String,
    /// RMSE over that key; −1/2 for independent samples.
    pub rmse: PowerLaw,
    /// RMSE over median device time.
    pub over_time: PowerLaw,
    /// Rows behind the fit.
    pub rows: usize,
}

/// A statement of a paper, and its test on this scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The statement.
    pub claim: String,
    /// The measured values.
    pub measured: String,
    /// True if the statement holds here; `None` where it names no figure.
    pub holds: Option<bool>,
}

/// The image that all others are compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// The exact method that made it, and if it did so in float64.
    pub method: String,
    /// File name of the reference's picture.
    pub picture: String,
    /// Pixels of it that were compared with the float64 reference, chosen at random; 0 of an image that is float64
    /// itself.
    pub checked_pixels: usize,
    /// The largest difference found there in R, G, B and A.
    pub largest_error: f64,
    /// Samples in a pixel.
    #[serde(default)]
    pub samples: u32,
}

/// The image of planes before each other that alpha blending of their opacities gives, α₁C₁ + (1 − α₁)(α₂C₂ + …): one
/// color.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Analytic {
    /// Opacities of the planes, the nearest first.
    pub opacities: Vec<f64>,
    /// Points on a pixel of the image, m, of each plane.
    pub points_per_pixel: Vec<f64>,
    /// Linear R, G, B, over the background.
    pub color: [f64; 3],
    /// Ensembles up to which no point is assigned twice: the least m / −ln(1 − α).
    pub dealt_once: f64,
    /// RMSE of a single ensemble, as expected: σ₁.
    pub expected_of_one: f64,
    /// RMSE that remains for any number of ensembles, since the number of points on a pixel is random: for one plane of
    /// color C before B it is (1 − α)·√(e^(ln²(1 − α) / m) − 1)·|C − B|.
    pub expected_floor: f64,
    /// Measured counterpart of `expected_floor`: RMSE of the reference, the limit of ever more ensembles of these
    /// points.
    pub floor: f64,
    /// RMSE over L of the settings up to [`Analytic::dealt_once`], if at least two exist: −1/2 is expected.
    pub slope: Option<PowerLaw>,
}

impl Analytic {
    /// The expected RMSE for this many ensembles: √(σ₁²/L) while no point is assigned twice. Beyond that the points'
    /// own error is added, which any two ensembles share unless they belong to the same pass through the points. For
    /// several planes whose passes differ, this slightly overestimates the error.
    pub fn expected(&self, ensembles: f64) -> f64 {
        let shared = (1.0 - self.dealt_once / ensembles).max(0.0);
        (self.expected_of_one.powi(2) / ensembles + shared * self.expected_floor.powi(2)).sqrt()
    }
}

/// The reference for opaque points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surveyed {
    /// Samples across a pixel of the reference: each pixel averages the square of this number.
    pub samples_across: u32,
    /// Pixels inside the silhouette: all samples of the reference are covered, on the pixel and on its eight neighbors.
    /// One pixel off the rim, since splats reach over it by a part of their radius.
    pub silhouette: u64,
    /// Each cloud that was drawn: one point of how many, and how many that are.
    pub clouds: Vec<(u32, u64)>,
}

/// Shadows of an area light, with the scene's own method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shaded {
    /// Name of the method.
    pub method: String,
    /// Samples of the light in the image that the others are compared with.
    pub reference_samples: u32,
    /// Steps in ascending order of samples.
    pub steps: Vec<ShadedStep>,
}

/// Shadows with a given number of samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ShadedStep {
    /// The number of samples.
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
    /// Runs of the command that it took, if it was interrupted: frames of all settings were timed in turns in each of
    /// them.
    pub sittings: u32,
    /// The reference of the errors.
    pub reference: Reference,
    /// Expected errors, only for ensembles of planes that fill the image.
    pub analytic: Option<Analytic>,
    /// Facts about the surfaces, only for opaque points.
    pub surveyed: Option<Surveyed>,
    /// Errors of shadows, only for opaque points lit by an area light.
    pub shaded: Option<Shaded>,
    /// The picture that errors are measured against: `center` or `area`.
    #[serde(default)]
    pub against: String,
    /// The sampling error of the exact picture; `None` for opaque points, whose reference has many samples, or where
    /// no time was left.
    #[serde(default)]
    pub area: Option<PixelArea>,
    /// Errors of each approximation by itself: of Gaussian splats, the exact image first, then of the samples of a
    /// pixel's area.
    pub causes: Vec<Cause>,
    /// Change of the error from frame to frame, only along a camera path.
    pub popping: Option<Popping>,
    /// The measured settings, in the order of the ladder.
    pub rows: Vec<Row>,
    /// The skipped settings.
    pub skipped: Vec<Skipped>,
    /// Convergence of each method with at least three rows on its ladder.
    pub convergence: Vec<Convergence>,
    /// Statements of papers on the methods, with the measured values.
    pub findings: Vec<Finding>,
}
