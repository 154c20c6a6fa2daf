//! Long lists of events: each run is composed by itself.

use super::Spheres;
use super::interior::Kind;
use super::passes::{BlendRuns, Carry, Samples, Segments, SoftPush, SumRuns};
use crate::gpu::{Dispatch, Recorder, Run, Slice, Variant};
use crate::methods::Error;
use crate::methods::abuffer::{RunBuffers, RunSums, Runs, long_groups};
use crate::passes::compose::{self, Cut};
use crate::scene::Falloff;

/// Events of a list that one run of `soft/segments` looks at: one iteration each.
pub(super) const SEGMENTS_TAKEN: u32 = 49_152;

/// Records the composition of each run.
pub(super) fn record<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    sorted: &Runs<'a>,
    buffers: &'a RunBuffers,
    longest: u32,
) -> Result<(), Error> {
    let Runs { composing, cut, work, runs, lists, fragments, records, partials } = *sorted;
    let (sums, segments) = (buffers.sums.get().all(), buffers.segments.get().all());
    let arguments = |word| Dispatch::Indirect(work.cast().skip(word).first(3));
    let variant = run_variant(spheres.kind, cut);
    let push = spheres.push(0, 0, 0.0);
    let over_runs = || Run::new(arguments(0)).variant(variant.clone());
    recorder.run(&SumRuns { composing, work, runs, fragments, sums, records }, push, &over_runs())?;
    recorder.run(&Carry { work, lists, sums }, (), &Run::new(arguments(4)))?;
    if spheres.kind.interior.is_integrated() {
        for first in (0..longest).step_by(SEGMENTS_TAKEN as usize) {
            let push = SoftPush { first, ..push };
            let run = Run::new(arguments(8)).variant(segments_variant(spheres.kind, cut));
            recorder.run(&Segments { composing, work, runs, fragments, segments, records }, push, &run)?;
        }
    }
    let blend = BlendRuns { composing, work, runs, fragments, sums, segments, partials, records };
    Ok(recorder.run(&blend, push, &over_runs())?)
}

/// Records samples of each run of lists of events of concentric shells; `several` if a list has more than one.
pub(super) fn record_samples<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    sorted: &Runs<'a>,
    (several, sums): (bool, Slice<'a, RunSums>),
    (sample_colors, sample_depths): (Slice<'a, [f32; 4]>, Slice<'a, [f32; 2]>),
) -> Result<(), Error> {
    let Runs { composing, cut, work, runs, lists, fragments, records, .. } = *sorted;
    let push = spheres.push(0, 0, 0.0);
    let over_runs = || Run::new(long_groups(work, 0)).variant(run_variant(spheres.kind, cut));
    if several {
        recorder.run(&SumRuns { composing, work, runs, fragments, sums, records }, push, &over_runs())?;
        recorder.run(&Carry { work, lists, sums }, (), &Run::new(long_groups(work, 4)))?;
    }
    let samples = Samples { composing, work, runs, fragments, sums, sample_colors, sample_depths, records };
    Ok(recorder.run(&samples, push, &over_runs())?)
}

/// Returns the variant of the passes over runs of long lists.
pub(super) fn run_variant(kind: Kind, cut: Cut) -> Variant {
    kind.interior.terms(compose::variant(cut, kind.footprint(), Falloff::Flat), kind.modulated)
}

/// Returns the variant of `soft/segments`.
pub(super) fn segments_variant(kind: Kind, cut: Cut) -> Variant {
    run_variant(kind, cut).with("TAKEN", SEGMENTS_TAKEN)
}
