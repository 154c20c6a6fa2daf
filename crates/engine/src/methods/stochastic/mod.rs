//! `stochastic`: multi-sample stochastic transparency of the discs of `abuffer` (Enderton, Sintorn, Shirley, Luebke
//! 2011).
//!
//! Each fragment covers random samples of its pixel ([`crate::random`]); a sample holds the nearest fragment that
//! covers it, and a fragment counts in the samples that hold nothing nearer. No order of fragments is needed, but two
//! passes over the splats for each few strata of four samples. What a stratum says is one of many independent
//! estimates, whose spread tells the standard error.
//!
//! Reference: `pellucid_reference::stochastic`.

mod engine;
pub mod hardware;

pub use engine::{Accumulate, StochasticPush, Visibility};
pub(crate) use engine::{StochasticEngine, pass_group};

use super::parts::{MOST_STRATA, Plane};
use crate::image;
use crate::methods::prelude::*;
use crate::random::{self, STRATA_OF_A_CALL, STRATUM};
use crate::scene::Stochastic;

/// Samples of the first round where an error is asked for: the spread of four strata tells how many it takes.
pub const FIRST_SAMPLES: u32 = 16;

gpu_struct! {
    /// Push constants of `stochastic/gather`.
    pub struct GatherPush {
        pixels: u32,
        before: u32, // Samples of the strata before, and those to take from the run's first one on.
        left: u32,
    }

    /// Push constants of `stochastic/resolve`: pixels of the window, and samples of each.
    pub struct ResolvePush {
        pixels: u32,
        samples: u32,
    }
}

pass! {
    /// Adds the sums of a run's strata to those before in each pixel, and their spread where the standard error is
    /// asked for.
    pub Gather(GatherPush) = "stochastic/gather" {
        sums: Read<[f32; 4]>,
        image: ReadWrite<[f32; 4]>,
        spread: ReadWrite<[f32; 4]>,
    }

    /// Turns the sums of each pixel into color, A and standard error.
    pub Resolve(ResolvePush) = "stochastic/resolve" {
        exact: Read<f32>,
        image: ReadWrite<[f32; 4]>,
        spread: ReadWrite<[f32; 4]>,
    }
}

/// Some strata that go through the splats together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Batch {
    /// Samples of the strata before; whole strata.
    pub before: u32,
    /// Samples to take, at most those of the strata.
    pub left: u32,
    /// Strata that the kernels hold: whole calls of the random numbers, the last ones perhaps for nothing.
    pub strata: u32,
}

/// Settings on which every pass depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleKind {
    /// `true` if A is exact and color scaled by it: alpha correction.
    pub exact: bool,
    /// `true` if the standard error is asked for.
    pub spread: bool,
}

choices!(struct SampleKind { exact, spread });

impl SampleKind {
    /// Returns a variant with the overrides of both.
    pub fn apply_to(self, variant: Variant) -> Variant {
        variant.with("SPREAD", u32::from(self.spread)).with("EXACT", u32::from(self.exact))
    }

    /// Vectors of `sums` for each pixel, of so many strata.
    fn sums(self, strata: u32) -> u64 {
        if self.spread { 1 + u64::from(strata) } else { 1 }
    }
}

/// The variant of `stochastic/gather`.
fn gather_variant(kind: SampleKind, strata: u32) -> Variant {
    kind.apply_to(Variant::plain()).each("stratum", strata)
}

/// The variant of `stochastic/resolve`.
fn resolve_variant(kind: SampleKind) -> Variant {
    kind.apply_to(Variant::plain())
}

/// Returns the batches that make up so many samples.
pub fn batches(samples: u32) -> impl Iterator<Item = Batch> {
    (0..samples).step_by((MOST_STRATA * STRATUM) as usize).map(move |before| {
        let left = (samples - before).min(MOST_STRATA * STRATUM);
        Batch { before, left, strata: left.div_ceil(STRATUM).next_multiple_of(STRATA_OF_A_CALL) }
    })
}

/// Most strata of a batch.
fn most_strata(batches: impl Iterator<Item = Batch>) -> u32 {
    batches.map(|batch| batch.strata).max().unwrap_or(0)
}

