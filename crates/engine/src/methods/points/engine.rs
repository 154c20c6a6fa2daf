//! The engine of `points`.

use super::NEAREST;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Engine, Work, windows_of};
use crate::methods::explain::{Absent, Explain, FramePlan, PassGroup};
use crate::methods::{Buffers, Error, Frame, Outcome, opaque};
use crate::passes::bands::{Budget, Window};
use crate::passes::project::{DeviceCloud, PointExtent};
use crate::passes::raster::Walker;

/// 1-pixel points.
pub(crate) struct PointsEngine;

impl Engine for PointsEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, opaque::PIXEL_BYTES))
    }

    fn extent(&self, _frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::pixels(0.0)
    }

    fn projects(&self) -> bool {
        false
    }

    /// A survey projects points to splats of one pixel, which yields the number of visible ones without drawing any.
    fn render(
        &self,
        cloud: &mut DeviceCloud,
        Buffers { tiles, resources }: &mut Buffers,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let how = work.frame.projecting_points(cloud);
        let stats = if work.survey {
            let stats = work.project(cloud, &how)?;
            if work.reserve_tiles(tiles, &stats, true)?.is_none() {
                return Ok(Outcome::Overflow);
            }
            stats.to_vec()
        } else {
            cloud.set_view(&work.frame.camera, work.frame.size, work.window, &how);
            resources.own.of::<opaque::Opaque>(work.device)?.render_points(work, cloud, &how)?
        };
        work.finish();
        work.facts.note(&stats, Walker::Compute);
        Ok(Outcome::Done)
    }
}

impl Explain for PointsEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let (facts, pixels) = (pass.facts, pass.pixels());
        match pass.name {
            "project/clear" => Some(pixels * 8),
            "points/nearest" => Some(facts.points * 32 * facts.windows.max(1) + facts.visible * 8),
            "points/resolve" => Some(pixels * (8 + 16 + 20)),
            _ => None,
        }
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.cleared();
        plan.not_projected();
        plan.nearest(NEAREST, plan.facts.points > 0, plan.why);
        plan.found();
        let shading = plan.shading();
        plan.add("points/resolve", true, format!("turns the index of the nearest point into a color; {shading}"));
    }
}

/// Returns the passes of 1-pixel points.
pub(crate) fn pass_group() -> PassGroup {
    let names = NEAREST.into_iter().chain(["points/resolve"]).collect();
    PassGroup { names, absent: Absent::Method("no 1-pixel points") }
}
