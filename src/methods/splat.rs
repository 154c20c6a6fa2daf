//! Opaque splats (`squares`, `circles`): the nearest wins, ties by content.
//!
//! Where the device has 64-bit atomics, one minimum over depth and index together; elsewhere two passes of 32 bits.

use super::bands::{self, Band};
use super::renderer::{Target, Timeline};
use super::{Error, abuffer};
use crate::gpu::{Device, Dispatch, Kept, Memory, Run};
use crate::passes::compose::{self, Composing, ComposingGroup, Cut};
use crate::passes::project::Footprint;
use crate::passes::raster::{Chunk, ChunkGroup, Raster, RasterPush};
use crate::scene::Falloff;
use crate::{gpu_struct, pass};

gpu_struct! {
    /// A pixel's nearest splat.
    pub struct NearestSplat {
        id: u32,
        key: u32,
    }
}

pass! {
    /// Depth and index by one 64-bit minimum.
    pub Nearest(RasterPush) = "splat/nearest" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<u64>,
    }
}

pass! {
    /// Depth by a 32-bit minimum.
    pub NearestDepth(RasterPush) = "splat/nearest-depth" in "splat/nearest_depth" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<NearestSplat>,
    }
}

pass! {
    /// Index among those at the smallest depth.
    pub NearestId(RasterPush) = "splat/nearest-id" in "splat/nearest_id" {
        chunk: Shared<ChunkGroup>,
        nearest: ReadWrite<NearestSplat>,
    }
}

pass! {
    /// Index to color.
    pub Resolve(abuffer::CountPush) = "splat/resolve" {
        composing: Shared<ComposingGroup>,
        nearest: Read<NearestSplat>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// Device bytes per pixel of a window.
pub const PIXEL_BYTES: u64 = 8;

/// Buffers of opaque splats, kept from frame to frame.
pub struct Opaque {
    pub(super) nearest: Kept<NearestSplat>,
}

impl Default for Opaque {
    fn default() -> Self {
        Self { nearest: Kept::new("nearest splats", Memory::Device) }
    }
}

impl Opaque {
    /// Renders a window into the target; `wide` says whether 64-bit atomics are used.
    pub fn render(
        &mut self,
        device: &Device,
        raster: &Raster<'_>,
        wide: bool,
        target: &Target,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let pixels = bands::pixels(raster.window);
        self.nearest.reserve(device, pixels)?;

        let mut recorder = device.recorder()?;
        let nearest = self.nearest.get().slice(0, pixels);
        recorder.fill("splat/clear", nearest, u32::MAX)?;
        raster.record_tiles(&mut recorder)?;
        let all = &Band::whole(raster.window, 0);
        if wide {
            raster.record(&mut recorder, all, |chunk: Chunk<'_>| Nearest { chunk, nearest: nearest.cast() })?;
        } else {
            raster.record(&mut recorder, all, |chunk: Chunk<'_>| NearestDepth { chunk, nearest })?;
            raster.record(&mut recorder, all, |chunk: Chunk<'_>| NearestId { chunk, nearest })?;
        }
        let cut = Cut::new(device, raster.cloud.len())?;
        let composing = Composing::new(raster.cloud, cut);
        let (image, depths) = (target.image(), target.depths());
        let resolve = Resolve { composing, nearest, image, depths };
        let run = Run::new(Dispatch::Invocations(pixels)).push(&abuffer::CountPush { count: pixels as u32 });
        recorder.run(&resolve, &run.variant(compose::variant(cut, Footprint::Disc, Falloff::Flat)))?;
        target.record_read_back(&mut recorder, pixels)?;
        timeline.add(recorder.submit("splat/nearest")?);
        Ok(())
    }
}
