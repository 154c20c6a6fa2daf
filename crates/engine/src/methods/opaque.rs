//! Opaque splats (`squares`, `circles`, `paraboloid`, `cone`, `sphere`): the nearest wins, ties by content.
//!
//! Where the device has 64-bit atomics, one minimum over depth and index together; elsewhere two passes of 32 bits.

use crate::methods::explain::COUNTERS;
use crate::methods::prelude::*;
use crate::scene::Relief;

gpu_struct! {
    /// A pixel's nearest splat.
    pub struct NearestSplat {
        id: u32,
        key: u32,
    }
}

pass! {
    /// Takes the 64-bit atomic minimum of depth key and splat index at each covered pixel.
    pub Nearest(RasterPush) = "opaque/nearest" with "nearest_wide" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<u64>,
    }

    /// Finds the depth of `opaque/nearest` by a 32-bit minimum, where the device has no 64-bit atomics.
    pub NearestDepth(RasterPush) = "opaque/nearest-depth" in "opaque/nearest" with "nearest_depth",
    /// Finds the smallest index at the depth of `opaque/nearest-depth`.
    pub NearestId(RasterPush) = "opaque/nearest-id" in "opaque/nearest" with "nearest_id" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<NearestSplat>,
    }

    /// Turns the index of the nearest splat of each pixel into color and depth.
    pub Resolve(CountPush) = "opaque/resolve" {
        composing: Shared<ComposingGroup>,
        nearest: Read<NearestSplat>,
        into: Shared<PixelsGroup>,
    }
}

/// The variant of the passes that find the nearest splats, for a walker's.
fn relief_variant(walker: Variant, relief: Relief) -> Variant {
    walker.with("RELIEF", relief as u32)
}

/// Device bytes per pixel of a window.
pub const PIXEL_BYTES: u64 = 8;

fields! {
    /// Buffers of opaque splats, kept from frame to frame.
    pub struct Opaque {
        pub(super) nearest: Scratch<NearestSplat> = Scratch::new("nearest splats", Memory::Device),
        pub(super) shades: Scratch<[f32; 4]> = Scratch::new("point shades", Memory::Device),
    }
}

impl Opaque {
    /// Renders a window into the target; `relief` says how far fragments are moved.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, raster: &Raster<'_>, relief: Relief) -> Result<(), Error> {
        let (device, target, wide) = (work.device, work.target, work.switches.wide_atomics);
        let pixels = bands::pixels(raster.window);
        self.nearest.reserve(device, pixels)?;

        let mut recorder = work.timeline.recorder(device)?;
        let nearest = self.nearest.get().slice(0, pixels);
        recorder.fill("project/clear", nearest, u32::MAX)?;
        raster.record_tiles(&mut recorder)?;
        let all = &Band::whole(raster.window, 0);
        let moved = |variant| relief_variant(variant, relief);
        if wide {
            let packed = nearest.cast();
            raster.record_with(&mut recorder, all, |chunk| Nearest { chunk, nearest: packed }, None, moved)?;
        } else {
            raster.record_with(&mut recorder, all, |chunk| NearestDepth { chunk, nearest }, None, moved)?;
            raster.record_with(&mut recorder, all, |chunk| NearestId { chunk, nearest }, None, moved)?;
        }
        let cut = Cut::new(device, raster.cloud.len())?;
        let composing = Composing::new(raster.cloud, cut);
        let resolve = Resolve { composing, nearest, into: target.pixels() };
        let push = CountPush { count: pixels as u32 };
        let run = Run::new(Dispatch::Invocations(pixels));
        recorder.run(&resolve, push, &run.variant(compose::variant(cut, Footprint::Disc, Falloff::Flat)))?;
        target.record_read_back(&mut recorder, pixels)?;
        work.timeline.submit(recorder, "opaque/nearest")?;
        Ok(())
    }
}

choices!(
    enum Relief {
        Flat,
        Paraboloid,
        Cone,
        Sphere,
    }
);

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 3] = [
    ("RELIEF_FLAT", Relief::Flat as u32),
    ("RELIEF_PARABOLOID", Relief::Paraboloid as u32),
    ("RELIEF_CONE", Relief::Cone as u32),
];

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let variants = || {
        let flat = raster::flat_variants().into_iter();
        flat.flat_map(|walker| Relief::all().into_iter().map(move |relief| relief_variant(walker.clone(), relief)))
    };
    vec![
        Shader::new::<Nearest>(variants()),
        Shader::new::<NearestDepth>(variants()),
        Shader::new::<NearestId>(variants()),
        Shader::new::<Resolve>(compose::variants()),
    ]
}

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
        let ScreenSplats { size, max_pixel_radius, pixel_radius, .. } = self.splats;
        match pixel_radius {
            Some(radius) => PointExtent::pixels(radius.min(max_pixel_radius).into()),
            None => PointExtent::squares(frame.factors.radius * size),
        }
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let Buffers { tiles, resources } = buffers;
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
        let tiled = plan.pairs(plan.facts.large);
        plan.scan(tiled, "tiles of each large splat");
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

/// Returns the passes of opaque splats where only the nearest one counts.
pub(crate) fn pass_group() -> PassGroup {
    let names = NEAREST.into_iter().chain(["opaque/resolve"]).collect();
    PassGroup { names, absent: Absent::Method("no opaque splats") }
}
