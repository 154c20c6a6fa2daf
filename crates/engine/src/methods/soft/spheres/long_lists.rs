//! Long lists of events: each run is composed by itself.

use super::Spheres;
use super::interior::Kind;
use super::passes::{BlendRuns, Carry, RunSums, Samples, Segments, SoftPush, SumRuns};
use crate::gpu::{Device, Dispatch, Kept, Memory, Recorder, Run, Slice, Variant};
use crate::methods::Error;
use crate::methods::abuffer::{LOCAL_LENGTH, ListRun, LongList, LongWork, Partial, long_groups};
use crate::passes::compose::{self, Cut};
use crate::scene::Falloff;

/// Events of a list that one run of `soft/segments` looks at: one iteration each.
pub(super) const SEGMENTS_TAKEN: u32 = 49_152;

/// Buffers of long lists, kept from frame to frame.
pub struct LongSpheres {
    segments: Kept<f32>,
    sums: Kept<RunSums>,
}

impl Default for LongSpheres {
    fn default() -> Self {
        Self { segments: Kept::new("segments", Memory::Device), sums: Kept::new("sums of runs", Memory::Device) }
    }
}

/// A band's long lists, sorted.
#[derive(Clone, Copy)]
pub struct Sorted<'a> {
    /// Way to reach the splats.
    pub composing: compose::Composing<'a>,
    /// The same.
    pub cut: Cut,
    /// Counts and indirect arguments.
    pub work: Slice<'a, LongWork>,
    /// The runs.
    pub runs: Slice<'a, ListRun>,
    /// The lists.
    pub lists: Slice<'a, LongList>,
    /// Buffer of their events.
    pub fragments: Slice<'a, [u32; 2]>,
    /// Records of packed events.
    pub records: Slice<'a, [u32; 4]>,
    /// Buffer that the composed runs are written to.
    pub partials: Slice<'a, Partial>,
}

impl LongSpheres {
    /// Room for so many runs, and for the segments of a band of so many events.
    pub fn reserve(&mut self, device: &Device, runs: u64, events: u64, limit: u64) -> Result<(), Error> {
        self.sums.reserve(device, runs.max(1))?;
        self.segments.reserve_within(device, events.max(1), limit.max(1))?;
        Ok(())
    }

    /// Frees the buffers of [`Self::reserve`].
    pub fn release(&mut self) {
        self.segments.release();
        self.sums.release();
    }

    /// Records the composition of each run.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        spheres: &Spheres<'a>,
        sorted: &Sorted<'a>,
        longest: u32,
    ) -> Result<(), Error> {
        let Sorted { composing, cut, work, runs, lists, fragments, records, partials } = *sorted;
        let (sums, segments) = (self.sums.get().all(), self.segments.get().all());
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
}

/// Records samples of each run of lists of events of concentric shells; `several` if a list has more than one.
pub fn record_samples<'a>(
    recorder: &mut Recorder<'a>,
    spheres: &Spheres<'a>,
    sorted: &Sorted<'a>,
    (several, sums): (bool, Slice<'a, RunSums>),
    (sample_colors, sample_depths): (Slice<'a, [f32; 4]>, Slice<'a, [f32; 2]>),
) -> Result<(), Error> {
    let Sorted { composing, cut, work, runs, lists, fragments, records, .. } = *sorted;
    let push = spheres.push(0, 0, 0.0);
    let over_runs = || Run::new(long_groups(work, 0)).variant(run_variant(spheres.kind, cut));
    if several {
        recorder.run(&SumRuns { composing, work, runs, fragments, sums, records }, push, &over_runs())?;
        recorder.run(&Carry { work, lists, sums }, (), &Run::new(long_groups(work, 4)))?;
    }
    let samples = Samples { composing, work, runs, fragments, sums, sample_colors, sample_depths, records };
    Ok(recorder.run(&samples, push, &over_runs())?)
}

/// Runs of long lists of so many events at most.
pub fn long_runs(events: u64) -> u64 {
    (2 * events).div_ceil(u64::from(LOCAL_LENGTH))
}

/// Returns the variant of the passes over runs of long lists.
pub(super) fn run_variant(kind: Kind, cut: Cut) -> Variant {
    kind.interior.terms(compose::variant(cut, kind.footprint(), Falloff::Flat), kind.modulated)
}

/// Returns the variant of `soft/segments`.
pub(super) fn segments_variant(kind: Kind, cut: Cut) -> Variant {
    run_variant(kind, cut).with("TAKEN", SEGMENTS_TAKEN)
}
