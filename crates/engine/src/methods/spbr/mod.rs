//! `spbr`, `spbr-simplified`: stochastic point-based rendering (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! The points of each cloud are dealt to L ensembles ([`crate::prepare::ensembles`]). Each ensemble is an image of
//! opaque points with a depth test of its own; their mean is the image: no order of points is needed. The nearest
//! point of a pixel in an ensemble is found by atomic minima of depth and index, and colors are summed as whole
//! numbers, so that neither the order in which points come nor how many ensembles are drawn at once shows.
//!
//! A point asks for the area q² p t in pixels: q the width of a pixel at the depth of its cloud's middle over that at
//! its own (1 in orthographic views), p = ln(1 − α) / ln(1 − α of its cloud), t = |cos θ| between normal and view
//! unless `cos_theta`. Below 1 it is one pixel with that probability, above it a square.

mod adjustment;
mod engine;
mod ensembles;
mod job;
mod passes;
pub mod rounds;
pub mod share;
pub mod stream;
mod tasks;
mod variants;

pub use adjustment::{Adjusted, Adjustment};
pub(crate) use engine::{EnsembleEngine, pass_group};
pub use ensembles::{Drawn, Ensembles};
pub use job::{Scale, SpbrJob};
pub use passes::*;
pub use variants::{Form, SpbrKind, Stage, shaders};

use self::share::{Share, Wanted};
use super::{Error, Facts, Frame, ThinCloud};
use crate::passes::bands::Budget;
use crate::passes::project::{DeviceCloud, Placed};
use crate::prepare::ensembles::slots;
use crate::random;

/// Returns the slots of one invocation, at most 32; `spread`: the device prefers squares that a workgroup shares, and
/// many invocations to few that go on long.
fn run(spread: bool) -> u64 {
    if spread { 2 } else { 16 }
}

/// Returns the pixels of a square at most that one invocation walks, or that the invocations of a workgroup share with
/// others: larger ones go to a list.
pub fn small_square(spread: bool) -> u32 {
    if spread { 4096 } else { 64 }
}

/// Separates the random words of this method from those of `stochastic`: "SPBR", exclusive-or the second word of the
/// key.
const STREAM: u32 = 0x5350_4252;

/// Threefry's key for the words that decide which points smaller than a pixel are drawn. A word's counter is the
/// point's place in the dealt list, and the ensemble.
pub fn key(seed: u64) -> [u32; 2] {
    let [low, high] = random::key(seed);
    [low, high ^ STREAM]
}

/// Returns device bytes per pixel of a window, with one plane.
pub fn pixel_bytes(spread: bool) -> u64 {
    8 + 32 + if spread { 48 } else { 0 }
}

/// Returns the number of pixels of a window whose buffers fit a binding, and a quarter of the budget.
pub fn window_pixels(budget: Budget, spread: bool) -> u64 {
    budget.window_pixels(pixel_bytes(spread)).min(budget.binding / 32).max(1)
}

/// Returns the shares of a frame, if its points were dealt.
pub fn shares(cloud: &DeviceCloud, frame: &Frame) -> Result<Vec<Share>, Error> {
    let placed: &[Placed] = cloud.surfaces().ok_or(Error::NotDealt)?;
    let wanted = wanted(frame);
    Ok(placed.iter().map(|p| wanted.share(p)).collect())
}

/// Returns the adjustment of the numbers of points in a frame; `None` if they were not dealt.
pub fn adjusted(cloud: &DeviceCloud, frame: &Frame) -> Option<Adjusted> {
    let (placed, wanted): (&[Placed], _) = (cloud.surfaces()?, wanted(frame));
    let clouds = placed.iter().map(|p| wanted.adjustment(p)).collect();
    Some(Adjusted { ensembles: frame.method.ensembles()?, clouds })
}

fn wanted(frame: &Frame) -> Wanted<'_> {
    Wanted {
        camera: &frame.camera,
        height: frame.size[1],
        method: frame.method,
        opacity_factor: f64::from(frame.factors.opacity),
    }
}

/// Most pixels that a point may cover.
fn largest(shares: &[Share]) -> f64 {
    shares.iter().map(|s| s.largest).fold(0.0, f64::max)
}

/// Returns `true` if squares may have more than `small` pixels and so go to a list: a side of up to `s` pixels touches
/// `s + 1`.
pub fn is_listed(shares: &[Share], small: u32) -> bool {
    (largest(shares).sqrt() + 1.0).powi(2) > f64::from(small)
}

/// Returns the number of bytes that a pass must at least read and write; `pixels` of the image.
pub fn least_bytes(name: &str, facts: &Facts, spread: bool, pixels: u64) -> Option<u64> {
    let (walk, squares) = (facts.slots * 32 * facts.windows.max(1), if spread { 32 } else { 0 });
    match name {
        "spbr/nearest" | "spbr/nearest-depth" | "spbr/nearest-id" => Some(walk + facts.visible * 8),
        "spbr/draw" => Some(walk + facts.visible * (16 + 16) + pixels * 32),
        "spbr/sum" => Some(walk + facts.visible * 8 + pixels * 32),
        "spbr/upload" => Some(2 * facts.uploaded_bytes),
        "spbr/resolve" => Some(pixels * (32 + squares + 20 + squares / 2)),
        _ => None,
    }
}

/// Slots of the first `drawn` of `ensembles`.
pub fn slots_of(share: &Share, ensembles: u32, drawn: u32) -> u64 {
    drawn.checked_sub(1).map_or(0, |last| slots(share.slots, ensembles, last).end)
}

/// Returns the clouds that lose opacity.
pub fn thin(shares: &[Share]) -> Vec<ThinCloud> {
    let thousandths = |share: &Share| (1000.0 * share.opacity).round() as u32;
    let all = shares.iter().zip(0..);
    all.filter(|(s, _)| s.capped).map(|(s, cloud)| ThinCloud { cloud, reached: thousandths(s) }).collect()
}
