//! The engine of opaque splats where only the nearest one counts.

use super::{Opaque, PIXEL_BYTES};
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Engine, Work, windows_of};
use crate::methods::explain::{Absent, COUNTERS, Explain, FramePlan, NOTHING, PassGroup, TILES};
use crate::methods::walker::walker;
use crate::methods::{Buffers, Error, Frame, Outcome};
use crate::passes::bands::{Budget, Window};
use crate::passes::project::{CloudPart, DeviceCloud, Footprint, PointExtent};
use crate::passes::raster::{Raster, Walker};
use crate::scene::{Relief, ScreenSplats};

/// Opaque splats where only the nearest one counts.
pub(crate) struct NearestEngine {
    /// Size, clamp and rasterizer.
    pub splats: ScreenSplats,
    /// Shape of the pixels that a splat covers.
    pub footprint: Footprint,
    /// The displacement of its fragments toward the viewer.
    pub relief: Relief,
}

impl Engine for NearestEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, PIXEL_BYTES))
    }

    fn extent(&self, frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::squares(frame.factors.radius * self.splats.size)
    }

    fn render(
        &self,
        cloud: &mut DeviceCloud,
        Buffers { tiles, resources }: &mut Buffers,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let window = work.window;
        let how = work.frame.projecting(cloud, self.footprint, self.splats, CloudPart::All);
        let stats = work.project(cloud, &how)?;
        let walker = walker(work.device, self.splats.raster, window)?;
        if work.reserve_tiles(tiles, &stats, walker == Walker::Compute)?.is_none() {
            return Ok(Outcome::Overflow);
        }
        if !work.survey {
            let raster = Raster { cloud, stats: &stats, tiles, walker, footprint: how.footprint, window };
            resources.own.of::<Opaque>(work.device)?.render(work, &raster, self.relief)?;
            work.finish();
        }
        work.note(&stats, walker);
        Ok(Outcome::Done)
    }
}

impl Explain for NearestEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        match pass.name {
            "project/clear" => Some(pass.pixels() * 8),
            "opaque/resolve" => Some(pass.pixels() * (8 + 16 + 20)),
            _ => pass.projected(false),
        }
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.projected();
        let tiled = plan.tiles(plan.facts.large);
        plan.scan(tiled, "tiles of large splats");
        let (seen, why) = (plan.seen(), plan.why);
        plan.nearest(NEAREST, seen, if seen { why } else { NOTHING });
        plan.add("opaque/resolve", true, "turns the index of the nearest splat into a color");
    }
}

/// The passes that find the nearest splats, by 64-bit atomics and without.
const NEAREST: [&str; 3] = ["opaque/nearest", "opaque/nearest-depth", "opaque/nearest-id"];

/// Returns counters that most methods clear, and the results of the projection.
pub(crate) fn counter_group() -> PassGroup {
    PassGroup::new(&COUNTERS, Absent::Always("methods of ensembles use their own counters"))
}

/// Returns the passes that list the large splats of tiles.
pub(crate) fn tile_group() -> PassGroup {
    PassGroup::new(&TILES, Absent::Always("no pass visits pixels splat by splat"))
}

/// Returns the passes of opaque splats where only the nearest one counts.
pub(crate) fn pass_group() -> PassGroup {
    let names = NEAREST.into_iter().chain(["opaque/resolve"]).collect();
    PassGroup { names, absent: Absent::Method("no opaque splats") }
}
