//! Binning of the splats of a window: its tiles, and the runs of splats that subgroups take.

use super::passes::{TilePush, TileWalk};
use super::{Job, Lanes, PAIR_BYTES, RECORD_BYTES, SEGMENT, order_bytes, region_segment};
use crate::gpu::{Device, Dispatch};
use crate::passes::Error;
use crate::passes::bands::{Budget, Window};
use crate::passes::compose::Cut;
use crate::passes::foresight::AnswerPlace;
use crate::passes::project::Stats;
use crate::passes::radix::Runs;
use crate::passes::raster::Raster;
use crate::passes::scan::Scan;
use crate::passes::timeline::Timeline;

/// Side of a tile in pixels.
pub(super) const TILE_SIDE: u32 = 16;
/// Side of a block of pixels.
pub(super) const BLOCK_SIDE: u32 = 8;
/// Blocks of a tile.
pub(super) const BLOCKS: u32 = (TILE_SIDE / BLOCK_SIDE).pow(2);
/// Bits of an entry that hold a splat's index; the others say which blocks of its tile the splat's rectangle meets.
pub(super) const INDEX_BITS: u32 = 32 - BLOCKS;
/// Tiles along the side of a block of tiles that one subgroup walks, where splats meet very many.
const WALK_BLOCK: u32 = 32;
/// Most iterations of an invocation that walks tiles: below what one driver allows (65 535).
const MOST_ITERATIONS: u64 = 50_000;
/// Shortest run of splats that a subgroup walks.
pub(super) const SHORTEST_RUN: u64 = 256;
/// Counters of tiles by run that a splat may have on average, if there are more than a few runs.
const COUNTERS_PER_SPLAT: u64 = 4;
/// Runs that there may be however many tiles there are.
const LEAST_RUNS: u64 = 32;
/// Shorter than any run that fills up, whatever the splats' extent.
const LEAST_RUN: u64 = 128;

/// Binning of the drawn splats of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Binning {
    pub(super) drawn: u64,
    /// Way in which stages reach splats.
    pub(super) cut: Cut,
    pub(super) runs: Runs,
    pub(super) columns: u32,
    rows: u32,
    block: [u32; 2],
    /// Most columns and rows of tiles that a splat meets.
    met_tiles: [u32; 2],
    pub(super) lanes: Lanes,
    /// `true` if pairs of tile and splat are sorted: there is one run then.
    pub(super) pairs: bool,
}

impl Binning {
    /// Plans the binning of a window's splats; `None` if it shows none.
    pub(super) fn for_window(device: &Device, job: &Job<'_>) -> Result<Option<Self>, Error> {
        let lanes = Lanes::of(device)?;
        let Raster { stats, window, .. } = job.raster;
        let drawn: u64 = stats.iter().map(|s| u64::from(s.visible)).sum();
        let cut = Cut::of(device, job.raster.cloud, job.raster.footprint)?;
        let prefers = device.info().prefers;
        let binning = || {
            let binning = Self::new(prefers.concurrent_runs, window, drawn, Stats::extent(stats), lanes);
            if prefers.tile_pairs { binning.by_pairs() } else { binning }
        };
        Ok((drawn > 0).then(|| Self { cut, ..binning() }))
    }

    /// Returns the binning by sorted pairs of tile and splat.
    fn by_pairs(self) -> Self {
        Self { runs: Runs { runs: 1, length: self.drawn as u32 }, pairs: true, ..self }
    }

    /// Plans the binning of `drawn` splats, each over at most `extent` columns and rows of pixels.
    fn new(concurrent: u64, window: Window, drawn: u64, extent: [u32; 2], lanes: Lanes) -> Self {
        let subgroup = lanes.subgroup;
        let [columns, rows] =
            [(window[2] - window[0]).div_ceil(TILE_SIDE), (window[3] - window[1]).div_ceil(TILE_SIDE)];
        // A span of n pixels meets at most this many tiles.
        let span = extent.map(|n| n.saturating_sub(1) / TILE_SIDE + 2);
        let met_tiles = [span[0].min(columns), span[1].min(rows)];
        let walk = [WALK_BLOCK; 2];
        let block = if steps(met_tiles, subgroup) > steps(walk, subgroup) { walk } else { [columns, rows] };
        let most = steps([met_tiles[0].min(block[0]), met_tiles[1].min(block[1])], subgroup);
        let longest = MOST_ITERATIONS / (most + 2);
        // Each run has a counter of each tile: more of them than a few for each splat would cost more than they help.
        let affordable = COUNTERS_PER_SPLAT * drawn / (u64::from(columns) * u64::from(rows)).max(1);
        let runs = Runs::new(concurrent.min(affordable.max(LEAST_RUNS)), drawn, SHORTEST_RUN.min(longest), longest);
        Self { drawn, cut: Cut::WHOLE, runs, columns, rows, block, met_tiles, lanes, pairs: false }
    }

