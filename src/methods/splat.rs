//! Opaque splats (`points`, `squares`, `circles`): the nearest wins, ties by content.
//!
//! Where the device has 64-bit atomics, one minimum over depth and index together; elsewhere two passes of 32 bits.

use super::bands::{self, Band, Window};
use super::renderer::{Target, Timeline};
use super::{Error, abuffer};
use crate::gpu::{Buffer, Device, Dispatch, Kept, Memory, Run};
use crate::passes::compose::{self, Composing, Cut};
use crate::passes::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, Tilt, View};
use crate::passes::raster::{Chunk, RasterPush, Tiled, Walker, tile_offsets_len};
use crate::passes::scan::Scan;
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
        view: Uniform<View>,
        splats: Read<Splat>,
        tilts: Read<Tilt>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        tile_offsets: Read<u32>,
        nearest: ReadWrite<u64>,
    }
}

pass! {
    /// Depth by a 32-bit minimum.
    pub NearestDepth(RasterPush) = "splat/nearest-depth" in "splat/nearest_depth" {
        view: Uniform<View>,
        splats: Read<Splat>,
        tilts: Read<Tilt>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        tile_offsets: Read<u32>,
        nearest: ReadWrite<NearestSplat>,
    }
}

pass! {
    /// Index among those at the smallest depth.
    pub NearestId(RasterPush) = "splat/nearest-id" in "splat/nearest_id" {
        view: Uniform<View>,
        splats: Read<Splat>,
        tilts: Read<Tilt>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        tile_offsets: Read<u32>,
        nearest: ReadWrite<NearestSplat>,
    }
}

pass! {
    /// Index to color.
    pub Resolve(abuffer::CountPush) = "splat/resolve" {
        view: Uniform<View>,
        colors: Parts<[f32; 4]>,
        splats: Parts<Splat>,
        tilts: Parts<Tilt>,
        nearest: Read<NearestSplat>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// Device bytes per pixel of a window.
pub const PIXEL_BYTES: u64 = 8;

/// Buffers of opaque splats, kept from frame to frame.
pub struct Opaque {
    nearest: Kept<NearestSplat>,
    tile_offsets: Kept<u32>,
    scan: Option<Scan>,
    overflow: Buffer<u32>,
}

/// Everything that stays the same while a window is rendered.
pub struct WindowJob<'a> {
    /// The projected cloud.
    pub cloud: &'a DeviceCloud,
    /// What its projection found.
    pub stats: &'a [Stats],
    /// Which pixels a splat covers.
    pub footprint: Footprint,
    /// Who visits pixels.
    pub walker: Walker,
    /// Whether 64-bit atomics are used.
    pub wide: bool,
    /// The rectangle.
    pub window: Window,
}

impl Opaque {
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            nearest: Kept::new("nearest splats", Memory::Device),
            tile_offsets: Kept::new("tile offsets", Memory::Device),
            scan: None,
            overflow: device.buffer("scan overflow", 1, Memory::Device)?,
        })
    }

    /// Renders a window into the target.
    pub fn render(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        target: &Target,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let pixels = bands::pixels(job.window);
        let large: u64 = job.stats.iter().map(|s| u64::from(s.large)).max().unwrap_or(0);
        self.nearest.reserve(device, pixels)?;
        self.tile_offsets.reserve(device, tile_offsets_len(job.stats))?;
        if self.scan.as_ref().is_none_or(|s| s.capacity() < large) {
            self.scan = Some(Scan::new(device, large)?);
        }

        let mut recorder = device.recorder()?;
        let nearest = self.nearest.get().slice(0, pixels);
        let tiled = Tiled::new(job.cloud, job.stats, self.tile_offsets.get(), job.walker, job.footprint, job.window);
        recorder.fill("splat/clear", nearest, u32::MAX)?;
        recorder.fill("splat/clear", self.overflow.all(), 0)?;
        if let Some(scan) = &self.scan {
            tiled.record_tiles(&mut recorder, scan, self.overflow.all())?;
        }
        let all = &Band::whole(job.window, 0);
        if job.wide {
            tiled.record(&mut recorder, all, |c: Chunk<'_>| Nearest {
                view: c.view,
                splats: c.splats,
                tilts: c.tilts,
                bounds: c.bounds,
                large: c.large,
                tile_offsets: c.tile_offsets,
                nearest: nearest.cast(),
            })?;
        } else {
            tiled.record(&mut recorder, all, |c: Chunk<'_>| NearestDepth {
                view: c.view,
                splats: c.splats,
                tilts: c.tilts,
                bounds: c.bounds,
                large: c.large,
                tile_offsets: c.tile_offsets,
                nearest,
            })?;
            tiled.record(&mut recorder, all, |c: Chunk<'_>| NearestId {
                view: c.view,
                splats: c.splats,
                tilts: c.tilts,
                bounds: c.bounds,
                large: c.large,
                tile_offsets: c.tile_offsets,
                nearest,
            })?;
        }
        let cut = Cut::new(device, job.cloud.len())?;
        let Composing { colors, splats, tilts } = Composing::new(job.cloud, cut);
        let (image, depths) = (target.image(), target.depths());
        let resolve = Resolve { view: job.cloud.view(), colors, splats, tilts, nearest, image, depths };
        let run = Run::new(Dispatch::Invocations(pixels)).push(&abuffer::CountPush { count: pixels as u32 });
        recorder.run(&resolve, &run.variant(compose::variant(cut, Footprint::Disc, Falloff::Flat)))?;
        target.record_read_back(&mut recorder, pixels)?;
        timeline.add(recorder.submit("splat/nearest")?);
        Ok(())
    }
}
