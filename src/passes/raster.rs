//! Visiting the pixels of splats, in compute shaders or by the rasteriser, for any stage that binds what
//! shaders/shared/raster.wgsl states.

use super::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, Tilt, View};
use super::tiles::{self, SEGMENT, TILE, Tiles};
use crate::gpu::{Dispatch, Draw, Error, Pass, Recorder, Run, Variant};
use crate::methods::bands::{Band, Window};
use crate::{gpu_struct, group};

gpu_struct! {
    /// Push constants of a stage that visits splats; shaders/shared/raster.wgsl says what the members are.
    pub struct RasterPush {
        count: u32,
        first: u32,
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
        first_tile: u32,
        tiles: u32,
        segments: u32,
    }
}

/// Who visits the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walker {
    /// Compute: one invocation per small splat, large ones tile by tile.
    Compute,
    /// The rasteriser.
    Hardware,
}

group! {
    /// What a stage binds of one chunk.
    pub Chunk as ChunkGroup {
        /// The camera.
        camera: Uniform<View>,
        /// The chunk's splats.
        splats: Read<Splat>,
        /// Their tilts.
        tilts: Read<Tilt>,
        /// Their rectangles.
        bounds: Read<Bounds>,
        /// First entry of each tile.
        tile_starts: Read<u32>,
        /// Large splats of the tiles.
        tile_entries: Read<u32>,
    }
}

/// A projected cloud whose pixels are visited.
#[derive(Clone, Copy)]
pub struct Raster<'a> {
    /// The cloud.
    pub cloud: &'a DeviceCloud,
    /// What its projection into the window found.
    pub stats: &'a [Stats],
    /// The window's tiles; recorded before, if the walker is [`Walker::Compute`].
    pub tiles: &'a Tiles,
    /// Who visits.
    pub walker: Walker,
    /// Which pixels a splat covers.
    pub footprint: Footprint,
    /// The rectangle of pixels in work.
    pub window: Window,
}

impl<'a> Raster<'a> {
    /// Records the tiles of large splats, if the walker asks for them.
    pub fn record_tiles(&self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        match self.walker {
            Walker::Compute => self.tiles.record(recorder, self.cloud, self.stats, self.window),
            Walker::Hardware => Ok(()),
        }
    }

    /// Records a stage over all splats and the pixels of a band.
    pub fn record<P: Pass + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        band: &Band,
        stage: impl Fn(Chunk<'a>) -> P,
    ) -> Result<(), Error> {
        let [x0, y0, x1, y1] = self.window;
        let [first_tile, tiles] = self.tiles_of(band);
        for (chunk, ((first, count), stats)) in self.cloud.chunks().zip(self.stats).enumerate() {
            if stats.visible == 0 {
                continue;
            }
            let pass = stage(self.chunk(chunk, first, count));
            let segments = stats.large.div_ceil(SEGMENT);
            let push = RasterPush {
                count: count as u32,
                first: first as u32,
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
                first_tile,
                tiles,
                segments,
            };
            match self.walker {
                Walker::Compute => {
                    let small = Run::new(Dispatch::Invocations(count)).push(&push);
                    recorder.run(&pass, &small.variant(variant(self.footprint, "walk_small")))?;
                    if stats.large > 0 {
                        let large = Run::new(Dispatch::Groups(u64::from(tiles) * u64::from(segments))).push(&push);
                        recorder.run(&pass, &large.variant(variant(self.footprint, "walk_tiles")))?;
                    }
                }
                Walker::Hardware => {
                    let draw = Draw { vertices: 6 * count as u32, area: [x1 - x0, y1 - y0] };
                    recorder.draw(&pass, &variant(self.footprint, "walk_fragment"), bytemuck::bytes_of(&push), draw)?;
                }
            }
        }
        Ok(())
    }

    /// First tile and number of tiles of the rows of tiles that meet a band.
    fn tiles_of(&self, band: &Band) -> [u32; 2] {
        let columns = tiles::grid(self.window)[0];
        let row = |pixel: u32| pixel / (self.window[2] - self.window[0]) / TILE;
        let (first, last) = (row(band.pixels[0]), row(band.pixels[1].max(1) - 1));
        [first * columns, (last - first + 1) * columns]
    }

    fn chunk(&self, chunk: usize, first: u64, count: u64) -> Chunk<'a> {
        let cloud = self.cloud;
        let oriented = self.footprint == Footprint::Oriented;
        Chunk {
            camera: cloud.view(),
            splats: cloud.splats.slice(first, count),
            tilts: if oriented { cloud.tilts_of(first, count) } else { cloud.tilts.slice(0, 1) },
            bounds: cloud.bounds.slice(first, count),
            tile_starts: self.tiles.starts_of(self.stats, chunk, self.window),
            tile_entries: self.tiles.entries_of(self.stats, chunk),
        }
    }
}

/// The variant of a stage for a footprint and a walker.
pub fn variant(footprint: Footprint, walker: &'static str) -> Variant {
    Variant::plain().with("SHAPE", footprint as u32).walker(walker)
}

/// The walkers by the names of their shared pieces.
pub const WALKERS: [&str; 3] = ["walk_small", "walk_tiles", "walk_fragment"];
