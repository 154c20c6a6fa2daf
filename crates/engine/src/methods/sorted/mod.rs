//! `sorted`: splats sorted once by the depth of their centers, binned to tiles in that order, blended front to back
//! tile by tile, until nothing behind can be seen. Exact for flat discs; approximate where oriented ones cross.
//!
//! The order is that of the A-buffer, depth and then content.

mod engine;

pub(crate) use engine::SortedEngine;

use super::{Error, Frame, PixelsGroup, Target};
use crate::gpu::shader::Shader;
use crate::gpu::{Recorder, Variant};
use crate::passes::bin::{self, Binned, Bins, OneRun, TileWalk, TiledGroup};
use crate::passes::compose::{self, STOPS};
use crate::passes::raster::Raster;
use crate::scene::Falloff;
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

/// Records the blending of all tiles of a window; `max_color` bounds the color components that are blended.
fn record_blend<'a>(
    bins: &'a Bins,
    recorder: &mut Recorder<'a>,
    frame: &Frame,
    (raster, falloff, max_color): (Raster<'a>, Falloff, f32),
    binned: Binned,
    target: &'a Target,
) -> Result<(), Error> {
    let tiles = bins.record_tiles(recorder, raster.cloud, binned)?.tiled;
    let blend = Blend { tiles, into: target.pixels() };
    let (stop, max_color) = compose::stop(frame.stop, frame.color, max_color);
    let shape = compose::variant(binned.cut(), raster.footprint, falloff);
    let push = |walk| BlendPush { walk, max_opacity: raster.cloud.max_opacity(), max_color };
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
