//! Large splats by tile: which of them meet each tile of 16 × 16 pixels of the window, chunk by chunk.

pub use super::bands::TILE;

use super::bands::Window;
use super::project::{Bounds, DeviceCloud, Stats, View};
use super::scan::Scan;
use crate::gpu::shader::Shader;
use crate::gpu::{Device, Dispatch, Error, Expected, Memory, Recorder, Run, Scratch, Slice};
use crate::{fields, gpu_struct, pass};

/// Large splats of a tile that one workgroup walks; `SEGMENT` in WGSL.
pub const SEGMENT: u32 = 4096;

gpu_struct! {
    /// Push constants: the number of the chunk.
    pub struct TilePush {
        chunk: u32,
    }
}

pass! {
    /// Counts the large splats of each tile, from all pairs of a large splat and a tile that its rectangle meets.
    pub TileCount(TilePush) = "tiles/count" {
        view: Uniform<View>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        pair_offsets: Read<u32>,
        stats: Read<Stats>,
        counts: ReadWrite<u32>,
    }

    /// Stores the large splats of each tile in its list, from the same pairs as `tiles/count`.
    pub TileStore(TilePush) = "tiles/store" {
        view: Uniform<View>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        pair_offsets: Read<u32>,
        stats: Read<Stats>,
        cursors: ReadWrite<u32>,
        entries: ReadWrite<u32>,
    }
}

/// Returns the columns and rows of tiles over a window.
pub fn grid([x0, y0, x1, y1]: Window) -> [u32; 2] {
    [(x1 - x0).div_ceil(TILE), (y1 - y0).div_ceil(TILE)]
}

fields! {
    /// Buffers of tiles, kept from frame to frame.
    pub struct Tiles by device {
        pair_offsets: Scratch<u32> = Scratch::new("tile pair offsets", Memory::Device),
        cursors: Scratch<u32> = Scratch::new("tile cursors", Memory::Device),
        starts: Scratch<u32> = Scratch::new("tile starts", Memory::Device),
        entries: Scratch<u32> = Scratch::new("tile entries", Memory::Device),
        scan: Scan = Scan::new(device, 0)?,
    }
}

impl Tiles {
    /// Returns the number of device bytes that the tiles of these splats take in a window.
    pub fn bytes(stats: &[Stats], window: Window) -> u64 {
        let pairs: u64 = stats.iter().map(Stats::tiles).sum();
        let large = stats.iter().map(|s| u64::from(s.large)).max().unwrap_or(0);
        if large == 0 {
            return 0;
        }
        let tiles = stride(window) * (stats.len() as u64 + 1);
        4 * (pairs + large + tiles) + Scan::bytes(large.max(tiles))
    }

    /// Makes room for these splats (none if the rasterizer visits them). There must be less than 2^32 pairs per chunk.
    pub fn reserve(&mut self, device: &Device, stats: &[Stats], window: Window) -> Result<(), Error> {
        let large = stats.iter().map(|s| u64::from(s.large)).max().unwrap_or(0);
        let any = large > 0;
        let stride = stride(window);
        self.pair_offsets.reserve(device, large.max(1))?;
        self.cursors.reserve(device, if any { stride } else { 1 })?;
        self.starts.reserve(device, if any { stride * stats.len() as u64 } else { 1 })?;
        self.entries.reserve(device, stats.iter().map(|s| aligned(s.tiles())).sum::<u64>().max(1))?;
        let longest = if any { large.max(stride) } else { 0 };
        self.scan.reserve(device, longest)
    }

    /// Records the lists of all tiles, if there are large splats at all.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        cloud: &'a DeviceCloud,
        all: &[Stats],
        window: Window,
    ) -> Result<(), Error> {
        let [columns, rows] = grid(window);
        let len = u64::from(columns) * u64::from(rows) + 1;
        for (chunk, ((first, count), s)) in cloud.chunks().zip(all).enumerate() {
            if s.large == 0 {
                continue;
            }
            let (view, bounds, large) =
                (cloud.view(), cloud.bounds.slice(first, count), cloud.large.slice(first, count));
            let pair_offsets = self.pair_offsets.get().slice(0, u64::from(s.large));
            let cursors = self.cursors.get().slice(0, len);
            let starts = self.starts.get().slice(chunk as u64 * stride(window), len);
            let (stats, push) = (cloud.found(), TilePush { chunk: chunk as u32 });
            let run = Run::new(Dispatch::Invocations(s.tiles()));
            self.scan.record(recorder, cloud.tile_counts.slice(first, u64::from(s.large)), pair_offsets)?;
            recorder.fill("project/clear", cursors, 0)?;
            recorder.run(&TileCount { view, bounds, large, pair_offsets, stats, counts: cursors }, push, &run)?;
            self.scan.record(recorder, cursors, starts)?;
            recorder.copy("tiles/cursors", starts, cursors)?;
            let entries = self.entries_of(all, chunk);
            recorder.run(&TileStore { view, bounds, large, pair_offsets, stats, cursors, entries }, push, &run)?;
            let (ends, next) = (cursors.first(len - 1), starts.skip(1));
            recorder.agree("tiles/store", "tile", ends, Expected::Words(next))?;
        }
        Ok(())
    }

    /// Returns the first entry of each tile of a chunk; a stand-in if the chunk has no large splat or no tiles were
    /// made.
    pub fn starts_of(&self, stats: &[Stats], chunk: usize, window: Window) -> Slice<'_, u32> {
        let end = (chunk as u64 + 1) * stride(window);
        if stats[chunk].large == 0 || self.starts.get().len() < end {
            return self.starts.get().slice(0, 1);
        }
        self.starts.get().slice(chunk as u64 * stride(window), stride(window))
    }

    /// Returns splats of the tiles of a chunk; a stand-in if the chunk has no large splat or no tiles were made.
    pub fn entries_of(&self, stats: &[Stats], chunk: usize) -> Slice<'_, u32> {
        let start: u64 = stats[..chunk].iter().map(|s| aligned(s.tiles())).sum();
        let pairs = stats[chunk].tiles();
        if pairs == 0 || self.entries.get().len() < start + pairs {
            return self.entries.get().slice(0, 1);
        }
        self.entries.get().slice(start, pairs)
    }
}

/// Elements between the starts of two chunks' tiles.
fn stride(window: Window) -> u64 {
    let [columns, rows] = grid(window);
    aligned(u64::from(columns) * u64::from(rows) + 1)
}

/// Elements of four bytes up to the next multiple of every offset alignment.
fn aligned(elements: u64) -> u64 {
    elements.next_multiple_of(64)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::plain::<TileCount>(), Shader::plain::<TileStore>()]
}

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 1] = [("TILE", TILE)];