/// Returns the number of bytes that a pass must at least read and write for so many pixels of `samples` each; `splat`
/// bytes of a splat, its color and record aside.
pub fn least_bytes(name: &str, samples: u32, kind: SampleKind, facts: &Facts, pixels: u64, splat: u64) -> Option<u64> {
    let runs = batches(samples).count() as u64;
    let strata: u64 = batches(samples).map(|b| u64::from(b.strata)).sum();
    // Keys and indices; sums of each run and, for the spread, of each stratum.
    let (held, sums) = (pixels * strata * 32, pixels * 16 * (runs + if kind.spread { strata } else { 0 }));
    let exact = if kind.exact { pixels * 4 } else { 0 };
    let walks = runs * (facts.tile_entries * 4 + facts.visible * (splat - 4 + 16 + 8));
    let spread = if kind.spread { pixels * 32 } else { 0 };
    match name {
        "stochastic/visibility" => Some(walks + held),
        // Every run but the first reads depths.
        "stochastic/accumulate" => Some(walks + held + sums + exact + pixels * 4 * (2 * runs - 1)),
        "stochastic/gather" => Some(sums + (pixels * 16 + spread) * (2 * runs - 1)),
        "stochastic/resolve" => Some(pixels * 32 + exact + spread),
        _ => None,
    }
}

/// Returns device bytes per pixel of a window, without the tiles.
pub fn pixel_bytes(spread: bool) -> u64 {
    let kind = SampleKind { exact: true, spread };
    // Keys and indices held by the samples, sums, exact A; Q, S and X of the spread.
    16 * (2 * u64::from(MOST_STRATA) + kind.sums(MOST_STRATA)) + 4 + if spread { 32 } else { 0 }
}

/// Returns the number of pixels of a window whose buffers fit a binding, and a quarter of the budget.
pub fn window_pixels(budget: Budget, bytes_per_pixel: u64, spread: bool) -> u64 {
    let widest = u64::from(MOST_STRATA) + u64::from(spread);
    budget.window_pixels(bytes_per_pixel).min(budget.binding / 16 / widest).max(1)
}

/// Returns the number of samples of the next round of a frame whose standard errors are to fall to `most` (root mean
/// square over pixels and R, G, B), from those of a round with `samples`; `None` where they have, or where there are
/// `limit` samples already.
///
/// Rounds begin anew: what stands in a window's buffers is gone when the next window is rendered, and whether one
/// window or many make up the frame must not change it. Since errors fall as 1/√samples, the second round is mostly the
/// last.
pub fn more_samples(samples: u32, limit: u32, errors: &[[f32; 3]], most: f32) -> Option<u32> {
    let mean = image::mean_square(errors);
    if samples >= limit || mean.sqrt() <= f64::from(most) {
        return None;
    }
    // 5% more, so that chance seldom asks for a third round; casting saturates, and NaN is 0.
    let wanted = (1.05 * f64::from(samples) * mean / f64::from(most).powi(2)).min(f64::from(limit)) as u32;
    let batch = MOST_STRATA * STRATUM;
    Some(wanted.next_multiple_of(batch).max(samples + batch).min(limit))
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct SampleJob<'a> {
    /// The splats to bin.
    pub bin: bin::Job<'a>,
    /// Discs, correction, and where samples end.
    pub settings: Stochastic,
    /// The first sample: with it a batch begins.
    pub first: u32,
    /// Seed of the masks.
    pub seed: u64,
    /// Calls of the random numbers that the images before this one have: each has numbers of its own.
    pub calls: u32,
    /// `true` if the standard error is asked for.
    pub spread: bool,
}

/// Returns the calls of the random numbers that so many samples of a pixel have.
pub(super) fn calls_of(samples: u32) -> u32 {
    samples.div_ceil(STRATUM * STRATA_OF_A_CALL)
}

