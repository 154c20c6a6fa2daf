//! The tail of `hybrid` by moments: two stages behind those that compose the first fragments. The first sums the
//! moments of each pixel's other fragments, the second their colors, weighted by the light that moments leave before
//! them.

use crate::methods::fading::{self, Estimate, with_moments};
use crate::methods::prelude::*;
use crate::methods::tiled::{Sums, SumsGroup};
use crate::passes::bin::Tiled;
use crate::scene::{MomentCount, Moments};

gpu_struct! {
    /// Push constants: those of moments, and the least opacity of a fragment that is composed exactly.
    pub struct TailPush {
        walk: TileWalk,
        estimate: Estimate,
        core_alpha_min: f32, // The least opacity of a fragment that is composed exactly.
    }
}

pass! {
    /// Sums the moments of the fragments behind the last one that `hybrid/accumulate` composed, as `moments/gather`
    /// those of all.
    pub GatherTail(TailPush) = "hybrid/gather" in "approximate/hybrid_gather" {
        tiles: Shared<TiledGroup>,
        lasts: Read<[u32; 2]>,
        known: ReadWrite<[f32; 2]>,
    }

    /// Sums the colors of the same fragments, weighted by the light before them, and puts them behind the others.
    pub WeighTail(TailPush) = "hybrid/weigh" in "approximate/hybrid_weigh" {
        tiles: Shared<TiledGroup>,
        sums: Shared<SumsGroup>,
        lasts: Read<[u32; 2]>,
        known: Read<[f32; 2]>,
    }
}

/// The buffers of both stages.
#[derive(Clone, Copy)]
pub(super) struct Tail<'a> {
    pub tiles: Tiled<'a>,
    pub sums: Sums<'a>,
    pub lasts: Slice<'a, [u32; 2]>,
    pub known: Slice<'a, [f32; 2]>,
    /// Number of moments.
    pub moments: MomentCount,
    pub core_alpha_min: f32,
    /// Near and far.
    pub depth_range: [f32; 2],
}

impl<'a> Tail<'a> {
    /// Records both stages over all tiles.
    pub fn record(&self, recorder: &mut Recorder<'a>, binned: Binned, shape: &Variant) -> Result<(), Error> {
        let Self { tiles, sums, lasts, known, moments, core_alpha_min, depth_range } = *self;
        let estimate = Estimate::new(&Moments { moments, ..Moments::default() }, depth_range);
        let push = |walk| TailPush { walk, estimate, core_alpha_min };
        let (runs, gather) = (binned.region_segments(), GatherTail { tiles, lasts, known });
        let variant = with_moments(bin::region_variant(shape.clone(), binned.lanes()), moments.get());
        binned.record_runs(recorder, &gather, runs, push, &variant)?;
        let weigh = WeighTail { tiles, sums, lasts, known };
        Ok(binned.record_runs(recorder, &weigh, runs, push, &variant)?)
    }
}

/// Returns the number of bytes of a pixel: its moments, and the rank of the last fragment in front of the tail.
pub(super) fn pixel_bytes(moments: MomentCount) -> u64 {
    fading::PAIR_BYTES * fading::pairs(moments) + super::LAST_BYTES
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> [Shader; 2] {
    [Shader::new::<GatherTail>(fading::by_moments()), Shader::new::<WeighTail>(fading::by_moments())]
}
