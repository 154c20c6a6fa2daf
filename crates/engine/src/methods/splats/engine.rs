//! The engine of `hqs` and `splats`, and the drawing in three passes that others take for their solid points.

use super::{PASSES, PIXEL_BYTES, SplatsJob, Splatter, least_bytes, survey};
use crate::gpu::DeviceInfo;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Engine, Work, windows_of};
use crate::methods::explain::{Absent, EACH_PIXEL, Explain, FramePlan, NOTHING, PassGroup};
use crate::methods::{Buffers, Error, Facts, Frame, Layer, Outcome, Resources, tiled};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Order};
use crate::passes::project::{CloudPart, DeviceCloud, Footprint, PointExtent, Projecting, Stats};
use crate::passes::raster::{Raster, Walker};
use crate::scene::{BlendedSplats, ScreenSplats};

/// Opaque splats that are blended where they lie close together.
pub(crate) struct SplatsEngine {
    /// Size, clamp and depth of blending.
    pub settings: BlendedSplats,
    /// Shape of the pixels that a splat covers.
    pub footprint: Footprint,
}

impl Engine for SplatsEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, bin::PIXEL_BYTES + PIXEL_BYTES))
    }

    fn extent(&self, frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::squares(frame.factors.radius * self.settings.splats.size)
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let BlendedSplats { splats, blend_depth, .. } = self.settings;
        let how = work.frame.projecting(cloud, self.footprint, splats, CloudPart::All);
        let stats = work.project(cloud, &how)?;
        let footprint = how.footprint;
        let drawing = Drawing { stats: &stats, footprint, blend_depth, used_bytes: PIXEL_BYTES, onto: Onto::Target };
        if draw(cloud, buffers, work, &drawing)? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        work.note(&stats, Walker::Compute);
        work.read_back()?;
        Ok(Outcome::Done)
    }
}

impl Explain for SplatsEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = self.footprint == Footprint::Oriented;
        let binned = Facts { bands: pass.facts.splatted, ..pass.facts.clone() };
        let binned = PassRuns { facts: &binned, ..*pass };
        let own = || least_bytes(pass.name, pass.facts, pass.is_tilted(tilted), pass.pixels());
        pass.projected(tilted).or_else(|| tiled::binned_bytes(&binned)).or_else(own)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.projected();
        explain_windows(plan, |plan, counters| plan.scan(counters, "counters of digits and tiles"));
    }
}

/// Splats that are drawn in three passes.
pub(crate) struct Drawing<'a> {
    /// The results of their projection, by chunk.
    pub stats: &'a [Stats],
    /// Shape of the pixels that a splat covers.
    pub footprint: Footprint,
    /// Fragments up to this many radii behind the nearest are blended with it.
    pub blend_depth: f32,
    /// Bytes per pixel that are in use meanwhile.
    pub used_bytes: u64,
    /// The destination of colors and depths.
    pub onto: Onto,
}

/// The destination of three-pass splats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Onto {
    /// The target.
    Target,
    /// The target; only solid fragments, and those behind the layer.
    TargetBehindLayer,
    /// The layer.
    Layer,
}

/// Draws a window's projected splats, or decides only how they are binned; nothing is read back.
pub(crate) fn draw(
    cloud: &DeviceCloud,
    Buffers { tiles, resources }: &mut Buffers,
    work: &mut Work<'_>,
    drawing: &Drawing<'_>,
) -> Result<Outcome, Error> {
    let Drawing { stats, footprint, blend_depth, used_bytes, onto } = *drawing;
    let window = work.window;
    let raster = Raster { cloud, stats, tiles, walker: Walker::Compute, footprint, window };
    let counted_bytes = bands::pixels(window) * used_bytes;
    let depth_range = work.frame.depth_range().map(|depth| depth - cloud.depth_origin());
    let bin = bin::Job { raster, order: Order::Index, depth_range, budget: work.budget, counted_bytes };
    if work.survey {
        return survey(work.device, &bin, work.facts);
    }
    let Resources { bins, own, layer, .. } = resources;
    let (into, behind) = match onto {
        Onto::Target => (work.target.pixels(), None),
        Onto::TargetBehindLayer => (work.target.pixels(), Some(layer.depths())),
        Onto::Layer => (layer.pixels(), None),
    };
    own.of::<Splatter>(work.device)?.render(bins, work, &SplatsJob { bin, blend_depth, layer: behind }, into)
}

/// Returns the conversion of a part of a cloud's points to three-pass splats: like those of `splats`, with its
/// defaults.
pub(crate) fn solid_projecting(frame: &Frame, cloud: &DeviceCloud, part: CloudPart) -> Projecting {
    frame.projecting(cloud, Footprint::Oriented, ScreenSplats::default(), part)
}

/// Draws projected splats of solid points as `splats` does, with its defaults.
pub(crate) fn draw_solid(
    cloud: &DeviceCloud,
    buffers: &mut Buffers,
    work: &mut Work<'_>,
    (stats, footprint, onto): (&[Stats], Footprint, Onto),
) -> Result<Outcome, Error> {
    let (blend_depth, used_bytes) = (BlendedSplats::default().blend_depth, SOLID_BYTES);
    draw(cloud, buffers, work, &Drawing { stats, footprint, blend_depth, used_bytes, onto })
}

/// Device bytes per pixel of a window of solid points with a layer.
pub(crate) const SOLID_BYTES: u64 = PIXEL_BYTES + Layer::PIXEL_BYTES;

/// Returns the passes of splats that are blended in three passes.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&PASSES, Absent::Method("splats are not blended in three passes"))
}

/// The plan of windows of splats, and perhaps a layer over them; `scan` explains the prefix sums of so many counters.
pub(crate) fn explain_windows(plan: &mut FramePlan<'_>, scan: fn(&mut FramePlan<'_>, u64)) {
    let (facts, why) = (plan.facts, plan.why);
    let counters = explain_solids(plan, why);
    scan(plan, counters);
    let layered = facts.layered > 0;
    let layer = format!("soft points lie in front of others in {} window(s)", facts.layered);
    plan.add("one-layer/compose", layered, if layered { &layer } else { "no soft point touches the image" });
    // A window with a layer is drawn into twice.
    let empty = facts.windows.saturating_sub(facts.splatted - facts.layered);
    plan.add("image/clear", empty > 0, format!("{empty} window(s) show nothing"));
}

/// Returns the passes of opaque splats that are blended, tiles included; returns how many counters are summed.
pub(crate) fn explain_solids(plan: &mut FramePlan<'_>, why: &str) -> u64 {
    let seen = plan.facts.splatted > 0;
    let counters = if seen { plan.order(Order::Index, EACH_PIXEL) } else { 0 };
    let reasons = [
        format!("{why}; finds the nearest splats, which hide deeper ones"),
        "sums the splats that are not hidden, by weight".to_owned(),
        "turns sums into colors".to_owned(),
    ];
    for (name, reason) in PASSES.into_iter().zip(reasons) {
        plan.add(name, seen, if seen { reason } else { NOTHING.to_owned() });
    }
    counters
}
