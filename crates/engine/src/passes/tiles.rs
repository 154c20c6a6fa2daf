//! Large splats by tile: the pairs of a large splat and a tile of 16 × 16 pixels of the window that its rectangle
//! meets, chunk by chunk. They are numbered splat by splat, so that prefix sums of the numbers of tiles say which pair
//! a number is, and no list of them is needed.

pub use super::bands::TILE;

use super::bands::Window;
use super::project::{DeviceCloud, Stats};
use super::scan::Scan;
use crate::fields;
use crate::gpu::{Device, Error, Memory, Recorder, Scratch, Slice};

/// Pairs that a workgroup takes one after another: it searches for the splat of the first alone.
pub const PAIR_RUN: u32 = 8;

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 2] = [("TILE", TILE), ("PAIR_RUN", PAIR_RUN)];

/// Returns the columns and rows of tiles over a window.
pub fn grid([x0, y0, x1, y1]: Window) -> [u32; 2] {
    [(x1 - x0).div_ceil(TILE), (y1 - y0).div_ceil(TILE)]
}

fields! {
    /// Buffers of pairs, kept from frame to frame.
    pub struct Tiles by device {
        pair_offsets: Scratch<u32> = Scratch::new("tile pair offsets", Memory::Device),
        scan: Scan = Scan::new(device, 0)?,
    }
}

impl Tiles {
    /// Returns the number of device bytes that the pairs of these splats take.
    pub fn bytes(stats: &[Stats]) -> u64 {
        4 * elements(stats) + Scan::bytes(most(stats))
    }

    /// Makes room for these splats (none if the rasterizer visits them). There must be less than 2^32 pairs per chunk.
    pub fn reserve(&mut self, device: &Device, stats: &[Stats]) -> Result<(), Error> {
        self.pair_offsets.reserve(device, elements(stats).max(1))?;
        self.scan.reserve(device, most(stats))
    }

    /// Records the prefix sums of all chunks that have large splats.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        cloud: &'a DeviceCloud,
        all: &[Stats],
    ) -> Result<(), Error> {
        for (chunk, ((first, _), s)) in cloud.chunks().zip(all).enumerate().filter(|(_, (_, s))| s.large > 0) {
            let counts = cloud.tile_counts.slice(first, u64::from(s.large));
            self.scan.record(recorder, counts, self.offsets_of(all, chunk))?;
        }
        Ok(())
    }

    /// Returns the first pair of each large splat of a chunk; a stand-in if the chunk has none or no pairs were made.
    pub fn offsets_of(&self, stats: &[Stats], chunk: usize) -> Slice<'_, u32> {
        let (start, large) = (elements(&stats[..chunk]), u64::from(stats[chunk].large));
        if large == 0 || self.pair_offsets.get().len() < start + large {
            return self.pair_offsets.get().slice(0, 1);
        }
        self.pair_offsets.get().slice(start, large)
    }
}

/// Large splats of the chunk with the most.
fn most(stats: &[Stats]) -> u64 {
    stats.iter().map(|s| u64::from(s.large)).max().unwrap_or(0)
}

/// Elements of all chunks, each of which begins at a multiple of every offset alignment.
fn elements(stats: &[Stats]) -> u64 {
    stats.iter().map(|s| u64::from(s.large).next_multiple_of(64)).sum()
}
