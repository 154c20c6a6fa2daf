//! The engine of `spbr` and `spbr-simplified`.

use super::share::Share;
use super::{
    Ensembles, Form, Scale, SpbrJob, adjusted, is_listed, least_bytes, shares, slots_of, small_square, stream,
};
use super::{thin, window_pixels};
use crate::methods::parts::Sums;
use crate::methods::prelude::*;

/// Points dealt to ensembles, each an opaque image.
pub(crate) struct EnsembleEngine {
    /// L.
    pub ensembles: u32,
}

impl EnsembleEngine {
    /// The way the nearest points of an ensemble are found.
    fn form(work: &Work<'_>, cloud: &DeviceCloud, how: &Projecting, streamed: bool) -> Form {
        match Form::choose(work.device, cloud, how, work.switches.wide_atomics) {
            // The color of the point that is replaced may not be there.
            Form::Single if !work.switches.single_pass || streamed => Form::Wide,
            form => form,
        }
    }
}

impl Engine for EnsembleEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(bands::windows(frame.size, window_pixels(budget, frame.wants_spread())))
    }

    /// Ensembles are random.
    fn takes_fours(&self) -> bool {
        false
    }

    /// No splats, and no points either where they go through the device bit by bit.
    fn place(&self, device: &Device, cloud: &mut DeviceCloud, frame: &Frame, survey: bool) -> Result<(), Error> {
        if survey {
            return Ok(());
        }
        match self.streamed(device, cloud, frame) {
            Some(_) => cloud.release(device)?,
            None => cloud.make_resident(device)?,
        }
        Ok(())
    }

    fn streamed(&self, device: &Device, cloud: &DeviceCloud, frame: &Frame) -> Option<u64> {
        stream::window_points(device, cloud, frame.memory_budget)
    }

    fn samples(&self, frame: &Frame) -> Option<u32> {
        Some(frame.ensembles.map_or(self.ensembles, |few| few.max(1).min(self.ensembles)))
    }

    fn sums(&self) -> Option<Sums> {
        Some(Sums::Ensembles)
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let (device, frame, window) = (work.device, work.frame, work.window);
        // Each image of a mean has ensembles of its own, all of them dealt together.
        let before = frame.number() * self.ensembles;
        let drawn = before + work.samples.start..before + work.samples.end;
        let ensembles = frame.samples * self.ensembles;
        let shares: Vec<Share> = shares(cloud, frame)?.into_iter().map(|share| share.times(frame.samples)).collect();
        let how = frame.projecting_points(cloud);
        let streamed = self.streamed(device, cloud, frame);
        let form = Self::form(work, cloud, &how, streamed.is_some());
        let facts = &mut *work.facts;
        (facts.ensembles, facts.form) = (drawn.end - drawn.start, Some(form));
        let slots = |share: &Share, drawn| slots_of(share, ensembles, drawn);
        facts.slots = shares.iter().map(|s| slots(s, drawn.end) - slots(s, drawn.start)).sum();
        facts.thin = thin(&shares);
        facts.adjusted = adjusted(cloud, frame);
        facts.listed = is_listed(&shares, small_square(device.info().prefers.spread_squares));
        facts.streamed = streamed;
        if !work.survey {
            cloud.reach(shares.iter().map(|s| slots(s, drawn.end)), work.progress)?;
            cloud.set_view(&frame.camera, frame.size, window, &how);
        }
        let job = SpbrJob {
            cloud,
            window,
            how: &how,
            shares: &shares,
            ensembles: [self.ensembles, ensembles],
            method: frame.method,
            drawn,
            seed: frame.seed,
            spread: frame.wants_spread(),
            perspective: matches!(frame.camera.projection, Projection::Perspective { .. }),
            form,
            streamed,
            most_epoch_bits: work.switches.epoch_bits,
            concurrent: device.info().prefers.concurrent_runs,
            shares_squares: device.info().prefers.spread_squares,
            budget: work.budget,
        };
        work.facts.renewed |= job.is_renewed();
        if !work.survey {
            let met = buffers.resources.own.of::<Ensembles>(device)?.render(work, &job)?;
            work.facts.visible += met.visible;
            work.facts.uploaded_bytes += met.uploaded;
            work.finish();
        }
        work.facts.note(&[], Walker::Compute);
        Ok(Outcome::Done)
    }

    fn resolve(
        &self,
        cloud: &DeviceCloud,
        buffers: &mut Buffers,
        work: &mut Work<'_>,
        sums: &SamplePart,
    ) -> Result<(), Error> {
        work.facts.ensembles = work.samples.end;
        work.facts.adjusted = adjusted(cloud, work.frame);
        let scale = Scale::new(self.ensembles, cloud.max_color(&work.frame.projecting_points(cloud)));
        buffers.resources.own.of::<Ensembles>(work.device)?.resolve(work, scale, sums)?;
        work.finish();
        work.facts.note(&[], Walker::Compute);
        Ok(())
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let ensembles = buffers.resources.own.there::<Ensembles>().filter(|_| frame.wants_spread());
        let stderr = ensembles.map(|ensembles| ensembles.read_stderr(window)).transpose()?;
        Ok(Counts { stderr, ..Counts::default() })
    }
}