impl SampleJob<'_> {
    /// Returns the key of a call of the random numbers, counted from the image's first.
    fn key(&self, call: u32) -> [u32; 2] {
        let [low, high] = random::key(self.seed);
        [low, high.wrapping_add(self.calls + call)]
    }

    fn kind(&self) -> SampleKind {
        SampleKind { exact: self.settings.alpha_correction, spread: self.spread }
    }

    fn pixels(&self) -> u64 {
        bands::pixels(self.bin.raster.window)
    }

    /// The batches that make up its samples.
    fn batches(&self) -> impl Iterator<Item = Batch> + use<> {
        let first = self.first;
        batches(self.settings.samples).filter(move |batch| batch.before >= first)
    }

    /// Returns `true` if it finds the exact A: all samples have the same, so that the first ones are enough.
    fn finds_exact(&self) -> bool {
        self.settings.alpha_correction && self.first == 0
    }
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Sampler {
        keys: Scratch<[u32; 4]> = Scratch::new("sample depths", Memory::Device),
        indices: Scratch<[u32; 4]> = Scratch::new("sample splats", Memory::Device),
        sums: Scratch<[f32; 4]> = Scratch::new("sample sums", Memory::Device),
        exact: Scratch<f32> = Scratch::new("exact alpha", Memory::Device),
        spread: Scratch<[f32; 4]> = Scratch::new("sample spread", Memory::Device),
        told: Told<[f32; 4]> = Told::new("sample spread, host"),
        attachments: hardware::Attachments = hardware::Attachments::default(),
    }
}

impl Sampler {
    /// Renders a window into the target, or keeps its sums.
    pub(crate) fn render(
        &mut self,
        bins: &mut Bins,
        work: &mut Work<'_>,
        job: &SampleJob<'_>,
    ) -> Result<Outcome, Error> {
        let (device, target) = (work.device, work.target);
        match bins.bin(device, &job.bin, work.timeline)? {
            Bin::TooLarge => return Ok(Outcome::Overflow),
            Bin::Nothing => {
                self.spread.reserve(device, if job.spread { job.pixels() } else { 1 })?;
                self.told.reserve(device, if job.spread { job.pixels() } else { 0 })?;
                self.end_empty(work, job)?;
            }
            Bin::Done(binned) => {
                work.note_binned(binned);
                work.facts.bands += 1;
                self.reserve(device, job)?;
                for batch in job.batches() {
                    let mut recorder = self.begin_batch(work, job, batch)?;
                    let tiles = if batch.before == job.first {
                        bins.record_tiles(&mut recorder, job.bin.raster.cloud, binned)?
                    } else {
                        bins.tiles(job.bin.raster.cloud, binned)
                    };
                    self.record_tiles(&mut recorder, job, tiles, batch, target)?;
                    self.end_batch(recorder, work, (job, batch), "stochastic/visibility and accumulate")?;
                }
                self.end(work, job)?;
            }
        }
        Ok(Outcome::Done)
    }

    /// Resolves sums that were put together into the target.
    pub(crate) fn resolve(&mut self, work: &mut Work<'_>, kind: SampleKind, sums: &SamplePart) -> Result<(), Error> {
        let (device, target, window, samples) = (work.device, work.target, work.window, work.samples.end);
        self.reserve_sums(device, work.pixels(), kind, most_strata(batches(samples)))?;
        for batch in batches(samples) {
            let planes = 0..kind.sums(batch.left.div_ceil(STRATUM)) as u32;
            let words = planes.flat_map(|number| sums.window(Plane::Batch { before: batch.before, number }, window));
            self.sums.get().upload(bytemuck::cast_slice(&words.collect::<Vec<u32>>()))?;
            let mut recorder = work.timeline.recorder(device)?;
            self.record_gather(&mut recorder, (work.pixels(), kind), batch, target)?;
            work.timeline.submit(recorder, "stochastic/gather")?;
        }
        if kind.exact {
            self.exact.get().upload(bytemuck::cast_slice(&sums.window(Plane::Exact, window)))?;
        }
        target.set_depths(bytemuck::cast_slice(&sums.window(Plane::Depth, window)))?;
        let mut recorder = work.timeline.recorder(device)?;
        self.record_resolve(&mut recorder, (work.pixels(), kind), samples, target)?;
        self.deliver(recorder, work)
    }

    /// Begins a batch: the first one of a later part has no depths before it.
    fn begin_batch<'w>(&self, work: &mut Work<'w>, job: &SampleJob<'_>, batch: Batch) -> Result<Recorder<'w>, Error> {
        let mut recorder = work.timeline.recorder(work.device)?;
        if batch.before == job.first && job.first > 0 {
            let depths = work.target.depths().first(job.pixels());
            recorder.fill("image/clear", depths, f32::INFINITY.to_bits())?;
        }
        Ok(recorder)
    }