    pub(super) fn tiles(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// Counters: one for each tile and run, and one more, whose prefix sum is the total. Where pairs are sorted, those
    /// of the splats lie behind them.
    pub(super) fn cells(&self) -> u64 {
        self.total() + 1 + if self.pairs { self.drawn } else { 0 }
    }

    /// Place of the total number of entries among the prefix sums of the counters.
    pub(super) fn total(&self) -> u64 {
        self.tiles() * u64::from(self.runs.runs)
    }

    /// Bits of a tile's number. What is no pair has all of them, and comes last in the order of the pairs before.
    pub(super) fn tile_bits(&self) -> u32 {
        (u32::BITS - (self.tiles() as u32 - 1).leading_zeros()).max(1)
    }

    pub(super) fn push(&self) -> TilePush {
        TilePush {
            count: self.drawn as u32,
            runs: self.runs.runs,
            run_length: self.runs.length,
            columns: self.columns,
            rows: self.rows,
            block_columns: self.block[0],
            block_rows: self.block[1],
            blocks_x: self.columns.div_ceil(self.block[0]),
        }
    }

    /// Subgroups of `bin/tile-store`: one for each run and block.
    pub(super) fn groups(&self) -> u64 {
        let blocks = self.columns.div_ceil(self.block[0]) * self.rows.div_ceil(self.block[1]);
        u64::from(self.runs.runs) * u64::from(blocks)
    }

    /// Returns how many entries of the tiles there is room for; `None` if the window must be cut.
    pub(super) fn left(&self, device: &Device, job: &Job<'_>) -> Result<Option<u64>, Error> {
        let (points, binding) = (job.raster.cloud.len(), device.limits().binding_bytes);
        let most = self.lanes.most_points(device);
        if points > most {
            return Err(Error::TooManyPoints { points, limit: most });
        }
        let splats = |drawn: u64| order_bytes(device, job.order, points, drawn);
        let table = |cells: u64| cells * 8 + Scan::bytes(cells);
        let [entry, bound] = if self.pairs { [PAIR_BYTES, RECORD_BYTES] } else { [4, 4] };
        // However small the window, there is a tile with all of its splats.
        let cells = |drawn: u64| if self.pairs { drawn } else { drawn / LEAST_RUN };
        let least = |drawn: u64| splats(drawn) + table(cells(drawn) + 2) + drawn * entry;
        let available = job.budget.left(job.counted_bytes);
        if least(self.drawn) > available {
            // A larger budget makes larger windows, with up to all splats in each.
            let needed = least(points);
            return Err(Error::SortOverBudget { points, needed, available, budget: Budget::wanted(needed) });
        }
        let cells = self.cells();
        let used = splats(self.drawn) + table(cells);
        // `bin/tile-count` visits the tiles of a splat one by one.
        let met = u64::from(self.met_tiles[0]) * u64::from(self.met_tiles[1]);
        let fits = cells * 4 <= binding && met <= MOST_ITERATIONS;
        Ok((fits && used <= available).then(|| ((available - used) / entry).min(binding / bound)))
    }
}

/// A window whose splats are binned.
#[derive(Debug, Clone, Copy)]
pub struct Binned {
    pub(super) binning: Binning,
    /// Index of the buffer of records that holds the sorted ones.
    pub(super) records: usize,
    /// Splats of the tile with most of them, at most.
    pub(super) longest: u32,
    /// Entries of all tiles, at most.
    pub(super) entries: u32,
    /// Place of the counts: overflow, pairs of splat and tile, splats of the tile with most of them.
    pub(super) counts: AnswerPlace,
}

impl Binned {
    /// Returns the part `segment` of each tile's splats, of all tiles.
    pub fn walk(&self, segment: u32, segments: u32) -> TileWalk {
        TileWalk {
            columns: self.binning.columns,
            first_tile: 0,
            tiles: self.tiles(),
            runs: if self.binning.pairs { 0 } else { self.binning.runs.runs },
            segment,
            segments,
        }
    }