impl Explain for EnsembleEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        least_bytes(pass.name, pass.facts, pass.frame.wants_spread(), pass.pixels())
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        let facts = plan.facts;
        let any = facts.slots > 0;
        plan.add("spbr/clear", true, "the planes of ensembles and the sums start empty");
        let whole = || "all points fit in device memory and in the budget".to_owned();
        let part = |n| {
            format!(
                "{} points don't fit in the budget or in one allocation, so at most {n} are uploaded at a time",
                facts.points
            )
        };
        plan.add("spbr/upload", any && facts.streamed.is_some(), facts.streamed.map_or_else(whole, part));
        explain_stages(plan, any);
        let small = small_square(plan.device.info().prefers.spread_squares);
        let wide = format!("points may cover more than {small} pixels; a whole workgroup fills each of these");
        let narrow = format!("no point can be wider than {} pixels", small.isqrt() - 1);
        plan.add("spbr/large", any && facts.listed, if facts.listed { wide } else { narrow });
        let epochs = "the index and the epoch of a point share 32 bits";
        let renewed = if facts.renewed { "there are more ensembles than epochs" } else { "there are enough epochs" };
        plan.add("spbr/renew", any && facts.renewed, format!("{epochs}: {renewed}"));
        plan.add(
            "spbr/resolve",
            true,
            format!("turns the sums of {} ensembles into color and opacity A", facts.ensembles),
        );
        plan.add("spbr/summary", true, "reports to the host how many points were drawn");
        plan.rest(&PASSES, &format!("{} does not need this pass", plan.frame.method.name()));
        plan.not_projected();
    }
}

/// The stages that draw ensembles; the form decides which of them run.
fn explain_stages(plan: &mut FramePlan<'_>, any: bool) {
    let (facts, why) = (plan.facts, plan.why);
    let dealt = format!("{} points dealt to {} ensembles", facts.slots, facts.ensembles);
    let has = if plan.device.info().int64_atomics { "the device has" } else { "the device has no" };
    let (single, wide, narrow) = (&[Form::Single][..], &[Form::Wide][..], &[Form::Narrow][..]);
    for (name, forms, how) in [
        (
            "spbr/draw",
            single,
            "the device has 64-bit atomics; colors need no shading, and the shader reaches all of them".to_owned(),
        ),
        (
            "spbr/nearest",
            wide,
            format!("{has} 64-bit atomics; colors are shaded, or the shader does not reach all of them"),
        ),
        ("spbr/nearest-depth", narrow, format!("{has} 64-bit atomics")),
        ("spbr/nearest-id", narrow, format!("{has} 64-bit atomics")),
        (
            "spbr/sum",
            &[Form::Wide, Form::Narrow][..],
            "sums the colors of the nearest points of each ensemble".to_owned(),
        ),
    ] {
        let on = any && facts.form.is_some_and(|form| forms.contains(&form));
        let reason = if on { format!("{why}; {dealt}; {how}") } else { "other passes draw the ensembles".to_owned() };
        plan.add(name, on, reason);
    }
}

/// The passes of stochastic point-based rendering.
const PASSES: [&str; 11] = [
    "spbr/clear",
    "spbr/upload",
    "spbr/draw",
    "spbr/nearest",
    "spbr/nearest-depth",
    "spbr/nearest-id",
    "spbr/renew",
    "spbr/large",
    "spbr/sum",
    "spbr/resolve",
    "spbr/summary",
];

/// Returns the passes of stochastic point-based rendering.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&PASSES, Absent::Method("no ensembles"))
}