    /// Adds a batch to those before, or keeps it.
    fn end_batch<'a, 'w: 'a>(
        &'a self,
        mut recorder: Recorder<'a>,
        work: &mut Work<'w>,
        (job, batch): (&SampleJob<'_>, Batch),
        name: &str,
    ) -> Result<(), Error> {
        if work.sums.is_none() {
            self.record_gather(&mut recorder, (job.pixels(), job.kind()), batch, work.target)?;
            work.timeline.go_on(recorder, name)?;
        } else {
            work.timeline.submit(recorder, name)?;
            for number in 0..job.kind().sums(batch.left.div_ceil(STRATUM)) {
                let sums = self.sums.get().read(number * job.pixels(), job.pixels())?;
                let plane = Plane::Batch { before: batch.before, number: number as u32 };
                work.keep(plane, bytemuck::cast_slice(&sums));
            }
        }
        work.progress.set_message(format!("rendering, {} samples", batch.before + batch.left));
        Ok(())
    }

    /// Resolves a window whose batches are through, or keeps what they have in common.
    fn end(&self, work: &mut Work<'_>, job: &SampleJob<'_>) -> Result<(), Error> {
        let (target, pixels) = (work.target, job.pixels());
        if work.sums.is_none() {
            let mut recorder = work.timeline.recorder(work.device)?;
            self.record_resolve(&mut recorder, (pixels, job.kind()), job.settings.samples, target)?;
            return self.deliver(recorder, work);
        }
        work.keep(Plane::Depth, bytemuck::cast_slice(&target.read_depths(pixels)?));
        if job.finds_exact() {
            work.keep(Plane::Exact, bytemuck::cast_slice(&self.exact.get().read(0, pixels)?));
        }
        Ok(())
    }

    /// Ends a window that shows nothing. Sums that are kept begin as those of nothing.
    fn end_empty(&self, work: &mut Work<'_>, job: &SampleJob<'_>) -> Result<(), Error> {
        if work.sums.is_some() {
            return Ok(());
        }
        let mut recorder = work.timeline.recorder(work.device)?;
        work.target.pixels().record_nothing(&mut recorder, job.bin.raster.window)?;
        // As where something else shows in the window: one stratum tells no spread.
        let spread = if job.settings.samples <= STRATUM { f32::INFINITY } else { 0.0 };
        recorder.fill("image/clear", self.spread.get().all(), spread.to_bits())?;
        self.deliver(recorder, work)
    }

    /// Submits the end of a window that is in the target, and copies it to the host.
    fn deliver<'a, 'w: 'a>(&'a self, mut recorder: Recorder<'a>, work: &mut Work<'w>) -> Result<(), Error> {
        self.told.record(&mut recorder, self.spread.get());
        work.target.record_read_back(&mut recorder, work.pixels())?;
        work.timeline.submit(recorder, "stochastic/resolve")
    }

    /// Returns the standard error of every pixel of the window, in its order, from the last window rendered with it.
    pub fn read_stderr(&self, window: Window) -> Result<Vec<[f32; 3]>, Error> {
        let errors = self.told.read(self.spread.get(), bands::pixels(window))?;
        Ok(errors.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
    }

    fn reserve(&mut self, device: &Device, job: &SampleJob<'_>) -> Result<(), Error> {
        self.attachments.release();
        let pixels = job.pixels();
        let strata = most_strata(job.batches());
        self.keys.reserve(device, pixels * u64::from(strata))?;
        self.indices.reserve(device, pixels * u64::from(strata))?;
        self.reserve_sums(device, pixels, job.kind(), strata)
    }

    /// Reserves the sums that both ways of going through the splats fill.
    fn reserve_sums(&mut self, device: &Device, pixels: u64, kind: SampleKind, strata: u32) -> Result<(), Error> {
        let SampleKind { exact, spread } = kind;
        self.sums.reserve(device, pixels * kind.sums(strata))?;
        self.exact.reserve(device, if exact { pixels } else { 1 })?;
        self.spread.reserve(device, if spread { 2 * pixels } else { 1 })?;
        self.told.reserve(device, if spread { pixels } else { 0 })
    }

    fn record_gather<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        (pixels, kind): (u64, SampleKind),
        batch: Batch,
        target: &'a Target,
    ) -> Result<(), Error> {
        let pass = Gather { sums: self.sums.get().all(), image: target.image(), spread: self.spread.get().all() };
        let push = GatherPush { pixels: pixels as u32, before: batch.before, left: batch.left };
        let variant = gather_variant(kind, batch.strata);
        Ok(recorder.run(&pass, push, &Run::new(Dispatch::Invocations(pixels)).variant(variant))?)
    }

    fn record_resolve<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        (pixels, kind): (u64, SampleKind),
        samples: u32,
        target: &'a Target,
    ) -> Result<(), Error> {
        let pass = Resolve { exact: self.exact.get().all(), image: target.image(), spread: self.spread.get().all() };
        let push = ResolvePush { pixels: pixels as u32, samples };
        let variant = resolve_variant(kind);
        Ok(recorder.run(&pass, push, &Run::new(Dispatch::Invocations(pixels)).variant(variant))?)
    }
}

