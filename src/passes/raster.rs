//! Visiting the pixels of splats, in compute shaders or by the rasteriser, for any stage that binds what
//! shaders/shared/raster.wgsl states.

use super::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, Tilt, View};
use super::scan::Scan;
use crate::gpu::{Buffer, Dispatch, Draw, Error, Pass, Recorder, Run, Slice, Variant};
use crate::gpu_struct;
use crate::methods::bands::Band;

gpu_struct! {
    /// Push constants of a stage that visits splats; shaders/shared/raster.wgsl says what the members are.
    pub struct RasterPush {
        count: u32,
        first: u32,
        large_count: u32,
        tiles: u32,
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
    }
}

/// Who visits the pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walker {
    /// Compute: one invocation per small splat, one workgroup per tile of a large one.
    Compute,
    /// The rasteriser.
    Hardware,
}

/// What a stage binds of one chunk.
pub struct Chunk<'a> {
    /// The camera.
    pub view: Slice<'a, View>,
    /// The chunk's splats.
    pub splats: Slice<'a, Splat>,
    /// Their tilts.
    pub tilts: Slice<'a, Tilt>,
    /// Their rectangles.
    pub bounds: Slice<'a, Bounds>,
    /// Indices of the large ones.
    pub large: Slice<'a, u32>,
    /// Prefix sums of their tiles.
    pub tile_offsets: Slice<'a, u32>,
}

/// A projected cloud with its large splats cut into tiles.
pub struct Tiled<'a> {
    cloud: &'a DeviceCloud,
    stats: &'a [Stats],
    tile_offsets: &'a Buffer<u32>,
    /// The walker in force.
    pub walker: Walker,
    footprint: Footprint,
    window: [u32; 4],
}

impl<'a> Tiled<'a> {
    /// `stats` are those of the last projection into `window`; `tile_offsets` has an element for each large splat of all chunks.
    pub fn new(
        cloud: &'a DeviceCloud,
        stats: &'a [Stats],
        tile_offsets: &'a Buffer<u32>,
        walker: Walker,
        footprint: Footprint,
        window: [u32; 4],
    ) -> Self {
        Self { cloud, stats, tile_offsets, walker, footprint, window }
    }

    /// Records the prefix sums over the tiles of large splats, if there are any.
    pub fn record_tiles(
        &self,
        recorder: &mut Recorder<'a>,
        scan: &'a Scan,
        overflow: Slice<'a, u32>,
    ) -> Result<(), Error> {
        for (chunk, ((first, _), stats)) in self.cloud.chunks().zip(self.stats).enumerate() {
            if stats.large > 0 && self.walker == Walker::Compute {
                let counts = self.cloud.tile_counts.slice(first, u64::from(stats.large));
                scan.record(recorder, counts, self.tiles_of(chunk), overflow)?;
            }
        }
        Ok(())
    }

    /// The chunk's part of the tiles' prefix sums; a stand-in if it has no large splat.
    fn tiles_of(&self, chunk: usize) -> Slice<'a, u32> {
        let large = |s: &Stats| u64::from(s.large).next_multiple_of(64);
        let start: u64 = self.stats[..chunk].iter().map(large).sum();
        match self.stats[chunk].large {
            0 => self.tile_offsets.slice(0, 1),
            n => self.tile_offsets.slice(start, u64::from(n)),
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
        for (chunk, ((first, count), stats)) in self.cloud.chunks().zip(self.stats).enumerate() {
            if stats.visible == 0 {
                continue;
            }
            let pass = stage(self.chunk(chunk, first, count));
            let push = RasterPush {
                count: count as u32,
                first: first as u32,
                large_count: stats.large,
                // A window whose tiles overflow is cut before it comes here.
                tiles: stats.tiles() as u32,
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
            };
            match self.walker {
                Walker::Compute => {
                    let small = Run::new(Dispatch::Invocations(count)).push(&push);
                    recorder.run(&pass, &small.variant(variant(self.footprint, "walk_small")))?;
                    if stats.large > 0 {
                        let large = Run::new(Dispatch::Groups(stats.tiles())).push(&push);
                        recorder.run(&pass, &large.variant(variant(self.footprint, "walk_large")))?;
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

    fn chunk(&self, chunk: usize, first: u64, count: u64) -> Chunk<'a> {
        let tilts = if self.footprint == Footprint::Oriented {
            self.cloud.tilts_of(first, count)
        } else {
            self.cloud.tilts.all()
        };
        Chunk {
            view: self.cloud.view(),
            splats: self.cloud.splats.slice(first, count),
            tilts,
            bounds: self.cloud.bounds.slice(first, count),
            large: self.cloud.large.slice(first, count),
            tile_offsets: self.tiles_of(chunk),
        }
    }
}

/// Elements that the tiles' prefix sums need: each chunk's begin at a multiple of 64, and there is at least one.
pub fn tile_offsets_len(stats: &[Stats]) -> u64 {
    stats.iter().map(|s| u64::from(s.large).next_multiple_of(64)).sum::<u64>().max(1)
}

/// The variant of a stage for a footprint and a walker.
pub fn variant(footprint: Footprint, walker: &'static str) -> Variant {
    Variant::plain().with("SHAPE", footprint as u32).walker(walker)
}

/// The walkers by the names of their shared pieces.
pub const WALKERS: [&str; 3] = ["walk_small", "walk_large", "walk_fragment"];
