//! Gaussians as ellipsoids of constant density (`kernel = "ellipsoid"`) in the lists of `abuffer` and `linked-list`.
//!
//! A pixel's list holds events: where its ray enters and leaves each ellipsoid, and where it meets a surface: a disc,
//! an ellipsoid without thickness, or one so thin that float32 has one depth for both ends. Counting, scan, bands,
//! sorting and merging are those of other lists. Each run of 256 sorted events is then composed by itself, of short
//! lists too: between two events the densities of what is open add up (Mai et al. 2025, "EVER", as Seemann et al. 2018
//! have it for shells), and the sums before a run follow from what the runs before add.
//!
//! The sums are kept to twice the digits of float32. What an ellipsoid of density σ leaves of itself when it is taken
//! out again is then some 2⁻⁴⁸σ, and its chord is at least 2⁻²⁴ of the depths: its optical depth is so large wherever
//! the rest shows that nothing is seen behind it.

use super::abuffer::{
    self, Blending, Bodies, Counting, LOCAL_LENGTH, ListedGroup, Needs, Partial, RUN_PIXEL_BYTES, RunSums, Runs,
    Sampled, SampledGroup, Shown, SortedGroup, StoreFragments, Storing, composing_variant,
};
use super::soft::record_carry;
use crate::methods::linked_list::{self, LinkingGroup};
use crate::methods::prelude::*;

/// Events of ellipsoids and surfaces.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoids {
    /// `true` if events are stored through linked lists.
    pub linked: bool,
}