/// Strata that a batch may have.
const STRATA: [u32; 2] = [STRATA_OF_A_CALL, MOST_STRATA];

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let kinds = || SampleKind::all().into_iter();
    let gather = kinds().flat_map(|kind| STRATA.map(|strata| gather_variant(kind, strata)));
    let mut all = vec![Shader::new::<Gather>(gather), Shader::new::<Resolve>(kinds().map(resolve_variant))];
    all.extend(engine::shaders());
    all.extend(hardware::shaders());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_take_as_many_samples_as_the_error_wants() {
        let errors = [[0.1, 0.1, 0.1], [0.1, 0.1, 0.1]];
        assert_eq!(more_samples(16, 4096, &errors, 0.1001), None);
        // A third of the error: nine times the samples, 5% more, in whole batches of 16.
        assert_eq!(more_samples(16, 4096, &errors, 0.1 / 3.0), Some(160));
        assert_eq!(more_samples(16, 4096, &errors, 0.0999), Some(32), "at least a batch more");
        assert_eq!(more_samples(16, 100, &errors, 0.001), Some(100));
        assert_eq!(more_samples(16, 100, &errors, 0.0), Some(100));
        assert_eq!(more_samples(100, 100, &errors, 0.001), None);
        assert_eq!(more_samples(4, 4, &[[f32::INFINITY; 3]], 0.1), None);
        // Root mean square: one pixel of two has all of the error.
        assert_eq!(more_samples(16, 4096, &[[0.1, 0.0, 0.0], [0.0; 3]], 0.0409), None);
        assert_eq!(more_samples(16, 4096, &[[0.1, 0.0, 0.0], [0.0; 3]], 0.0408), Some(32));
    }

    #[test]
    fn least_bytes_by_hand() {
        let facts = Facts { visible: 5, tile_entries: 20, ..Facts::default() };
        let of = |name, samples, exact, spread| {
            least_bytes(name, samples, SampleKind { exact, spread }, &facts, 10, 20).expect("a pass of stochastic")
        };
        // Of each pixel two strata; of each splat 16 bytes, color and record.
        assert_eq!(of("stochastic/visibility", 8, false, false), 20 * 4 + 5 * 40 + 10 * 64);
        assert_eq!(of("stochastic/accumulate", 8, true, false), 920 + 10 * (16 + 4 + 4));
        // With the spread, the sums of the two strata, too.
        assert_eq!(of("stochastic/accumulate", 8, false, true), 920 + 10 * (48 + 4));
        assert_eq!(of("stochastic/gather", 8, true, false), 10 * (16 + 16));
        assert_eq!(of("stochastic/gather", 8, true, true), 10 * (48 + 16 + 32));
        assert_eq!(of("stochastic/resolve", 8, true, true), 10 * (32 + 4 + 32));
        assert_eq!(least_bytes("sorted/blend", 8, SampleKind { exact: true, spread: false }, &facts, 10, 20), None);
    }

    #[test]
    fn batches_take_every_sample_once() {
        for samples in [1, 3, 4, 5, 8, 9, 12, 16, 17, 64, 1023, 4096] {
            let mut next = 0;
            for batch in batches(samples) {
                assert_eq!(batch.before, next);
                assert!(batch.left <= batch.strata * STRATUM && batch.strata <= MOST_STRATA, "{batch:?}");
                assert_eq!(batch.before % (STRATUM * STRATA_OF_A_CALL), 0, "random numbers begin with whole calls");
                next += batch.left;
            }
            assert_eq!(next, samples);
        }
        let small: Vec<u32> = [1, 4, 8, 9].iter().flat_map(|n| batches(*n).map(|b| b.strata)).collect();
        assert_eq!(small, [2, 2, 2, 4]);
    }
}
