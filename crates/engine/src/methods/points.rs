//! `points`: 1-pixel opaque points. A point is one pixel, so that no splats are made: each goes straight to its pixel,
//! and only those that win there are shaded.
//!
//! The equations are those of the other opaque methods ([`super::opaque`]), the projection is `project/splats`'s own.

use std::cell::Cell;

use super::opaque::{self, NearestSplat, Opaque};
use crate::methods::prelude::*;
use crate::methods::several::Several;
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

    /// Shades every point, once for all images of a frame with samples, where these have at least as many pixels as
    /// there are points, and the budget has room.
    pub Shade(CountPush) = "points/shade" {
        camera: Uniform<View>,
        points_hi: Parts<[f32; 4]>,
        points_lo: Parts<[f32; 4]>,
        point_colors: Parts<[f32; 4]>,
        normals: Parts<[f32; 4]>,
        shades: ReadWrite<[f32; 4]>,
    }

    /// Turns the index of the nearest point of each pixel into color, shaded here or by `points/shade`, and depth.
    pub Resolve(CountPush) = "points/resolve" {
        camera: Uniform<View>,
        points_hi: Parts<[f32; 4]>,
        points_lo: Parts<[f32; 4]>,
        point_colors: Parts<[f32; 4]>,
        normals: Parts<[f32; 4]>,
        nearest: Read<[u32; 2]>,
        shades: Read<[f32; 4]>,
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

/// The variant of `points/resolve`; `ready`: with the colors of all points.
fn resolve_variant(shaded: Variant, ready: bool) -> Variant {
    shaded.with("SHADED", u32::from(ready))
}

/// Images of a frame with samples whose nearest points are found at a time, at most: from the walk over the points on
/// each costs as much as it does alone.
const MOST_IMAGES: u64 = 8;

/// Bytes of the color of a point that was shaded.
const SHADE_BYTES: u64 = 16;

/// Elements of the nearest points of an image that others follow: each may be bound by itself.
fn stride(pixels: u64) -> u64 {
    pixels.next_multiple_of(64)
}

/// Returns the images from a turn on whose nearest points fit the budget, at least one; `before` are those found
/// last.
fn several_from(turn: u32, before: Option<Several>, cloud: &DeviceCloud, work: &Work<'_>) -> Several {
    let (samples, pixels) = (work.frame.samples, work.pixels());
    let each = opaque::PIXEL_BYTES * stride(pixels);
    let (left, shades) = (work.budget.left(0), SHADE_BYTES * cloud.len());
    // Beside the images' own colors they are as many at most, and neither may keep the other from its place.
    let fits = shades <= work.budget.binding && shades + each <= left;
    let shaded = before.map_or(fits && cloud.len() <= pixels * u64::from(samples), |before| before.shaded);
    let room = left.saturating_sub(if shaded { shades } else { 0 }).min(work.budget.binding) / each;
    let images = room.clamp(1, MOST_IMAGES).min(u64::from(samples - turn)) as u32;
    Several { first: turn, images, samples, stride: stride(pixels) as u32, shaded }
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
    /// Images whose nearest points are found at once.
    pub(crate) several: Option<Several>,
}

impl Opaque {
    /// Renders the points of a cloud whose view is set into the target; what was found, chunk by chunk: nothing for an
    /// image whose points were found with those of an earlier one.
    pub(crate) fn render_points(
        &mut self,
        work: &mut Work<'_>,
        cloud: &DeviceCloud,
        how: &Projecting,
    ) -> Result<Vec<Stats>, Error> {
        let (device, target) = (work.device, work.target);
        let pixels = work.pixels();
        let turn = work.frame.turn();
        let before = work.several.and_then(Cell::get);
        let known = before.filter(|several| several.has(turn));
        let several = work.several.map(|_| known.unwrap_or_else(|| several_from(turn, before, cloud, work)));
        let shaded = several.is_some_and(|several| several.shaded);
        let found = several.map_or(pixels, |several| u64::from(several.stride) * u64::from(several.images));
        self.nearest.reserve(device, found)?;
        self.shades.reserve(device, if shaded { cloud.len() } else { 1 })?;
        let mut recorder = work.timeline.recorder(device)?;
        let nearest = self.nearest.get().slice(0, found);
        if known.is_some() {
            cloud.record_view(&mut recorder);
        } else {
            recorder.fill("project/clear", nearest, u32::MAX)?;
            cloud.record_clear(&mut recorder)?;
            let choice = Choice { several, ..Choice::default() };
            record_nearest(&mut recorder, cloud, nearest, work.switches.wide_atomics, &choice)?;
            cloud.record_stats(&mut recorder)?;
        }
        let cut = Cut::new(device, cloud.len())?;
        let shading = how.shaded(cloud.has_normals()).cut(cut);
        if shaded && before.is_none() {
            let shade = Shade {
                camera: cloud.view(),
                points_hi: cut.slices(&cloud.points_hi),
                points_lo: cut.slices(&cloud.points_lo),
                point_colors: cut.slices(&cloud.point_colors),
                normals: cut.slices(&cloud.normals),
                shades: self.shades.get().slice(0, cloud.len()),
            };
            let run = Run::new(Dispatch::Invocations(cloud.len())).variant(shading.clone());
            recorder.run(&shade, CountPush { count: cloud.len() as u32 }, &run)?;
            work.facts.shaded_points += cloud.len();
        }
        let place = several.map_or(0, |several| turn - several.first);
        let start = several.map_or(0, |several| u64::from(place) * u64::from(several.stride));
        let resolve = Resolve {
            camera: cloud.view(),
            points_hi: cut.slices(&cloud.points_hi),
            points_lo: cut.slices(&cloud.points_lo),
            point_colors: cut.slices(&cloud.point_colors),
            normals: cut.slices(&cloud.normals),
            nearest: self.nearest.get().slice(start, pixels).cast(),
            shades: self.shades.get().slice(0, if shaded { cloud.len() } else { 1 }),
            into: target.pixels(),
        };
        let push = CountPush { count: pixels as u32 };
        let run = Run::new(Dispatch::Invocations(pixels));
        recorder.run(&resolve, push, &run.variant(resolve_variant(shading, shaded)))?;
        target.record_read_back(&mut recorder, pixels)?;
        work.timeline.submit(recorder, "points/nearest")?;
        if known.is_some() {
            work.facts.shared_walks += 1;
            return Ok(Vec::new());
        }
        if let Some(last) = work.several {
            last.set(several);
        }
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
        let variant = nearest_variant(cull, choice.limits.is_some());
        Run::new(dispatch).variant(variant.with("SEVERAL", u32::from(choice.several.is_some())))
    };
    let bound = |(first, count): (u64, u64)| {
        let normals = if cull { cloud.normals.slice(first, count) } else { cloud.normals.slice(0, 1) };
        // A buffer of the cloud stands in for none.
        let limits = choice.limits.unwrap_or_else(|| cloud.large.slice(0, 1));
        let places: Places<'a> = cloud.places(first, count);
        (places, normals, limits)
    };
    let push = |chunk: usize, range: (u64, u64)| {
        let push = PointsPush::new(chunk, range);
        choice.several.map_or(push, |several| several.of(push))
    };
    // All depths come before any index.
    macro_rules! record {
        ($pass:ident, $nearest:expr) => {
            for (chunk, range) in chunks() {
                let (places, normals, limits) = bound(range);
                let pass = $pass { places, normals, limits, nearest: $nearest };
                recorder.run(&pass, push(chunk, range), &run(chunk, range))?;
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
    let chosen = || <(bool, bool)>::all().into_iter().map(|(cull, limited)| nearest_variant(cull, limited));
    let variants = || {
        let alone = chosen().map(|variant| variant.with("SEVERAL", 0));
        alone.chain([nearest_variant(false, false).with("SEVERAL", 1)])
    };
    let resolved = Shaded::cut_variants().into_iter();
    let resolved = resolved.flat_map(|shaded| [false, true].map(|ready| resolve_variant(shaded.clone(), ready)));
    vec![
        Shader::new::<Nearest>(variants()),
        Shader::new::<NearestDepth>(variants()),
        Shader::new::<NearestId>(variants()),
        Shader::new::<Shade>(Shaded::cut_variants()),
        Shader::new::<Resolve>(resolved),
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

    /// One walk over the points finds those of several images.
    fn takes_fours(&self) -> bool {
        false
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
            "points/nearest" => {
                let walks = facts.windows.saturating_sub(facts.shared_walks).max(1);
                Some(facts.points * 32 * walks + facts.visible * 8)
            }
            "points/shade" => Some(facts.shaded_points * (32 + 16 + SHADE_BYTES)),
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
        let shaded = plan.facts.shaded_points;
        let once = match shaded {
            0 => "each pixel shades its nearest point".to_owned(),
            _ => format!("{shaded} points are shaded, once for all images; {shading}"),
        };
        plan.add("points/shade", shaded > 0, once);
        plan.add("points/resolve", true, format!("turns the index of the nearest point into a color; {shading}"));
    }
}

/// Returns the passes of 1-pixel points.
pub(crate) fn pass_group() -> PassGroup {
    let names = NEAREST.into_iter().chain(["points/shade", "points/resolve"]).collect();
    PassGroup { names, absent: Absent::Method("no 1-pixel points") }
}