    /// Returns the number of tiles of the window.
    pub fn tiles(&self) -> u32 {
        self.binning.tiles() as u32
    }

    /// Returns a dispatch with a subgroup for each tile.
    pub fn over_tiles(&self) -> Dispatch<'static> {
        Dispatch::Groups(self.lanes().groups(self.binning.tiles()))
    }

    /// Returns a dispatch with a subgroup for each block of each tile.
    pub fn over_blocks(&self) -> Dispatch<'static> {
        Dispatch::Groups(self.lanes().groups(self.binning.tiles() * u64::from(BLOCKS)))
    }

    /// Counters of the tiles' splats by run; where pairs are sorted, of tiles and of splats.
    pub fn cells(&self) -> u64 {
        self.binning.cells()
    }

    /// Returns the number of pairs of a splat and a tile that it meets, once they were submitted.
    pub fn found_entries(&self, timeline: &Timeline) -> u64 {
        timeline.found(self.counts)[1].into()
    }

    /// Returns the way in which stages reach splats by their indices.
    pub fn cut(&self) -> Cut {
        self.binning.cut
    }

    /// Returns the invocations of stages that go through the tiles.
    pub fn lanes(&self) -> Lanes {
        self.binning.lanes
    }

    /// Runs over all tiles that it takes to get through the longest list.
    pub fn segments(&self) -> u32 {
        self.longest.div_ceil(SEGMENT).max(1)
    }

    /// Returns the same for stages that go through tiles region by region.
    pub fn region_segments(&self) -> u32 {
        self.longest.div_ceil(region_segment(self.lanes().subgroup)).max(1)
    }
}

/// Steps in which a subgroup walks so many columns and rows of tiles.
fn steps(tiles: [u32; 2], subgroup: u32) -> u64 {
    let [columns, rows] = pattern(subgroup);
    u64::from(tiles[0].div_ceil(columns)) * u64::from(tiles[1].div_ceil(rows))
}