impl StoreFragments for Ellipsoids {
    fn name(&self) -> &'static str {
        "ellipsoids/store"
    }

    /// An ellipsoid has two events, and a surface one.
    fn bodies(&self) -> Bodies {
        Bodies::Counted
    }

    fn needs(&self) -> Needs {
        Needs { links: self.linked, every_run: true, ..Needs::default() }
    }

    fn pixel_bytes(&self) -> u64 {
        RUN_PIXEL_BYTES
    }

    fn record_count<'a>(&'a self, recorder: &mut Recorder<'a>, counting: Counting<'a>) -> Result<(), Error> {
        let Counting { raster, counts, bodies } = counting;
        raster.record_tiles(recorder)?;
        let whole = Band::whole(raster.window, 0);
        Ok(raster.record(recorder, &whole, |chunk: Chunk<'a>| Count { chunk, counts, bodies })?)
    }

    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, storing: Storing<'a>) -> Result<(), Error> {
        let Storing { raster, band, room, .. } = storing;
        if self.linked {
            return linked_list::record(recorder, storing, |recorder, lists| {
                Ok(raster.record(recorder, &band, |chunk: Chunk<'a>| Link { chunk, lists })?)
            });
        }
        let (cursors, fragments) = (room.counts.get().all(), room.fragments.get().all());
        Ok(raster.record(recorder, &band, |chunk: Chunk<'a>| Store { chunk, cursors, fragments })?)
    }

    fn record_blend<'a>(&'a self, recorder: &mut Recorder<'a>, blending: &Blending<'a>) -> Result<(), Error> {
        let Blending { blender, target, .. } = *blending;
        let runs = blender.record_every_list(recorder, blending)?;
        let (shown, sums, partials) = (blending.job.shown, blender.long().sums.get().all(), runs.partials);
        let variant = run_variant(runs.cut, blending.job.discs.falloff);
        if blending.lengths.longest > LOCAL_LENGTH {
            record_sums(recorder, &runs, sums, variant.clone())?;
        }
        let blend = BlendRuns { sorted: runs.sorted, sums, partials };
        recorder.run(&blend, (), &runs.over_runs(composing_variant(variant.clone(), shown)))?;
        blender.record_combine(recorder, shown, target)?;
        if shown == Shown::Median {
            let median = Median { sorted: runs.listed(), sums, partials, depths: target.depths() };
            recorder.run(&median, (), &runs.over_lists(variant))?;
        }
        Ok(())
    }

    /// Records the samples of a deep EXR. With `bodies` each ellipsoid is one sample, however many of them overlap.
    fn record_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        bodies: bool,
        samples: Sampled<'a>,
    ) -> Result<(), Error> {
        let blender = blending.blender;
        let runs = blender.record_every_list(recorder, blending)?;
        let sums = blender.long().sums.get().all();
        let variant = run_variant(runs.cut, blending.job.discs.falloff);
        if blending.lengths.longest > LOCAL_LENGTH && !bodies {
            record_sums(recorder, &runs, sums, variant.clone())?;
        }
        let taking = runs.over_runs(samples_variant(variant, bodies));
        Ok(recorder.run(&Samples { sorted: runs.sorted, sums, samples }, (), &taking)?)
    }
}

/// Records what is open before each run.
fn record_sums<'a>(
    recorder: &mut Recorder<'a>,
    runs: &Runs<'a>,
    sums: Slice<'a, RunSums>,
    variant: Variant,
) -> Result<(), Error> {
    recorder.run(&SumRuns { sorted: runs.sorted, sums }, (), &runs.over_runs(variant))?;
    record_carry(recorder, runs, sums)
}

/// The variant of the passes over runs.
fn run_variant(cut: Cut, falloff: Falloff) -> Variant {
    compose::variant(cut, Footprint::Gaussian, falloff)
}

/// The variant of `ellipsoids/samples`.
fn samples_variant(run: Variant, bodies: bool) -> Variant {
    run.with("BODIES", u32::from(bodies))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let walked = || raster::computed_variants(&[Footprint::Gaussian]);
    let runs = || <(Cut, Falloff)>::all().into_iter().map(|(cut, falloff)| run_variant(cut, falloff));
    vec![
        Shader::new::<Count>(walked()),
        Shader::new::<Store>(walked()),
        Shader::new::<Link>(walked()),
        Shader::plain::<abuffer::SplitEvery>(),
        Shader::new::<SumRuns>(runs()),
        Shader::new::<BlendRuns>(
            runs().flat_map(|run| [Shown::First, Shown::Mean].map(|shown| composing_variant(run.clone(), shown))),
        ),
        Shader::new::<Median>(runs()),
        Shader::new::<Samples>(runs().flat_map(|run| [false, true].map(|bodies| samples_variant(run.clone(), bodies)))),
    ]
}

pass! {
    /// Counts the events of each pixel, and what they are of: an ellipsoid that its ray enters and leaves, or a
    /// surface.
    pub Count(RasterPush) = "ellipsoids/count" {
        chunk: Shared<ChunkGroup>,
        counts: ReadWrite<u32>,
        bodies: ReadWrite<u32>,
    }

    /// Stores the depth key and index of each event in a slot of its pixel's range.
    pub Store(RasterPush) = "ellipsoids/store" {
        chunk: Shared<ChunkGroup>,
        cursors: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }

    /// Takes a node for each event, and puts it before the pixel's list, for `linked-list`.
    pub Link(RasterPush) = "ellipsoids/link" {
        chunk: Shared<ChunkGroup>,
        lists: Shared<LinkingGroup>,
    }

    /// Sums what the events of each run of a sorted list of several add to color and density of what is open.
    pub SumRuns = "ellipsoids/sum-runs" in "ellipsoids/sum_runs" {
        sorted: Shared<SortedGroup>,
        sums: ReadWrite<RunSums>,
    }

    /// Finds the depth at which each list first lets through half of the light or less, for eye-dome lighting and
    /// `depth.median`, from its composed runs and the events of one.
    pub Median = "ellipsoids/median" {
        sorted: Shared<ListedGroup>,
        sums: Read<RunSums>,
        partials: Read<Partial>,
        depths: ReadWrite<f32>,
    }

    /// Composes the surfaces of each run, and the segments between events.
    pub BlendRuns = "ellipsoids/blend-runs" in "ellipsoids/blend_runs" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        partials: ReadWrite<Partial>,
    }

    /// Writes the surfaces of each run of a sorted list and the pieces of the ray between events, for a deep EXR; or
    /// each ellipsoid as a whole, where no sample is to be split.
    pub Samples = "ellipsoids/samples" {
        sorted: Shared<SortedGroup>,
        sums: Read<RunSums>,
        samples: Shared<SampledGroup>,
    }
}
