//! Cost of each approximation by itself: images with one thing changed, against the exact image. Of every scene the
//! samples of a pixel's area, of Gaussian splats also each approximation of their kernel and order.

pub(super) mod area;
mod measure;
mod rows;

use maud::{Markup, html};
use pellucid_core::metrics::error_text;
use serde::{Deserialize, Serialize};

use crate::report::page::{ReportTable, digits};
use crate::report::tradeoff::figures::short;
use crate::report::tradeoff::page::{error, percent};

pub(super) use measure::{Effort, measure};
pub(super) use rows::{Change, changes};

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
    /// Device time of a frame of the changed image, once all was ready; of the limit of ensembles, which no device
    /// draws, the host's time.
    pub gpu_ms: f64,
    /// Time over the one of the unchanged exact image, of samples over the one of a single sample; `None` in
    /// reports of earlier versions.
    #[serde(default)]
    pub times: Option<f64>,
    /// File name of the absolute difference, [`DIFFERENCE_GAIN`](super::DIFFERENCE_GAIN) times as bright.
    pub difference: String,
}

/// The section of the page; nothing without causes.
pub(super) fn page(causes: &[Cause]) -> Markup {
    let table = ReportTable::new(causes)
        .text("cause", |cause| &cause.cause)
        .text("setting", changed)
        .number("RMSE", error, |cause| cause.rmse)
        .number("FLIP", error, |cause| cause.flip)
        .number("largest", error, |cause| cause.max)
        .number("% off", percent, |cause| cause.above_1_255)
        .number("ms", digits, |cause| cause.gpu_ms)
        .number("times exact", digits, |cause| cause.times)
        .text("what it means", |cause| &cause.meaning);
    html! {
        @if !causes.is_empty() {
            h2 { "Error by cause" }
            @if causes.iter().any(|cause| cause.cause == area::CAUSE) {
                p {
                    "“Pixel area” is the error of looking at one or a few points of each pixel in place of its area: the exact image with "
                    "that many samples, against itself with more. Every method has it beside its own error, unless it renders as many samples. "
                    "“Times exact” is the device time over that of the exact image, here with a single sample."
                }
            }
            @if has_splats(causes) { p {
                "The table shows what each approximation of Gaussian splats does to this image by itself. Each row changes one thing "
                "of the image of " code { "abuffer" } " and compares it with the exact image of the scene's own kernel and order. "
                "“Exact” holds for these; which of two images looks better depends on how the splats were trained. “% off” is the "
                "share of pixels with a channel off by more than 1/255; times are the shorter of two frames. "
                code { "cause-….png" } " beside this page show where the differences are."
            } }
            div.sentences { (table.html()) }
        }
    }
}

/// Returns `true` if some are approximations of Gaussian splats.
fn has_splats(causes: &[Cause]) -> bool {
    causes.iter().any(|cause| cause.cause != area::CAUSE)
}

/// The causes and their figures as a table for a terminal, without what they mean; empty without causes.
pub fn causes_table(causes: &[Cause]) -> String {
    if causes.is_empty() {
        return String::new();
    }
    let error = error_text;
    let table = ReportTable::new(causes)
        .text("cause", |cause| &cause.cause)
        .text("changed", changed)
        .number("RMSE", error, |cause| cause.rmse)
        .number("FLIP", error, |cause| cause.flip)
        .number("largest", error, |cause| cause.max)
        .number("> 1/255", |share| format!("{:.2}%", 100.0 * share), |cause| cause.above_1_255)
        .number("ms", |ms| format!("{ms:.2}"), |cause| cause.gpu_ms)
        .number("times", |times| format!("{times:.2}"), |cause| cause.times);
    let about = match has_splats(causes) {
        true => "by cause: the exact image of this kernel and order, compared with itself with one thing changed",
        false => "samples of a pixel's area: the exact image with a few, compared with itself with more",
    };
    format!("{about}\n{}\n", table.terminal())
}

/// The setting, and what it is compared with if that is not the scene's image.
fn changed(cause: &Cause) -> String {
    match cause.against.as_str() {
        "" => short(&cause.setting),
        against => format!("{} against {}", short(&cause.setting), short(against)),
    }
}
