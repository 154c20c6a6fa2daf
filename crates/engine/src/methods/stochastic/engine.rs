//! The engine of `stochastic`, by compute shaders and by the rasterizer.

use std::ops::Range;

use super::hardware::{self, HeldDepths};
use super::{SampleJob, SampleKind, Sampler, batches, least_bytes, pixel_bytes, window_pixels};
use crate::gpu::{Device, DeviceInfo};
use crate::methods::abuffer::counted_beside;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Channels, Counts, Engine, Work};
use crate::methods::explain::{Absent, EACH_PIXEL, Explain, FramePlan, NOTHING, ORDER, PassGroup};
use crate::methods::parts::{Plane, Sums};
use crate::methods::tiled::{self, Stage};
use crate::methods::walker::sampling_walker;
use crate::methods::{Buffers, Error, Frame, Outcome, Resources, SamplePart, abuffer};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Bins, Order};
use crate::passes::project::DeviceCloud;
use crate::passes::raster::Walker;
use crate::random::STRATUM;
use crate::scene::{DiscShape, Discs, Stochastic};

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
        let job = SampleJob { bin, settings, first, seed: work.frame.seed, spread: work.frame.wants_spread() };
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
