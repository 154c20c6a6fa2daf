//! `sorted`: splats sorted once by the depth of their centers, binned to tiles in that order, blended front to back
//! tile by tile, until nothing behind can be seen. Exact for flat discs; approximate where oriented ones cross.
//!
//! The order is that of the A-buffer, depth and then content.

mod engine;

pub(crate) use engine::SortedEngine;

use super::engine::Work;
use super::{Error, Frame, Outcome, Target, tiled};
use crate::gpu::shader::Shader;
use crate::gpu::{Recorder, Variant};
use crate::passes::bin::{self, Binned, Bins, OneRun, TileWalk, TiledGroup};
use crate::passes::compose::{self, STOPS};
use crate::scene::Discs;
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of `sorted/blend`; the shader explains the members.
    pub struct BlendPush {
        walk: TileWalk,
        max_opacity: f32,
        max_color: f32,
    }
}

pass! {
    /// Composes the splats of a tile front to back: one subgroup per block of a tile hands them from lane to lane and
    /// keeps pixels in registers. A run takes 2048 splats; runs are joined.
    pub Blend(BlendPush) = "sorted/blend" {
        tiles: Shared<TiledGroup>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
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
    let (device, frame, target) = (work.device, work.frame, work.target);
    tiled::blend(bins, work, (&job.bin, 0), "sorted/blend", |bins, work, binned| {
        let mut recorder = work.timeline.recorder(device)?;
        record_blend(bins, &mut recorder, frame, job, binned, target)?;
        Ok(Some(recorder))
    })
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
    let blend = Blend { tiles, image: target.image(), depths: target.depths() };
    let (stop, max_color) = compose::stop(frame.stop, frame.color, job.max_color);
    let shape = compose::variant(binned.cut(), job.bin.raster.footprint, job.discs.falloff);
    let push = |walk| BlendPush { walk, max_opacity: cloud.max_opacity(), max_color };
    let variant = |run| blend_variant(shape.clone(), run, stop);
    Ok(binned.record_runs(recorder, &blend, binned.segments(), push, variant)?)
}

/// A variant of `sorted/blend`, from that of shape and falloff.
fn blend_variant(shape: Variant, run: OneRun, stop: u32) -> Variant {
    bin::fold_blocks_variant(shape, run).with("STOP", stop)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::new::<Blend>(bin::run_variants(compose::variants(), &STOPS, blend_variant))]
}