/// Returns the columns and rows of the pattern of tiles that the invocations of a subgroup own.
pub(super) fn pattern(subgroup: u32) -> [u32; 2] {
    let columns = match subgroup {
        32 => 8,
        8.. => 4,
        _ => 2,
    };
    [columns, subgroup / columns]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most iterations of an invocation of `bin/tile-store`, by the loops as they stand in the shader.
    fn iterations(binning: &Binning) -> u64 {
        let [columns, rows] = binning.block.map(u64::from);
        // In the worst case each splat meets as many of a block's tiles as any splat meets at all.
        let [lane_columns, lane_rows] = pattern(binning.lanes.subgroup).map(u64::from);
        let most = binning.met_tiles.map(u64::from);
        let walked = most[0].min(columns).div_ceil(lane_columns) * most[1].min(rows).div_ceil(lane_rows);
        let length = u64::from(binning.runs.length);
        length * (walked + 1) + length.div_ceil(u64::from(binning.lanes.subgroup))
    }

    #[test]
    fn no_invocation_loops_longer_than_drivers_allow() {
        let sides = [1, 15, 16, 17, 31, 512, 513, 1920, 4096, 16_384];
        let mut longest = 0;
        for subgroup in [4, 8, 16, 32] {
            for (width, height) in sides.iter().flat_map(|w| sides.map(|h| (*w, h))) {
                for (x, y) in sides.iter().flat_map(|x| sides.map(|y| (*x.min(&width), y.min(height)))) {
                    for drawn in [1, 255, 100_000, 30_000_000] {
                        for concurrent in [32, 4096] {
                            let window = [3, 5, 3 + width, 5 + height];
                            let binning = Binning::new(concurrent, window, drawn, [x, y], Lanes { subgroup, team: 1 });
                            let Runs { runs, length } = binning.runs;
                            assert!(u64::from(runs) * u64::from(length) >= drawn, "every splat: {binning:?}");
                            assert!(drawn > u64::from(runs - 1) * u64::from(length), "no empty run: {binning:?}");
                            assert!(u64::from(runs) <= drawn / LEAST_RUN + 1, "as memory is counted: {binning:?}");
                            longest = longest.max(iterations(&binning));
                        }
                    }
                }
            }
        }
        assert!((MOST_ITERATIONS / 2..60_000).contains(&longest), "{longest}");
        // Blending: up to four blocks of every splat, and the steps.
        for subgroup in [4, 8, 16, 32] {
            assert!(SEGMENT * 4 + SEGMENT / subgroup < 60_000);
            // Block by block: the steps to pick splats; then every splat and the steps, for each of the block's
            // regions.
            let taken = region_segment(subgroup);
            let steps = taken.div_ceil(subgroup);
            assert!(steps + (taken + steps + 1) * (BLOCK_SIDE.pow(2) / subgroup) < 60_000);
        }
    }

    /// Every window and number of splats with every device: windows from one tile to a million of them.
    fn all_binnings() -> Vec<(u64, Binning)> {
        let mut all = Vec::new();
        for side in [1, 16, 17, 512, 1920, 4096, 16_384] {
            for (drawn, extent) in [1, 31, 255, 8192, 100_000, 30_000_000, 1 << 28]
                .iter()
                .flat_map(|drawn| [1, 16, 700].map(|n| (*drawn, n)))
            {
                for (concurrent, subgroup) in [1, 32, 4096].iter().flat_map(|runs| [4, 32].map(|size| (*runs, size))) {
                    let extent = [extent.min(side); 2];
                    all.push((
                        concurrent,
                        Binning::new(concurrent, [0, 0, side, side], drawn, extent, Lanes { subgroup, team: 1 }),
                    ));
                }
            }
        }
        all
    }

    #[test]
    fn counters_are_a_few_for_each_splat_or_those_of_a_few_runs() {
        let mut cut = 0;
        for (concurrent, binning) in all_binnings() {
            let (tiles, drawn, runs) = (binning.tiles(), binning.drawn, u64::from(binning.runs.runs));
            assert_eq!(binning.cells(), tiles * runs + 1, "{binning:?}");
            let most = (COUNTERS_PER_SPLAT * drawn).max(LEAST_RUNS * tiles);
            // Runs that an invocation would loop over too long are cut into more.
            let is_full = iterations(&binning) > MOST_ITERATIONS / 2;
            assert!(tiles * runs <= most || is_full, "{tiles} × {runs} counters, {most}: {binning:?}");
            assert!(runs <= concurrent || is_full, "no more than the device runs at once, {concurrent}: {binning:?}");
            let wanted = u64::from(Runs::new(concurrent, drawn, SHORTEST_RUN, drawn.max(SHORTEST_RUN)).runs);
            assert!(runs >= wanted.min(LEAST_RUNS), "however many tiles, {wanted} wanted: {binning:?}");
            if tiles * wanted <= most {
                assert!(runs >= wanted, "as many as keep the device busy, {wanted}: {binning:?}");
            } else {
                cut += 1;
            }
        }
        assert!(cut > 0, "some are cut off");
    }

    #[test]
    fn a_splat_never_meets_more_tiles_than_binning_expects() {
        for extent in 1..=70u32 {
            let met = Binning::new(32, [0, 0, 1600, 1600], 1, [extent; 2], Lanes { subgroup: 8, team: 1 }).met_tiles[0];
            let tiles = |first: u32| (first + extent - 1) / TILE_SIDE - first / TILE_SIDE + 1;
            assert!((0..TILE_SIDE).all(|first| tiles(first) <= met), "{extent}");
            assert!((0..TILE_SIDE).any(|first| tiles(first) + 1 >= met), "{extent}: at most one too many");
        }
    }

    #[test]
    fn where_pairs_are_sorted_each_tile_and_each_splat_has_a_counter() {
        for (_, binning) in all_binnings() {
            let (tiles, pairs) = (binning.tiles(), binning.by_pairs());
            assert_eq!((pairs.cells(), pairs.total()), (tiles + 1 + binning.drawn, tiles), "{pairs:?}");
            // One run: `bin/tile-count` and `bin/measure` then count tiles.
            assert_eq!((pairs.push().runs, u64::from(pairs.push().run_length)), (1, binning.drawn));
        }
    }

    #[test]
    fn tile_numbers_have_as_few_bits_as_tell_them_apart() {
        let bits =
            |side: u32| Binning::new(32, [0, 0, side, 16], 1, [1; 2], Lanes { subgroup: 8, team: 1 }).tile_bits();
        assert_eq!([1, 16, 17, 32, 33, 64, 65, 4096, 4097].map(bits), [1, 1, 1, 1, 2, 2, 3, 8, 9]);
    }

    #[test]
    fn patterns_of_tiles_fill_a_subgroup() {
        assert_eq!([4, 8, 16, 32].map(pattern), [[2, 2], [4, 2], [4, 4], [8, 4]]);
    }
}
