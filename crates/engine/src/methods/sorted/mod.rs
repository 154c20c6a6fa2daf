//! `sorted`: splats sorted once by the depth of their centers, binned to tiles in that order, blended front to back
//! tile by tile, until nothing behind can be seen. Exact for flat discs; approximate where oriented ones cross.
//!
//! The order is that of the A-buffer, depth and then content.

mod engine;

pub(crate) use engine::SortedEngine;

use super::engine::Work;
use super::{Error, Frame, Outcome, PixelsGroup, Target};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Recorder, Variant};
use crate::passes::bands;
use crate::passes::bin::{self, Bin, Binned, Bins, OneRun, Stages, TileWalk, TiledGroup};
use crate::passes::compose;
use crate::scene::{ColorSpace, Discs};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of `sorted/blend`.
    pub struct BlendPush {
        walk: TileWalk,
        // Largest opacity, and largest color component, background included: bounds of the splats behind.
        max_opacity: f32,
        max_color: f32,
    }
}

pass! {
    /// Composes the splats of a tile front to back: one subgroup per block of a tile hands them from lane to lane and
    /// keeps pixels in registers. A run takes 2048 splats; runs are joined.
    pub Blend(BlendPush) = "sorted/blend" {
        tiles: Shared<TiledGroup>,
        into: Shared<PixelsGroup>,
    }
}

/// Fragments that may be left out at the back of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Stop {
    /// Fragments that change no bit of the image.
    #[default]
    Exact,
    /// Fragments that change no 8-bit value of the composed image by more than a quarter of a step.
    EightBit {
        /// `true` if the image goes without background, so that color is divided by A.
        transparent: bool,
    },
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct WindowJob<'a> {
    /// The splats to sort and bin.
    pub bin: bin::Job<'a>,
    /// Shape and falloff.
    pub discs: Discs,
    /// Upper bound of the color components that are blended.
    pub max_color: f32,
}

/// Sorts, bins and blends a window into the target.
pub(crate) fn render(bins: &mut Bins, work: &mut Work<'_>, job: &WindowJob<'_>) -> Result<Outcome, Error> {
    let (device, target) = (work.device, work.target);
    let window = job.bin.raster.window;
    let mut recorder;
    match bins.bin(device, &job.bin, work.timeline)? {
        Bin::TooLarge => return Ok(Outcome::Overflow),
        Bin::Nothing => {
            recorder = work.timeline.recorder(device)?;
            target.pixels().record_nothing(&mut recorder, window)?;
        }
        Bin::Done(binned) => {
            work.note_binned(binned);
            work.facts.bands += 1;
            recorder = work.timeline.recorder(device)?;
            record_blend(bins, &mut recorder, work.frame, job, binned, target)?;
        }
    }
    target.record_read_back(&mut recorder, bands::pixels(window))?;
    work.timeline.submit(recorder, "sorted/blend")?;
    Ok(Outcome::Done)
}

/// Records the blending of all tiles.
fn record_blend<'a>(
    bins: &'a Bins,
    recorder: &mut Recorder<'a>,
    frame: &Frame,
    job: &WindowJob<'a>,
    binned: Binned,
    target: &'a Target,
) -> Result<(), Error> {
    let cloud = job.bin.raster.cloud;
    let tiles = bins.record_tiles(recorder, cloud, binned)?.tiled;
    let blend = Blend { tiles, into: target.pixels() };
    let (stop, max_color) = stop(frame.stop, frame.color, job.max_color);
    let shape = compose::variant(binned.cut(), job.bin.raster.footprint, job.discs.falloff);
    let push = |number| BlendPush { walk: binned.walk(number), max_opacity: cloud.max_opacity(), max_color };
    let stages = Stages { shape, binned, runs: binned.segments() };
    Ok(stages.record(recorder, &blend, push, |shape, run| blend_variant(shape, stop, run))?)
}

/// Values of `STOP` in WGSL.
pub(crate) const STOP_NEVER: u32 = 0;
pub(crate) const STOP_EXACT: u32 = 1;
pub(crate) const STOP_SRGB: u32 = 2;
pub(crate) const STOP_ENCODED: u32 = 3;
/// Values of `STOP` with an early end.
pub(crate) const STOPS: [u32; 3] = [STOP_EXACT, STOP_SRGB, STOP_ENCODED];

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 3] =
    [("STOP_NEVER", STOP_NEVER), ("STOP_EXACT", STOP_EXACT), ("STOP_SRGB", STOP_SRGB)];

/// Returns the value of `STOP` in WGSL, and the bound on colors that goes with it, from that of what is blended.
pub fn stop(stop: Stop, space: ColorSpace, most: f32) -> (u32, f32) {
    match stop {
        Stop::Exact => (STOP_EXACT, most),
        Stop::EightBit { transparent } => {
            // The background may come behind. Without one, C / A moves by at most T (m + 1) / A, and A is above 0.9
            // here.
            let most = most.max(1.0);
            let most = if transparent { (most + 1.0) * 1.2 } else { most };
            (if space == ColorSpace::Linear { STOP_SRGB } else { STOP_ENCODED }, most)
        }
    }
}

/// A variant of `sorted/blend`, from that of shape and falloff.
fn blend_variant(shape: Variant, stop: u32, run: OneRun) -> Variant {
    bin::fold_blocks_variant(shape, run).with("STOP", stop)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let runs = |shape: Variant| OneRun::all().into_iter().map(move |run| (shape.clone(), run));
    let stops = |(shape, run): (Variant, OneRun)| STOPS.map(|stop| blend_variant(shape.clone(), stop, run));
    vec![Shader::new::<Blend>(compose::variants().into_iter().flat_map(runs).flat_map(stops))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stopping_knows_what_may_still_come() {
        use ColorSpace::{Encoded, Linear};
        assert_eq!(stop(Stop::Exact, Linear, 0.25), (1, 0.25));
        assert_eq!(stop(Stop::Exact, Encoded, 1.0), (1, 1.0));
        // The background may be white.
        assert_eq!(stop(Stop::EightBit { transparent: false }, Linear, 0.25), (2, 1.0));
        assert_eq!(stop(Stop::EightBit { transparent: false }, Encoded, 3.0), (3, 3.0));
        assert_eq!(stop(Stop::EightBit { transparent: true }, Linear, 0.25), (2, 2.4));
        assert_eq!(stop(Stop::EightBit { transparent: true }, Encoded, 1.5), (3, 3.0));
    }
}
