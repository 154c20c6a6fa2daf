//! Long lists of events: each run is composed by itself.

use super::Spheres;
use super::interior::SphereKind;
use super::passes::{BlendRuns, Carry, Samples, Segments, SoftPush, SumRuns};
use crate::methods::abuffer::{RunBuffers, RunSums, Runs, Sampled};
use crate::methods::prelude::*;

/// Events of a list that one run of `soft/segments` looks at: one iteration each.
pub(super) const SEGMENTS_TAKEN: u32 = 49_152;

/// Records the composition of each run.
pub(super) fn record<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    runs: &Runs<'a>,
    buffers: &'a RunBuffers,
    longest: u32,
) -> Result<(), Error> {
    let Runs { cut, sorted, records, partials, .. } = *runs;
    let (sums, segments) = (buffers.sums.get().all(), buffers.segments.get().all());
    let push = spheres.push(0, 0, 0.0);
    record_sums(recorder, spheres, runs, sums)?;
    if spheres.kind.interior.is_integrated() {
        for first in (0..longest).step_by(SEGMENTS_TAKEN as usize) {
            let run = runs.over_whole_runs(segments_variant(spheres.kind, cut));
            recorder.run(&Segments { sorted, segments, records }, SoftPush { first, ..push }, &run)?;
        }
    }
    let blend = BlendRuns { sorted, sums, segments, partials, records };
    Ok(recorder.run(&blend, push, &runs.over_runs(run_variant(spheres.kind, cut)))?)
}

/// Records samples of each run of lists of events of concentric shells; `several` if a list has more than one.
pub(super) fn record_samples<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    runs: &Runs<'a>,
    (several, sums): (bool, Slice<'a, RunSums>),
    samples: Sampled<'a>,
) -> Result<(), Error> {
    if several {
        record_sums(recorder, spheres, runs, sums)?;
    }
    let samples = Samples { sorted: runs.sorted, sums, samples, records: runs.records };
    let over_runs = runs.over_runs(run_variant(spheres.kind, runs.cut));
    Ok(recorder.run(&samples, spheres.push(0, 0, 0.0), &over_runs)?)
}

/// Records the running sums before each run.
fn record_sums<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    runs: &Runs<'a>,
    sums: Slice<'a, RunSums>,
) -> Result<(), Error> {
    let over_runs = runs.over_runs(run_variant(spheres.kind, runs.cut));
    let sum = SumRuns { sorted: runs.sorted, sums, records: runs.records };
    recorder.run(&sum, spheres.push(0, 0, 0.0), &over_runs)?;
    record_carry(recorder, runs, sums)
}

/// Records the running sums before each run, from what each run adds.
pub(in crate::methods) fn record_carry<'a>(
    recorder: &mut Recorder<'a>,
    runs: &Runs<'a>,
    sums: Slice<'a, RunSums>,
) -> Result<(), Error> {
    let carry = Carry { work: runs.sorted.work, lists: runs.lists, sums };
    Ok(recorder.run(&carry, (), &runs.over_lists(Variant::plain()))?)
}

/// Returns the variant of the passes over runs of long lists.
pub(super) fn run_variant(kind: SphereKind, cut: Cut) -> Variant {
    kind.interior.terms(compose::variant(cut, kind.footprint(), Falloff::Flat), kind.modulated)
}

/// Returns the variant of `soft/segments`.
pub(super) fn segments_variant(kind: SphereKind, cut: Cut) -> Variant {
    run_variant(kind, cut).with("TAKEN", SEGMENTS_TAKEN)
}
