//! The engine of `stochastic`, by compute shaders and by the rasterizer.

use super::hardware::{self, HeldDepths};
use super::{
    Batch, STRATA, SampleJob, SampleKind, Sampler, batches, calls_of, least_bytes, pixel_bytes, window_pixels,
};
use crate::methods::abuffer::{self, counted_beside};
use crate::methods::parts::{Plane, Sums};
use crate::methods::prelude::*;
use crate::methods::tiled::{self, Stage};
use crate::methods::walker::sampling_walker;
use crate::random::{STRATA_OF_A_CALL, STRATUM};
use crate::scene::Stochastic;

/// Random samples of each pixel.
pub(crate) struct StochasticEngine {
    /// Discs, samples, correction.
    pub settings: Stochastic,
}

impl Stage for StochasticEngine {
    fn discs(&self) -> Discs {
        self.settings.discs
    }

    fn order(&self) -> Order {
        Order::Index
    }

    fn walker(&self, device: &Device, window: Window) -> Result<Walker, Error> {
        sampling_walker(device, self.settings.discs.raster, window)
    }

    fn used_bytes(&self, frame: &Frame) -> u64 {
        pixel_bytes(frame.wants_spread())
    }

    fn survey(&self, work: &mut Work<'_>, bin: &bin::Job<'_>) -> Result<Outcome, Error> {
        work.facts.samples = work.samples.end - work.samples.start;
        if bin.raster.walker == Walker::Hardware {
            work.facts.bands += u64::from(hardware::is_seen(&bin.raster));
            return Ok(Outcome::Done);
        }
        Ok(work.facts.note_survey(Bins::survey(work.device, bin)?))
    }

    fn draw(
        &self,
        Resources { bins, own, .. }: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        _max_color: f32,
    ) -> Result<Outcome, Error> {
        let Range { start: first, end: samples } = work.samples;
        work.facts.samples = samples - first;
        let settings = Stochastic { samples, ..self.settings };
        let calls = work.frame.number() * calls_of(self.settings.samples);
        let (seed, spread) = (work.frame.seed, work.frame.wants_spread());
        let job = SampleJob { bin, settings, first, seed, calls, spread };
        let sampler = own.of::<Sampler>(work.device)?;
        if bin.raster.walker == Walker::Hardware {
            sampler.draw(work, &job, HeldDepths::new(&work.frame.camera, bin.raster.footprint))?;
            return Ok(Outcome::Done);
        }
        sampler.render(bins, work, &job)
    }
}

impl Engine for StochasticEngine {
    fn needs_subgroups(&self, device: &DeviceInfo) -> bool {
        // The rasterizer takes the samples where it can.
        device.multisampled.is_none()
    }

    /// Each image has random numbers of its own.
    fn takes_fours(&self) -> bool {
        false
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        let (listed, spread) = (if frame.fragments { abuffer::PIXEL_BYTES } else { 0 }, frame.wants_spread());
        let bytes = listed + bin::PIXEL_BYTES + pixel_bytes(spread);
        Ok(bands::windows(frame.size, window_pixels(budget, bytes, spread)))
    }

    fn samples(&self, _frame: &Frame) -> Option<u32> {
        Some(self.settings.samples)
    }

    fn sums(&self) -> Option<Sums> {
        Some(if self.settings.alpha_correction { Sums::Corrected } else { Sums::Samples })
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_BESIDE
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let outcome = tiled::render(self, cloud, buffers, work)?;
        if outcome == Outcome::Done
            && work.sums.is_some()
            && let Some(lengths) = buffers.resources.lists.counts(work.frame, work.window)?.fragments
        {
            work.keep(Plane::Lengths, &lengths);
        }
        Ok(outcome)
    }

    fn resolve(
        &self,
        _cloud: &DeviceCloud,
        buffers: &mut Buffers,
        work: &mut Work<'_>,
        sums: &SamplePart,
    ) -> Result<(), Error> {
        work.facts.samples = work.samples.end;
        let kind = SampleKind { exact: self.settings.alpha_correction, spread: work.frame.wants_spread() };
        buffers.resources.own.of::<Sampler>(work.device)?.resolve(work, kind, sums)?;
        work.finish();
        work.facts.note(&[], Walker::Compute);
        Ok(())
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let sampler = buffers.resources.own.there::<Sampler>().filter(|_| frame.wants_spread());
        let stderr = sampler.map(|sampler| sampler.read_stderr(window)).transpose()?;
        Ok(Counts { stderr, ..buffers.resources.lists.counts(frame, window)? })
    }
}

