//! The engine of `peel`.

use super::{PeelJob, Peeler, pixel_bytes, slots};
use crate::methods::engine::Fragments;
use crate::methods::prelude::*;
use crate::methods::projecting;
use crate::scene::Peel;

/// Layer after layer of discs.
pub(crate) struct PeelEngine {
    /// Discs and layers.
    pub peel: Peel,
}

impl Engine for PeelEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, pixel_bytes(frame.fragments)))
    }

    fn channels(&self) -> Channels {
        Channels { fragments: Fragments::Within, layers: true }
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let Buffers { tiles, resources } = buffers;
        let (peel, window) = (self.peel, work.window);
        let how = projecting::discs(work.frame, cloud, &peel.discs);
        let stats = work.project(cloud, &how)?;
        let walker = walker(work.device, peel.discs.raster, window)?;
        if work.reserve_tiles(tiles, &stats, walker == Walker::Compute)?.is_none() {
            return Ok(Outcome::Overflow);
        }
        let raster = Raster { cloud, stats: &stats, tiles, walker, footprint: how.footprint, window };
        let (counted, switches) = (work.frame.fragments, work.switches);
        let (wide, slots) = (switches.wide_atomics, slots(work, peel.layers));
        let job = PeelJob { raster, peel, counted, wide, slots, limit: switches.max_layers };
        let peeler = resources.own.of::<Peeler>(work.device)?;
        if work.survey {
            peeler.survey(work, &job)?;
        } else {
            peeler.render(work, &job)?;
        }
        work.note(&stats, walker);
        Ok(Outcome::Done)
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let Some(peeler) = buffers.resources.own.there::<Peeler>().filter(|_| frame.fragments) else {
            return Ok(Counts::default());
        };
        let [lengths, layers] = peeler.read_counts(window)?;
        Ok(Counts { fragments: Some(lengths), layers: Some(layers), stderr: None })
    }
}

impl Explain for PeelEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = self.peel.discs.shape == DiscShape::Oriented;
        match pass.name {
            "peel/clear" => Some(pass.pixels() * pixel_bytes(pass.frame.fragments)),
            "peel/count" => Some(pass.walks(tilted) + pass.facts.fragments * 8),
            _ => pass.projected(tilted),
        }
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.projected();
        let (seen, why, layers) = (plan.seen(), plan.why, self.peel.layers);
        let tiled = plan.pairs(plan.facts.large);
        plan.scan(tiled, "tiles of each large splat");
        let counted = "list lengths are counted only for `pellucid profile` and --aov";
        plan.add("peel/clear", true, "nothing is peeled yet");
        plan.add("peel/count", seen && plan.frame.fragments, if seen { counted } else { NOTHING });
        plan.add("image/clear", true, "pixels without fragments stay empty");
        let until = if layers == 0 {
            "layers are peeled until none is left".to_owned()
        } else {
            format!("{layers} layers are peeled")
        };
        let reason = plan.if_seen(format!("{why}; {until}"));
        plan.nearest(NEAREST, seen, &reason);
        plan.add("peel/blend", true, "blends each layer behind those before it");
        plan.add("peel/next", true, "a walk that finds fewer layers than it could ends the peeling");
        plan.add("peel/summary", true, "after each batch of layers the host checks whether more are left");
    }
}

/// The passes that find the nearest fragments, by 64-bit atomics and without.
const NEAREST: [&str; 3] = ["peel/nearest", "peel/nearest-depth", "peel/nearest-id"];

/// Returns the passes of depth peeling, without those that it shares.
pub(crate) fn pass_group() -> PassGroup {
    let names = ["peel/count", "peel/clear"].into_iter().chain(NEAREST);
    let names = names.chain(["peel/blend", "peel/next", "peel/summary"]).collect();
    PassGroup { names, absent: Absent::Discs("no peeling") }
}
