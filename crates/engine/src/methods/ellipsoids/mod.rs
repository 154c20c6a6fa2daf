//! Gaussians as ellipsoids of constant density (`kernel = "ellipsoid"`) in the lists of `abuffer` and `linked-list`.
//!
//! A pixel's list holds events: where its ray enters and leaves each ellipsoid, and where it meets a surface: a disc, an ellipsoid without
//! thickness, or one so thin that float32 has one depth for both ends. Counting, scan, bands, sorting and merging are those of other
//! lists. Each run of 256 sorted events is then composed by itself, of short lists too: between two events the densities of what is
//! open add up (Mai et al. 2025, "EVER", as Seemann et al. 2018 have it for shells), and the sums before a run follow from what the
//! runs before add.
//!
//! The sums are kept to twice the digits of float32. What an ellipsoid of density σ leaves of itself when it is taken out again is then some 2⁻⁴⁸σ,
//! and its chord is at least 2⁻²⁴ of the depths: its optical depth is so large wherever the rest shows that nothing is seen behind it.

mod passes;

pub use passes::*;

use super::Error;
use super::abuffer::{ListRun, LongList, LongWork, Partial, Shown, composing_variant, long_groups};
use super::soft::{Carry, RunSums};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Device, Dispatch, Kept, Memory, Recorder, Run, Slice, Variant};
use crate::passes::bands::Band;
use crate::passes::compose::{self, Composing, Cut};
use crate::passes::project::Footprint;
use crate::passes::raster::{self, Chunk, Raster};
use crate::passes::tiles::SEGMENT;
use crate::scene::Falloff;

/// Device bytes per pixel beside those of lists: the number of bodies, and a run of the list with its sums and what it is composed to.
pub const PIXEL_BYTES: u64 = 4 + 12 + 16 + 48 + 32;

/// Sums of runs, kept from frame to frame.
pub struct Sums(Kept<RunSums>);

impl Default for Sums {
    fn default() -> Self {
        Self(Kept::new("sums of runs of ellipsoids", Memory::Device))
    }
}

/// A band's lists, sorted, and their runs.
#[derive(Clone, Copy)]
pub struct Sorted<'a> {
    /// Way to reach the splats.
    pub composing: Composing<'a>,
    /// The same.
    pub cut: Cut,
    /// Falloff of opacity toward the rim of a disc.
    pub falloff: Falloff,
    /// Counts and indirect arguments.
    pub work: Slice<'a, LongWork>,
    /// The runs.
    pub runs: Slice<'a, ListRun>,
    /// The lists.
    pub lists: Slice<'a, LongList>,
    /// Buffer of their events.
    pub fragments: Slice<'a, [u32; 2]>,
    /// Buffer that the composed runs are written to.
    pub partials: Slice<'a, Partial>,
}

impl Sums {
    /// Room for so many runs; none takes no memory.
    pub fn reserve(&mut self, device: &Device, runs: u64) -> Result<(), Error> {
        if runs == 0 {
            self.0.release();
            return Ok(());
        }
        Ok(self.0.reserve(device, runs)?)
    }

