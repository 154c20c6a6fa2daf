//! Opaque splats in three passes (`hqs`, `splats`; Botsch, Spernat, Kobbelt 2004), which blend what lies close
//! together: visibility, attributes, normalization. Other methods take them for their solid points. Those whose nearest
//! one wins are [`super::opaque`].
//!
//! Splats go through tiles in canonical order and their sums are compensated, so that neither windows nor runs over a
//! tile's splats change a byte.
//!
//! Reference: `pellucid_reference::splats`.

use super::tiled;
use crate::methods::prelude::*;
use crate::passes::project::TILED;

gpu_struct! {
    /// Push constants of the first two passes.
    pub struct SplatsPush {
        walk: TileWalk,
        blend_depth: f32, // Fragments up to so many radii behind the nearest are blended with it.
    }
}

pass! {
    /// Finds the nearest depth of each pixel, and the least z + `blend_depth` · r, behind which fragments are hidden:
    /// one subgroup per 8 × 8 block of a tile. A run takes 2048 splats, and the next goes on from there.
    pub Visibility(SplatsPush) = "splats/visibility" {
        tiles: Shared<TiledGroup>,
        layer: Read<f32>,
        limits: ReadWrite<f32>,
        depths: ReadWrite<f32>,
    }

    /// Visits the same splats again, and sums w c and w of the fragments that are not hidden, w = exp(−2ρ²).
    pub Attributes(SplatsPush) = "splats/attributes" {
        tiles: Shared<TiledGroup>,
        layer: Read<f32>,
        limits: Read<f32>,
        image: ReadWrite<[f32; 4]>,
        excess: ReadWrite<[f32; 4]>,
    }

    /// Turns the sums of each pixel into color, and sets A = 1 where there are any.
    pub Normalize(CountPush) = "splats/normalize" {
        image: ReadWrite<[f32; 4]>,
    }
}

/// The passes, by name.
pub const PASSES: [&str; 3] = ["splats/visibility", "splats/attributes", "splats/normalize"];

/// Device bytes per pixel of a window, besides tiles and what is drawn into.
pub const PIXEL_BYTES: u64 = 4 + 16;

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct SplatsJob<'a> {
    /// The splats to bin, in the order of indices. Bytes that are in use must count [`PIXEL_BYTES`].
    pub bin: bin::Job<'a>,
    /// Fragments up to so many radii behind the nearest are blended with it.
    pub blend_depth: f32,
    /// Depths of a layer, behind which alone splats count unless they are marked as solid
    /// ([`crate::passes::project::CloudPart::Marked`]).
    pub layer: Option<Slice<'a, f32>>,
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Splatter {
        limits: Scratch<f32> = Scratch::new("limits of depth", Memory::Device),
        excess: Scratch<[f32; 4]> = Scratch::new("excess of sums", Memory::Device),
    }
}

impl Splatter {
    /// Bins a window's projected splats and draws them; nothing is read back.
    pub(crate) fn render(
        &mut self,
        bins: &mut Bins,
        work: &mut Work<'_>,
        job: &SplatsJob<'_>,
        into: Pixels<'_>,
    ) -> Result<Outcome, Error> {
        let device = work.device;
        let window = job.bin.raster.window;
        let mut recorder;
        // Where there is nothing to bin, a device need not be able to.
        let bin = if is_seen(&job.bin) { bins.bin(device, &job.bin, work.timeline)? } else { Bin::Nothing };
        match bin {
            Bin::TooLarge => return Ok(Outcome::Overflow),
            Bin::Nothing => {
                recorder = work.timeline.recorder(device)?;
                into.record_nothing(&mut recorder, window)?;
            }
            Bin::Done(binned) => {
                let pixels = bands::pixels(window);
                self.limits.reserve(device, pixels)?;
                self.excess.reserve(device, if binned.region_segments() > 1 { pixels } else { 1 })?;
                work.note_binned(binned);
                work.facts.splatted += 1;
                recorder = work.timeline.recorder(device)?;
                self.record(bins, &mut recorder, job, binned, into)?;
            }
        }
        work.timeline.go_on(recorder, "splats/visibility and attributes")?;
        Ok(Outcome::Done)
    }