impl Explain for StochasticEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let Stochastic { samples, alpha_correction: exact, discs } = self.settings;
        if !pass.name.starts_with("stochastic/") {
            return tiled::disc_bytes(pass, &discs);
        }
        let (facts, pixels) = (pass.facts, pass.pixels());
        let splat = pass.splat(discs.shape == DiscShape::Oriented);
        let kind = SampleKind { exact, spread: pass.frame.wants_spread() };
        let quads = facts.points * 8 + facts.visible / facts.windows.max(1) * (splat + 16);
        let strata = u64::from(samples.div_ceil(STRATUM));
        least_bytes(pass.name, samples, kind, facts, pixels, splat)
            .or_else(|| hardware::least_bytes(pass.name, pass.runs, strata, quads, pixels))
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.projected();
        if plan.facts.raster == "hardware" {
            explain_draws(plan, &self.settings);
        } else {
            explain_tiles(plan, &self.settings);
        }
        plan.emptied();
        let why = plan.why;
        if plan.facts.raster == "hardware" {
            plan.rest(&SAMPLES, "the rasterizer takes the samples (method.raster = \"hardware\")");
        }
        plan.rest(&ORDER, &format!("samples need no order of splats: {why}"));
        plan.rest(&tiled::stage_group().names, &format!("the method takes samples: {why}"));
        tiled::without_lists(plan, &format!("samples need no lists: {why}"));
    }
}

/// The passes of stochastic transparency, without those that it shares.
const SAMPLES: [&str; 4] =
    ["stochastic/visibility", "stochastic/accumulate", "stochastic/gather", "stochastic/resolve"];
/// The passes by which the rasterizer takes the samples.
const DRAWS: [&str; 4] = ["stochastic/draw-alpha", "stochastic/draw-held", "stochastic/draw-sums", "stochastic/fold"];

/// Returns the passes of stochastic transparency, without those that it shares.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&[SAMPLES, DRAWS].concat(), Absent::Discs("no samples"))
}

fn correction(settings: &Stochastic) -> &'static str {
    if settings.alpha_correction { "colors are corrected by the exact opacity A" } else { "alpha correction is off" }
}

/// Splats in tiles, and the passes over them for each few strata of samples.
fn explain_tiles(plan: &mut FramePlan<'_>, settings: &Stochastic) {
    let (why, alpha) = (plan.why, correction(settings));
    let counters = if plan.seen() { plan.order(Order::Index, EACH_PIXEL) } else { 0 };
    counted_beside(plan, counters);
    let (samples, runs) = (settings.samples, batches(settings.samples).count());
    let reasons = [
        format!("{why}; {samples} samples, taken in {runs} run(s) over the splats"),
        format!("sums what is visible in {samples} samples; {alpha}"),
        "adds the sums of each run to those of earlier runs".to_owned(),
        format!("turns sums into color and opacity A; {alpha}"),
    ];
    for (name, reason) in SAMPLES.into_iter().zip(reasons) {
        plan.add(name, plan.seen(), plan.if_seen(reason));
    }
}

/// The rasterizer's samples, stratum by stratum.
fn explain_draws(plan: &mut FramePlan<'_>, settings: &Stochastic) {
    let (why, alpha) = (plan.why, correction(settings));
    if plan.frame.fragments {
        counted_beside(plan, 0);
    }
    let (samples, strata) = (settings.samples, settings.samples.div_ceil(STRATUM));
    let corrected = settings.alpha_correction;
    for (name, on, reason) in [
        (DRAWS[0], corrected, alpha.to_owned()),
        (DRAWS[1], true, format!("{why}; {samples} samples, taken in {strata} draws")),
        (DRAWS[2], true, format!("sums what is visible in the samples, in {strata} draws")),
        (DRAWS[3], true, "copies attachments to sums".to_owned()),
        (SAMPLES[2], true, "adds the sums of each run to those of earlier runs".to_owned()),
        (SAMPLES[3], true, format!("turns sums into color and opacity A; {alpha}")),
    ] {
        let reason = if plan.seen() { reason } else { NOTHING.to_owned() };
        plan.add(name, plan.seen() && on, reason);
    }
}

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
fn tile_variant(shape: Variant, lanes: Lanes, strata: u32) -> Variant {
    bin::region_variant(shape, lanes)
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
        let tile = tile_variant(shape, binned.lanes(), batch.strata);
        binned.record_runs(recorder, &visibility, runs, push, &tile)?;
        // All strata have the same exact A: the first ones find it.
        let kind = SampleKind { exact: job.finds_exact() && batch.before == 0, ..job.kind() };
        binned.record_runs(recorder, &accumulate, runs, push, &kind.apply_to(tile))?;
        Ok(())
    }
}

fn push(job: &SampleJob<'_>, walk: TileWalk, Batch { before, left, .. }: Batch) -> StochasticPush {
    let [key_low, key_high] = job.key(before / STRATUM / STRATA_OF_A_CALL);
    let pixels = job.pixels() as u32;
    StochasticPush { walk, pixels, before, left, key_low, key_high }
}

/// Returns the passes with their variants.
pub(super) fn shaders() -> Vec<Shader> {
    let tiles = bin::tile_variants(compose::variants(), &STRATA, tile_variant);
    let kinds = || SampleKind::all().into_iter();
    let accumulate = tiles.iter().flat_map(|tile| kinds().map(move |kind| kind.apply_to(tile.clone())));
    vec![Shader::new::<Accumulate>(accumulate), Shader::new::<Visibility>(tiles.clone())]
}
