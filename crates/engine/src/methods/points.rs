//! `points`: 1-pixel opaque points. A point is one pixel, so that no splats are made: each goes straight to its pixel,
//! and only those that win there are shaded.
//!
//! The equations are those of the other opaque methods ([`super::opaque`]), the projection is `project/splats`'s own.

use super::opaque::{self, NearestSplat, Opaque};
use crate::methods::prelude::*;
use crate::passes::project::{POINTS_RUN, Places, PlacesGroup, PointsPush, Shaded, View, points_dispatch};

pass! {
    /// Finds the pixel and depth of each point, and takes the 64-bit atomic minimum of depth key and point index there.
    /// With `image-space` and `peel-layers` it leaves out points that face away (`cull`), and behind the first layer
    /// those before the limit of their pixel. The pixel is found in float32 and, within rounding of a border, again in
    /// two-float arithmetic; the depth always in the latter.
    pub Nearest(PointsPush) = "points/nearest" with "nearest_wide" {
        places: Shared<PlacesGroup>,
        normals: Read<[f32; 4]>,
        limits: Read<u32>,
        nearest: ReadWrite<u64>,
    }

    /// Finds the depth of `points/nearest` by a 32-bit minimum, where the device has no 64-bit atomics.
    pub NearestDepth(PointsPush) = "points/nearest-depth" in "points/nearest" with "nearest_depth",
    /// Finds the smallest index at the depth of `points/nearest-depth`.
    pub NearestId(PointsPush) = "points/nearest-id" in "points/nearest" with "nearest_id" {
        places: Shared<PlacesGroup>,
        normals: Read<[f32; 4]>,
        limits: Read<u32>,
        nearest: ReadWrite<NearestSplat>,
    }

    /// Turns the index of the nearest point of each pixel into color, shaded only here, and depth.
    pub Resolve(CountPush) = "points/resolve" {
        camera: Uniform<View>,
        points_hi: Parts<[f32; 4]>,
        points_lo: Parts<[f32; 4]>,
        point_colors: Parts<[f32; 4]>,
        normals: Parts<[f32; 4]>,
        nearest: Read<[u32; 2]>,
        into: Shared<PixelsGroup>,
    }
}

/// The passes that find the nearest points, by 64-bit atomics and without.
pub(crate) const NEAREST: [&str; 3] = ["points/nearest", "points/nearest-depth", "points/nearest-id"];

/// The variant of the passes that find the nearest points: `cull`: without those that face away; `limited`: without
/// those nearer than their pixel's limit.
fn nearest_variant(cull: bool, limited: bool) -> Variant {
    Variant::plain().with("RUN", POINTS_RUN as u32).with("CULL", u32::from(cull)).with("LIMITED", u32::from(limited))
}

/// Points that are searched for the nearest ones, and how the search is dispatched.
#[derive(Clone, Copy, Default)]
pub struct Choice<'a> {
    /// Without those that face away from the viewer, of clouds with normals.
    pub cull: bool,
    /// Without those nearer than the depth key of their pixel.
    pub limits: Option<Slice<'a, u32>>,
    /// Four words for each chunk, of indirect dispatches.
    pub dispatches: Option<Slice<'a, u32>>,
}

impl Opaque {
    /// Renders the points of a cloud whose view is set into the target; what was found, chunk by chunk.
    pub(crate) fn render_points(
        &mut self,
        work: &mut Work<'_>,
        cloud: &DeviceCloud,
        how: &Projecting,
    ) -> Result<Vec<Stats>, Error> {
        let (device, target, wide) = (work.device, work.target, work.switches.wide_atomics);
        let pixels = work.pixels();
        self.nearest.reserve(device, pixels)?;
        let mut recorder = work.timeline.recorder(device)?;
        let nearest = self.nearest.get().slice(0, pixels);
        recorder.fill("project/clear", nearest, u32::MAX)?;
        cloud.record_clear(&mut recorder)?;
        record_nearest(&mut recorder, cloud, nearest, wide, &Choice::default())?;
        cloud.record_stats(&mut recorder)?;
        let cut = Cut::new(device, cloud.len())?;
        let resolve = Resolve {
            camera: cloud.view(),
            points_hi: cut.slices(&cloud.points_hi),
            points_lo: cut.slices(&cloud.points_lo),
            point_colors: cut.slices(&cloud.point_colors),
            normals: cut.slices(&cloud.normals),
            nearest: nearest.cast(),
            into: target.pixels(),
        };
        let push = CountPush { count: pixels as u32 };
        let run = Run::new(Dispatch::Invocations(pixels));
        recorder.run(&resolve, push, &run.variant(how.shaded(cloud.has_normals()).cut(cut)))?;
        target.record_read_back(&mut recorder, pixels)?;
        work.timeline.submit(recorder, "points/nearest")?;
        Ok(cloud.stats())
    }
}

/// Records the passes that find the nearest points, as indices and depth keys; all ones at the start.
pub(super) fn record_nearest<'a>(
    recorder: &mut Recorder<'a>,
    cloud: &'a DeviceCloud,
    nearest: Slice<'a, NearestSplat>,
    wide: bool,
    choice: &Choice<'a>,
) -> Result<(), Error> {
    let cull = choice.cull && cloud.has_normals();
    let chunks = || cloud.chunks().enumerate();
    let run = |chunk: usize, (_, count): (u64, u64)| {
        let indirect = choice.dispatches.map(|all| Dispatch::Indirect(all.skip(4 * chunk as u64).first(3)));
        let dispatch = indirect.unwrap_or(points_dispatch(count));
        Run::new(dispatch).variant(nearest_variant(cull, choice.limits.is_some()))
    };
    let bound = |(first, count): (u64, u64)| {
        let normals = if cull { cloud.normals.slice(first, count) } else { cloud.normals.slice(0, 1) };
        // A buffer of the cloud stands in for none.
        let limits = choice.limits.unwrap_or_else(|| cloud.large.slice(0, 1));
        let places: Places<'a> = cloud.places(first, count);
        (places, normals, limits)
    };
    // All depths come before any index.
    macro_rules! record {
        ($pass:ident, $nearest:expr) => {
            for (chunk, range) in chunks() {
                let (places, normals, limits) = bound(range);
                let pass = $pass { places, normals, limits, nearest: $nearest };
                recorder.run(&pass, PointsPush::new(chunk, range), &run(chunk, range))?;
            }
        };
    }
    if wide {
        record!(Nearest, nearest.cast());
    } else {
        record!(NearestDepth, nearest);
        record!(NearestId, nearest);
    }
    Ok(())
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let variants = || <(bool, bool)>::all().into_iter().map(|(cull, limited)| nearest_variant(cull, limited));
    vec![
        Shader::new::<Nearest>(variants()),
        Shader::new::<NearestDepth>(variants()),
        Shader::new::<NearestId>(variants()),
        Shader::new::<Resolve>(Shaded::cut_variants()),
    ]
}

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
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let Buffers { tiles, resources } = buffers;
        let how = work.frame.projecting_points(cloud);
        let stats = if work.survey {
            let stats = work.project(cloud, &how)?;
            if work.reserve_tiles(tiles, &stats, true)?.is_none() {
                return Ok(Outcome::Overflow);
            }
            stats.to_vec()
        } else {
            cloud.set_view(&work.frame.camera, work.frame.size, work.window, &how);
            resources.own.of::<Opaque>(work.device)?.render_points(work, cloud, &how)?
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