    /// Records the three passes over all tiles.
    fn record<'a>(
        &'a self,
        bins: &'a Bins,
        recorder: &mut Recorder<'a>,
        job: &SplatsJob<'a>,
        binned: Binned,
        into: Pixels<'a>,
    ) -> Result<(), Error> {
        let raster = job.bin.raster;
        let ordered = bins.record_tiles(recorder, raster.cloud, binned)?;
        let tiles = ordered.tiled;
        let limits = self.limits.get().all();
        // Without a layer nothing is read from there.
        let layer = job.layer.unwrap_or(into.depths);
        let visibility = Visibility { tiles, layer, limits, depths: into.depths };
        let (image, excess) = (into.image, self.excess.get().all());
        let attributes = Attributes { tiles, layer, limits, image, excess };
        let (runs, behind) = (binned.region_segments(), job.layer.is_some());
        let shape = compose::variant(binned.cut(), raster.footprint, Falloff::Flat);
        let push = |walk| SplatsPush { walk, blend_depth: job.blend_depth };
        let variant = tile_variant(shape, binned.lanes(), behind);
        binned.record_runs(recorder, &visibility, runs, push, &variant)?;
        binned.record_runs(recorder, &attributes, runs, push, &variant)?;
        let pixels = bands::pixels(raster.window);
        let push = CountPush { count: pixels as u32 };
        Ok(recorder.run(&Normalize { image }, push, &Run::new(Dispatch::Invocations(pixels)))?)
    }
}

/// Returns `true` if any splat touches the window.
fn is_seen(job: &bin::Job<'_>) -> bool {
    job.raster.stats.iter().any(|s| s.visible > 0)
}

/// Decides how a window is binned; draws nothing.
pub fn survey(device: &Device, job: &bin::Job<'_>, facts: &mut Facts) -> Result<Outcome, Error> {
    if !is_seen(job) {
        return Ok(Outcome::Done);
    }
    let mut found = Facts { bands: 0, ..facts.clone() };
    let outcome = found.note_survey(Bins::survey(device, job)?);
    *facts = Facts { splatted: facts.splatted + found.bands, bands: facts.bands, ..found };
    Ok(outcome)
}

/// A variant of the stages that go through tiles; `behind`: only fragments behind a layer count.
fn tile_variant(shape: Variant, lanes: Lanes, behind: bool) -> Variant {
    bin::region_variant(shape, lanes).with("BEHIND", u32::from(behind))
}

/// Returns the number of bytes that a pass must at least read and write: of splats each pair with a tile in each of two
/// passes, `tilted` whether they are oriented; and the pixels of so many `windows`.
pub fn least_bytes(name: &str, facts: &Facts, tilted: bool, pixels: u64) -> Option<u64> {
    // Index, then splat, depth and tilt.
    let splat = 4 + 16 + 4 + if tilted { 16 } else { 0 };
    match name {
        "splats/visibility" => Some(facts.tile_entries * splat + pixels * 8),
        "splats/attributes" => Some(facts.tile_entries * (splat + 16) + pixels * 20),
        "splats/normalize" => Some(pixels * 32),
        _ => None,
    }
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let shapes = TILED.iter().flat_map(|shape| Cut::all().into_iter().map(|cut| (cut, *shape)));
    let shapes: Vec<_> = shapes.map(|(cut, shape)| compose::variant(cut, shape, Falloff::Flat)).collect();
    let variants = bin::tile_variants(shapes, &[false, true], tile_variant);
    vec![Shader::new::<Visibility>(variants.clone()), Shader::new::<Attributes>(variants), Shader::plain::<Normalize>()]
}

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
    buffers: &mut Buffers,
    work: &mut Work<'_>,
    drawing: &Drawing<'_>,
) -> Result<Outcome, Error> {
    let Buffers { tiles, resources } = buffers;
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

/// Draws projected points as `splats` does, with its defaults. A pixel takes `counted_bytes` where splats are counted.
pub(crate) fn draw_solid(
    cloud: &DeviceCloud,
    buffers: &mut Buffers,
    work: &mut Work<'_>,
    (stats, footprint, onto): (&[Stats], Footprint, Onto),
    counted_bytes: u64,
) -> Result<Outcome, Error> {
    let (blend_depth, used_bytes) = (BlendedSplats::default().blend_depth, SOLID_BYTES + counted_bytes);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_bytes_by_hand() {
        let facts = Facts { tile_entries: 20, ..Facts::default() };
        // Index, splat and depth; limit and depth of each pixel.
        assert_eq!(least_bytes("splats/visibility", &facts, false, 10), Some(20 * 24 + 10 * 8));
        assert_eq!(least_bytes("splats/visibility", &facts, true, 10), Some(20 * 40 + 10 * 8));
        // Colors too; the limit is read, a sum written.
        assert_eq!(least_bytes("splats/attributes", &facts, true, 10), Some(20 * 56 + 10 * 20));
        assert_eq!(least_bytes("splats/normalize", &facts, true, 10), Some(10 * 32));
        assert_eq!(least_bytes("opaque/nearest", &facts, true, 10), None);
    }
}