    /// Records the composition of each run; `several` if a list has more than one.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        sorted: &Sorted<'a>,
        several: bool,
        shown: Shown,
    ) -> Result<(), Error> {
        let Sorted { composing, cut, falloff, work, runs, fragments, partials, .. } = *sorted;
        let sums = self.0.get().all();
        if several {
            self.record_sums(recorder, sorted)?;
        }
        let blend = BlendRuns { composing, work, runs, fragments, sums, partials };
        let variant = composing_variant(run_variant(cut, falloff), shown);
        Ok(recorder.run(&blend, (), &Run::new(long_groups(work, 0)).variant(variant))?)
    }

    /// Records what is open before each run.
    fn record_sums<'a>(&'a self, recorder: &mut Recorder<'a>, sorted: &Sorted<'a>) -> Result<(), Error> {
        let Sorted { composing, cut, falloff, work, runs, lists, fragments, .. } = *sorted;
        let sums = self.0.get().all();
        let over_runs = Run::new(long_groups(work, 0)).variant(run_variant(cut, falloff));
        recorder.run(&SumRuns { composing, work, runs, fragments, sums }, (), &over_runs)?;
        Ok(recorder.run(&Carry { work, lists, sums }, (), &Run::new(long_groups(work, 4)))?)
    }

    /// Returns the sums themselves.
    pub fn sums(&self) -> Slice<'_, RunSums> {
        self.0.get().all()
    }

    /// Records samples of each run; `several` if a list has more than one, `bodies` if each ellipsoid is one sample.
    pub fn record_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        sorted: &Sorted<'a>,
        (several, bodies): (bool, bool),
        (sample_colors, sample_depths): (Slice<'a, [f32; 4]>, Slice<'a, [f32; 2]>),
    ) -> Result<(), Error> {
        let Sorted { composing, cut, falloff, work, runs, fragments, .. } = *sorted;
        if several && !bodies {
            self.record_sums(recorder, sorted)?;
        }
        let samples =
            Samples { composing, work, runs, fragments, sums: self.0.get().all(), sample_colors, sample_depths };
        let variant = samples_variant(run_variant(cut, falloff), bodies);
        Ok(recorder.run(&samples, (), &Run::new(long_groups(work, 0)).variant(variant))?)
    }

    /// Records the depths at which half of the light or less is left, from the composed runs.
    pub fn record_medians<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        sorted: &Sorted<'a>,
        depths: Slice<'a, f32>,
    ) -> Result<(), Error> {
        let Sorted { composing, cut, falloff, work, runs, lists, fragments, partials } = *sorted;
        let median = Median { composing, work, lists, runs, fragments, sums: self.0.get().all(), partials, depths };
        Ok(recorder.run(&median, (), &Run::new(long_groups(work, 4)).variant(run_variant(cut, falloff)))?)
    }
}

/// Records the count of events, and of what they are of.
pub fn record_count<'a>(
    recorder: &mut Recorder<'a>,
    raster: &Raster<'a>,
    counts: Slice<'a, u32>,
    bodies: Slice<'a, u32>,
) -> Result<(), Error> {
    let whole = Band::whole(raster.window, 0);
    Ok(raster.record(recorder, &whole, |chunk: Chunk<'a>| Count { chunk, counts, bodies })?)
}

/// Records a band's store into slots.
pub fn record_store<'a>(
    recorder: &mut Recorder<'a>,
    raster: &Raster<'a>,
    band: &Band,
    cursors: Slice<'a, u32>,
    fragments: Slice<'a, [u32; 2]>,
) -> Result<(), Error> {
    Ok(raster.record(recorder, band, |chunk: Chunk<'a>| Store { chunk, cursors, fragments })?)
}

/// Records the work lists of the runs and lists of a band.
pub fn record_split<'a>(recorder: &mut Recorder<'a>, split: Split<'a>, band: &Band) -> Result<(), Error> {
    let [band_start, band_end] = band.pixels;
    let push = SplitPush { band_start, band_end, first_fragment: band.first_fragment };
    Ok(recorder.run(&split, push, &Run::new(Dispatch::Invocations(u64::from(band_end - band_start))))?)
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
    let walked = || raster::computed_variants(&[Footprint::Gaussian], SEGMENT);
    let runs = || <(Cut, Falloff)>::all().into_iter().map(|(cut, falloff)| run_variant(cut, falloff));
    vec![
        Shader::new::<Count>(walked()),
        Shader::new::<Store>(walked()),
        Shader::new::<Link>(walked()),
        Shader::plain::<Split>(),
        Shader::new::<SumRuns>(runs()),
        Shader::new::<BlendRuns>(
            runs().flat_map(|run| [Shown::First, Shown::Mean].map(|shown| composing_variant(run.clone(), shown))),
        ),
        Shader::new::<Median>(runs()),
        Shader::new::<Samples>(runs().flat_map(|run| [false, true].map(|bodies| samples_variant(run.clone(), bodies)))),
    ]
}
