//! Opaque splats (`squares`, `circles`, `paraboloid`, `cone`, `sphere`): the nearest wins, ties by content.
//!
//! Where the device has 64-bit atomics, one minimum over depth and index together; elsewhere two passes of 32 bits.

mod engine;

pub(crate) use engine::{NearestEngine, counter_group, pass_group, tile_group};

use super::engine::Work;
use super::{Error, PixelsGroup};
use crate::choices::Choices;
use crate::gpu::shader::Shader;
use crate::gpu::{Dispatch, Memory, Run, Scratch, Variant};
use crate::passes::bands::{self, Band};
use crate::passes::compose::{self, Composing, ComposingGroup, Cut};
use crate::passes::project::Footprint;
use crate::passes::raster::{self, ChunkGroup, CountPush, Raster, RasterPush};
use crate::passes::tiles::SEGMENT;
use crate::scene::{Falloff, Relief};
use crate::{choices, fields, gpu_struct, pass};

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
        let all = (&Band::whole(raster.window, 0), SEGMENT);
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
