//! The samples' two passes over the splats in compute shaders, tile by tile.

use super::{Batch, STRATA, SampleJob, SampleKind, Sampler};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Recorder, Variant};
use crate::methods::{Error, Target};
use crate::passes::bin::{self, OneRun, OrderedTiles, TileWalk, TiledGroup};
use crate::passes::compose;
use crate::random::{self, STRATA_OF_A_CALL, STRATUM};
use crate::{gpu_struct, pass};

gpu_struct! {
    /// Push constants of both passes.
    pub struct StochasticPush {
        walk: TileWalk,
        pixels: u32, // Pixels of the window.
        before: u32, // Samples of the strata before this run's, and those to take from its first one on.
        left: u32,
        key_low: u32, // The random numbers' key for the run's first two strata.
        key_high: u32,
    }
}

pass! {
    /// Finds the nearest fragment that covers each sample, for up to 4 strata: one subgroup per 8 × 8 block of a tile
    /// hands the splats that touch it to its regions of one pixel per invocation.
    pub Visibility(StochasticPush) = "stochastic/visibility" {
        tiles: Shared<TiledGroup>,
        held_keys: ReadWrite<[u32; 4]>,
        held_indices: ReadWrite<[u32; 4]>,
        ids: Read<u32>,
    }

    /// Visits the splats of `stochastic/visibility` again, and sums α c and α over the samples where each is visible.
    /// With the first strata it also finds the exact A.
    pub Accumulate(StochasticPush) = "stochastic/accumulate" {
        tiles: Shared<TiledGroup>,
        held_keys: Read<[u32; 4]>,
        held_indices: Read<[u32; 4]>,
        sums: ReadWrite<[f32; 4]>,
        exact: ReadWrite<f32>,
        depths: ReadWrite<f32>,
    }
}

/// The variant of `stochastic/visibility`, from that of shape and falloff.
fn tile_variant(shape: Variant, run: OneRun, strata: u32) -> Variant {
    bin::region_variant(shape, run)
        .constant("STRATA", strata)
        .each("stratum", strata)
        .each("pair", strata / STRATA_OF_A_CALL)
}

impl Sampler {
    /// Records both passes over all splats for some strata.
    pub(super) fn record_tiles<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &SampleJob<'a>,
        tiles: OrderedTiles<'a>,
        batch: Batch,
        target: &'a Target,
    ) -> Result<(), Error> {
        let (held_keys, held_indices) = (self.keys.get().all(), self.indices.get().all());
        let ids = job.bin.raster.cloud.ids.all();
        let visibility = Visibility { tiles: tiles.tiled, held_keys, held_indices, ids };
        let accumulate = Accumulate {
            tiles: tiles.tiled,
            held_keys,
            held_indices,
            sums: self.sums.get().all(),
            exact: self.exact.get().all(),
            depths: target.depths(),
        };
        let binned = tiles.binned;
        let shape = compose::variant(binned.cut(), job.bin.raster.footprint, job.settings.discs.falloff);
        let runs = binned.region_segments();
        let push = |walk| push(job, walk, batch);
        let tile = |run| tile_variant(shape.clone(), run, batch.strata);
        binned.record_runs(recorder, &visibility, runs, push, tile)?;
        // All strata have the same exact A: the first ones find it.
        let kind = SampleKind { exact: job.finds_exact() && batch.before == 0, ..job.kind() };
        binned.record_runs(recorder, &accumulate, runs, push, |run| kind.apply_to(tile(run)))?;
        Ok(())
    }
}

fn push(job: &SampleJob<'_>, walk: TileWalk, Batch { before, left, .. }: Batch) -> StochasticPush {
    let [key_low, key_high] = random::key(job.seed);
    let key_high = key_high.wrapping_add(before / STRATUM / STRATA_OF_A_CALL);
    let pixels = job.pixels() as u32;
    StochasticPush { walk, pixels, before, left, key_low, key_high }
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    let tiles = bin::run_variants(compose::variants(), &STRATA, tile_variant);
    let kinds = || SampleKind::all().into_iter();
    let accumulate = tiles.iter().flat_map(|tile| kinds().map(move |kind| kind.apply_to(tile.clone())));
    vec![Shader::new::<Accumulate>(accumulate), Shader::new::<Visibility>(tiles.clone())]
}
