//! The passes of binning, and what stages bind that go through ordered tiles.

use crate::passes::compose::ComposingGroup;
use crate::passes::project::{Bounds, View};
use crate::{gpu_struct, group, pass};

gpu_struct! {
    /// Push constants of `bin/keys`.
    pub struct KeysPush {
        count: u32, // Points of the chunk, and the index of its first.
        first: u32,
        nearest: u32, // The number subtracted from depth keys; the key of undrawn splats, less that number.
        none: u32,
    }

    /// Push constants of the passes that meet splats with tiles.
    pub struct TilePush {
        count: u32, // Drawn splats, and how they are cut into runs.
        runs: u32,
        run_length: u32,
        columns: u32, // Tiles of the window in x and y, and of a block.
        rows: u32,
        block_columns: u32,
        block_rows: u32,
        blocks_x: u32, // Blocks in x.
    }

    /// Push constants of the passes that go through a presorted order.
    pub struct PresortedPush {
        count: u32, // Points.
        run_length: u32,
        backward: u32, // 1: the last point comes first.
    }

    /// Push constants of `bin/measure`: tiles, and cells of each.
    pub struct MeasurePush {
        tiles: u32,
        runs: u32, // Cells of a tile in the table of prefix sums.
    }

    /// Run of the tiles' splats that a stage takes: the first member of its push constants;
    /// shaders/shared/tile_run.wgsl explains them.
    pub struct TileWalk {
        columns: u32,
        first_tile: u32,
        tiles: u32,
        runs: u32,
        segment: u32,
        segments: u32,
    }

    /// Push constants of stages that collect fragments.
    pub struct TilesPush {
        walk: TileWalk,
        band_start: u32, // The band of pixels in work, and its first fragment among the window's.
        band_end: u32,
        first_fragment: u32,
    }
}

pass! {
    /// Writes the sort key and index of each point's splat; splats that are not drawn come last. The key is the depth
    /// above the nearest possible one; for `unsorted` the place in the files; nothing where any order does.
    pub Keys(KeysPush) = "bin/keys" {
        splat_depths: Read<f32>,
        bounds: Read<Bounds>,
        points: Read<[u32; 4]>,
        records: ReadWrite<[u32; 2]>,
    }

    /// Counts the drawn points of each run of a presorted order, by one subgroup.
    pub Pick(PresortedPush) = "bin/pick" {
        order: Read<u32>,
        bounds: Read<Bounds>,
        counts: ReadWrite<u32>,
    }

    /// Writes the record of each drawn point of a presorted order to its place among them, over the same runs as
    /// `bin/pick`.
    pub Place(PresortedPush) = "bin/place" {
        order: Read<u32>,
        bounds: Read<Bounds>,
        starts: Read<u32>,
        records: ReadWrite<[u32; 2]>,
    }

    /// Counts the splats of each run in each tile: one increment for each drawn splat and tile that its rectangle
    /// meets. Where pairs of tile and splat are sorted, it counts those of each tile, and the tiles of each splat.
    pub TileCount(TilePush) = "bin/tile-count" in "bin/tile_count" {
        view: Uniform<View>,
        records: Read<[u32; 2]>,
        bounds: Read<Bounds>,
        counts: ReadWrite<u32>,
    }

    /// Stores each splat in the lists of its tiles: one subgroup for each run of splats and block of tiles, in order.
    pub TileStore(TilePush) = "bin/tile-store" in "bin/tile_store" {
        view: Uniform<View>,
        records: Read<[u32; 2]>,
        bounds: Read<Bounds>,
        cursors: ReadWrite<u32>,
        entries: ReadWrite<u32>,
    }

    /// Writes a pair of tile and entry for each drawn splat and tile that its rectangle meets, in the order of splats.
    /// Sorted by tile they are the lists of the tiles, where the device prefers that to `bin/tile-store`.
    pub Pairs(TilePush) = "bin/pairs" {
        view: Uniform<View>,
        records: Read<[u32; 2]>,
        bounds: Read<Bounds>,
        offsets: Read<u32>,
        pairs: ReadWrite<[u32; 2]>,
    }

    /// Finds the longest list of a tile.
    pub Measure(MeasurePush) = "bin/measure" {
        starts: Read<u32>,
        longest: ReadWrite<u32>,
    }
}

group! {
    /// Bindings of a stage that goes through ordered tiles.
    pub Tiled as TiledGroup {
        /// The splats, reached by their indices.
        splats: Shared<ComposingGroup>,
        /// End of each cell's entries; or where each tile's begin.
        ends: Read<u32>,
        /// Indices of the tiles' splats.
        entries: Read<u32>,
        /// Rectangles of pixels, by index.
        bounds: Read<Bounds>,
    }
}
