//! Binning: the drawn splats of a window put into an order, and into a list for each 16 × 16 tile that their rectangles meet,
//! in that order. Stages that go through the lists have their pixels for themselves, and need no atomics.
//!
//! The sort is stable and points come in canonical order, so that the lists follow from the points alone.

use super::Error;
use super::bands::{self, Band, Budget, Window};
use super::compose::{self, Composing, ComposingGroup, Cut};
use super::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, View};
use super::radix::{Radix, Runs};
use super::raster::Raster;
use super::scan::Scan;
use super::timeline::Timeline;
use crate::gpu::shader::{SUBGROUPS, Shader};
use crate::gpu::{Buffer, Device, Dispatch, Expected, Kept, Memory, Pass, Recorder, Run, Slice, Variant};
use crate::prepare::axes::Axis;
use crate::scene::Falloff;
use crate::{gpu_struct, group, pass};

/// The order of splats in tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// By the depth of their centres, then by index: that of blending, front to back.
    #[default]
    Depth,
    /// By index: the canonical one, which costs no sort to speak of.
    Index,
    /// As they stand in the files, the last one first: over-blending front to back.
    File,
    /// Along an axis of the world, in an order that the cloud brings ([`DeviceCloud::sort_along`]): nothing is sorted.
    Along(Axis),
}

gpu_struct! {
    /// Push constants of `bin/keys`; the shader says what the members are.
    pub struct KeysPush {
        count: u32,
        first: u32,
        nearest: u32,
        none: u32,
    }
}

gpu_struct! {
    /// Push constants of the passes that meet splats with tiles; shaders/shared/tile_push.wgsl says what the members are.
    pub struct TilePush {
        count: u32,
        runs: u32,
        run_length: u32,
        columns: u32,
        rows: u32,
        block_columns: u32,
        block_rows: u32,
        blocks_x: u32,
    }
}

pass! {
    /// Writes the sort key and index of each point's splat; splats that are not drawn come last. The key is the depth
    /// above the nearest possible one; for `unsorted` the place in the files; nothing where any order does.
    pub Keys(KeysPush) = "bin/keys" {
        splats: Read<Splat>,
        bounds: Read<Bounds>,
        points: Read<[u32; 4]>,
        records: ReadWrite<[u32; 2]>,
    }
}

gpu_struct! {
    /// Push constants of `bin/gather`: drawn splats, and the key of the nearest depth.
    pub struct GatherPush {
        count: u32,
        nearest: u32,
    }
}

pass! {
    /// Copies depth, footprint, color, tilt and rectangle of each drawn splat to its place in the order.
    pub Gather(GatherPush) = "bin/gather" {
        composing: Shared<ComposingGroup>,
        bounds: Read<Bounds>,
        records: ReadWrite<[u32; 2]>,
        footprints: ReadWrite<[u32; 4]>,
        colors: ReadWrite<[f32; 4]>,
        slopes: ReadWrite<[f32; 4]>,
        rectangles: ReadWrite<[u32; 2]>,
    }
}

gpu_struct! {
    /// Push constants of the passes that go through a presorted order; shaders/shared/presorted.wgsl says what the members are.
    pub struct PresortedPush {
        count: u32,
        run_length: u32,
        backward: u32,
    }
}

pass! {
    /// Counts the drawn points of each run of a presorted order, by one subgroup.
    pub Pick(PresortedPush) = "bin/pick" {
        order: Read<u32>,
        bounds: Read<Bounds>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Writes the record of each drawn point of a presorted order to its place among them, over the same runs as
    /// `bin/pick`.
    pub Place(PresortedPush) = "bin/place" {
        order: Read<u32>,
        bounds: Read<Bounds>,
        starts: Read<u32>,
        records: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Counts the splats of each run in each tile: one increment for each drawn splat and tile that its rectangle meets.
    pub TileCount(TilePush) = "bin/tile-count" in "bin/tile_count" {
        view: Uniform<View>,
        rectangles: Read<[u32; 2]>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Stores each splat in the lists of its tiles: one subgroup for each run of splats and block of tiles, in order.
    pub TileStore(TilePush) = "bin/tile-store" in "bin/tile_store" {
        view: Uniform<View>,
        rectangles: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        entries: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Push constants of `bin/measure`: tiles, and cells of each.
    pub struct MeasurePush {
        tiles: u32,
        runs: u32,
    }
}

pass! {
    /// Finds the longest list of a tile.
    pub Measure(MeasurePush) = "bin/measure" {
        starts: Read<u32>,
        longest: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Which run a stage takes of the tiles' splats: the first member of its push constants; shaders/shared/tile_run.wgsl says
    /// what the members are.
    pub struct TileWalk {
        columns: u32,
        first_tile: u32,
        tiles: u32,
        runs: u32,
        nearest: u32,
        segment: u32,
    }
}

gpu_struct! {
    /// Push constants of stages that collect fragments; shaders/shared/tile_gather.wgsl says what the members are.
    pub struct TilesPush {
        walk: TileWalk,
        band_start: u32,
        band_end: u32,
        first_fragment: u32,
    }
}

group! {
    /// What a stage binds that goes through ordered tiles.
    pub Gathering as GatheringGroup {
        /// The camera.
        view: Uniform<View>,
        /// Where each cell's entries end.
        ends: Read<u32>,
        /// Ranks of the tiles' splats.
        entries: Read<u32>,
        /// Place, pixel and radius, by rank.
        footprints: Read<[u32; 4]>,
    }
}

group! {
    /// What a stage binds that goes through tiles with whole splats.
    pub Folding as FoldingGroup {
        /// The camera.
        view: Uniform<View>,
        /// Where each cell's entries end.
        ends: Read<u32>,
        /// Ranks of the tiles' splats.
        entries: Read<u32>,
        /// Relative depth key and index, by rank.
        records: Read<[u32; 2]>,
        /// Place, pixel and radius, by rank.
        footprints: Read<[u32; 4]>,
        /// Colors as blended, and opacities, by rank.
        colors: Read<[f32; 4]>,
        /// Tilts, by rank.
        slopes: Read<[f32; 4]>,
    }
}

/// Device bytes per pixel of a window that do not depend on the splats: the table of tiles is made to fit what is left.
pub const PIXEL_BYTES: u64 = 4;
/// Side of a tile in pixels.
const TILE_SIDE: u32 = 16;
/// Side of a block of pixels.
const BLOCK_SIDE: u32 = 8;
/// Blocks of a tile.
const BLOCKS: u32 = (TILE_SIDE / BLOCK_SIDE).pow(2);
/// Tiles along the side of a block of tiles that one subgroup walks, where splats meet very many.
const WALK_BLOCK: u32 = 32;
/// Most iterations of an invocation that walks tiles: below what one driver allows (65 535).
const MOST_ITERATIONS: u64 = 50_000;
/// Splats of a tile that one run takes, at five iterations each. Runs are composed by themselves and then joined, so that
/// the smallest opacities don't round away in a sum of millions.
const SEGMENT: u32 = 2048;
/// Bytes of a record of the sort: key and index.
pub const RECORD_BYTES: u64 = 8;
/// Shortest run of splats that a subgroup walks.
const SHORTEST_RUN: u64 = 256;
/// Shorter than any run that fills up, whatever the splats' extent.
const LEAST_RUN: u64 = 128;

/// What is binned.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The projected cloud; its walker is not used.
    pub raster: Raster<'a>,
    /// In which order.
    pub order: Order,
    /// Near and far.
    pub depth_range: [f32; 2],
    /// The memory that may be used.
    pub budget: Budget,
    /// Bytes of it that are in use for something else.
    pub counted_bytes: u64,
}

/// Buffers, kept from frame to frame.
pub struct Bins {
    radix: Radix,
    records: [Kept<[u32; 2]>; 2],
    footprints: Kept<[u32; 4]>,
    colors: Kept<[f32; 4]>,
    slopes: Kept<[f32; 4]>,
    rectangles: Kept<[u32; 2]>,
    counts: Kept<u32>,
    cursors: Kept<u32>,
    scan: Option<Scan>,
    overflow: Buffer<u32>,
    longest: Buffer<u32>,
    summary: Buffer<u32>,
    entries: Kept<u32>,
}

/// How the drawn splats of a window are binned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Binning {
    drawn: u64,
    runs: Runs,
    columns: u32,
    rows: u32,
    block: [u32; 2],
    /// Most columns and rows of tiles that a splat meets.
    met_tiles: [u32; 2],
    subgroup: u32,
}

/// A window whose splats are binned.
#[derive(Debug, Clone, Copy)]
pub struct Binned {
    binning: Binning,
    /// Which of the buffers of records holds the sorted ones.
    records: usize,
    /// Key of the nearest depth.
    pub nearest: u32,
    /// Pairs of splat and tile.
    entries: u32,
    /// Splats of the tile with most of them.
    longest: u32,
}

impl Binned {
    /// The part `segment` of each tile's splats, of all tiles.
    pub fn walk(&self, segment: u32) -> TileWalk {
        TileWalk {
            columns: self.binning.columns,
            first_tile: 0,
            tiles: self.tiles(),
            runs: self.binning.runs.runs,
            nearest: self.nearest,
            segment,
        }
    }

    /// Tiles of the window.
    pub fn tiles(&self) -> u32 {
        self.binning.tiles() as u32
    }

    /// Blocks of all tiles.
    pub fn blocks(&self) -> u64 {
        self.binning.tiles() * u64::from(BLOCKS)
    }

    /// Counters of the tiles' splats by run.
    pub fn cells(&self) -> u64 {
        self.binning.cells()
    }

    /// Pairs of a splat and a tile that it meets.
    pub fn entries(&self) -> u64 {
        self.entries.into()
    }

    /// The subgroup size of stages that go through the tiles.
    pub fn subgroup(&self) -> u32 {
        self.binning.subgroup
    }

    /// Runs over all tiles that it takes to get through the longest list.
    pub fn segments(&self) -> u32 {
        self.longest.div_ceil(SEGMENT).max(1)
    }
}

/// What became of a window that was to be binned.
#[derive(Debug, Clone, Copy)]
pub enum Bin {
    /// No splat is drawn.
    Nothing,
    /// The tiles take too much memory: the window must be cut.
    TooLarge,
    /// It is binned.
    Done(Binned),
}

/// What would become of a window that was to be binned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Survey {
    /// No splat is drawn.
    Nothing,
    /// The tiles take too much memory: the window must be cut.
    TooLarge,
    /// It would be binned with so many counters of the tiles' splats by run.
    Cells(u64),
}

/// Tiles with their splats in order.
#[derive(Clone, Copy)]
pub struct OrderedTiles<'a> {
    /// How they were made.
    pub binned: Binned,
    ends: Slice<'a, u32>,
    entries: Slice<'a, u32>,
    /// Depth key less [`Binned::nearest`], and index of the splat, by rank.
    pub records: Slice<'a, [u32; 2]>,
    /// Fractions, pixel and radius, by rank.
    pub footprints: Slice<'a, [u32; 4]>,
    /// Colors as blended, and opacities, by rank.
    pub colors: Slice<'a, [f32; 4]>,
    /// Tilts by rank; a single element unless the cloud has normals.
    pub slopes: Slice<'a, [f32; 4]>,
    /// Rectangles of pixels, by rank.
    pub rectangles: Slice<'a, Bounds>,
}

impl<'a> OrderedTiles<'a> {
    /// What a stage binds that goes through the tiles with whole splats (shaders/shared/tile_fold.wgsl).
    pub fn folding(&self, view: Slice<'a, View>) -> Folding<'a> {
        let Self { ends, entries, records, footprints, colors, slopes, .. } = *self;
        Folding { view, ends, entries, records, footprints, colors, slopes }
    }

    /// Records a stage that collects the fragments of a band's pixels.
    pub fn record<P: Pass<Push = TilesPush> + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        view: Slice<'a, View>,
        window: Window,
        band: &Band,
        stage: impl Fn(Gathering<'a>) -> P,
    ) -> Result<(), Error> {
        let Self { binned, ends, entries, footprints, .. } = *self;
        let binning = binned.binning;
        let pass = stage(Gathering { view, ends, entries, footprints });
        let row = |pixel: u32| pixel / (window[2] - window[0]) / TILE_SIDE;
        let (first, last) = (row(band.pixels[0]), row(band.pixels[1].max(1) - 1));
        let tiles = (last - first + 1) * binning.columns;
        for segment in 0..binned.segments() {
            let push = TilesPush {
                walk: TileWalk { first_tile: first * binning.columns, tiles, ..binned.walk(segment) },
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
            };
            let run = Run::new(Dispatch::Groups(tiles.into())).variant(gather_variant(binning.subgroup));
            recorder.run(&pass, push, &run)?;
        }
        Ok(())
    }
}

impl Binning {
    /// Of what a window shows; `None` if that is nothing.
    fn of(device: &Device, job: &Job<'_>) -> Result<Option<Self>, Error> {
        let info = device.info();
        let subgroup = info.subgroup.ok_or_else(|| Error::NoSubgroups { device: info.name.clone() })?;
        let Raster { stats, window, .. } = job.raster;
        let drawn: u64 = stats.iter().map(|s| u64::from(s.visible)).sum();
        let binning = || Self::new(info.concurrent_runs, window, drawn, Stats::extent(stats), subgroup);
        Ok((drawn > 0).then(binning))
    }

    /// `drawn` splats, each over at most `extent` columns and rows of pixels.
    fn new(concurrent: u64, window: Window, drawn: u64, extent: [u32; 2], subgroup: u32) -> Self {
        let [columns, rows] =
            [(window[2] - window[0]).div_ceil(TILE_SIDE), (window[3] - window[1]).div_ceil(TILE_SIDE)];
        // A span of n pixels meets at most this many tiles.
        let span = extent.map(|n| n.saturating_sub(1) / TILE_SIDE + 2);
        let met_tiles = [span[0].min(columns), span[1].min(rows)];
        let walk = [WALK_BLOCK; 2];
        let block = if steps(met_tiles, subgroup) > steps(walk, subgroup) { walk } else { [columns, rows] };
        let most = steps([met_tiles[0].min(block[0]), met_tiles[1].min(block[1])], subgroup);
        let longest = MOST_ITERATIONS / (most + 2);
        let runs = Runs::new(concurrent, drawn, SHORTEST_RUN.min(longest), longest);
        Self { drawn, runs, columns, rows, block, met_tiles, subgroup }
    }

    fn tiles(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// Counters: one for each tile and run, and one more, whose prefix sum is the total.
    fn cells(&self) -> u64 {
        self.tiles() * u64::from(self.runs.runs) + 1
    }

    fn push(&self) -> TilePush {
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
    fn groups(&self) -> u64 {
        let blocks = self.columns.div_ceil(self.block[0]) * self.rows.div_ceil(self.block[1]);
        u64::from(self.runs.runs) * u64::from(blocks)
    }

    /// Bytes left for the tiles' entries; `None` if the window must be cut.
    fn left(&self, device: &Device, job: &Job<'_>) -> Result<Option<u64>, Error> {
        let (points, binding) = (job.raster.cloud.len(), device.limits().binding_bytes);
        if points * RECORD_BYTES > binding {
            return Err(Error::TooManyPoints { points, limit: binding / RECORD_BYTES });
        }
        let each = splat_bytes(job.raster.cloud);
        let splats = |drawn: u64| order_bytes(device, job.order, points, drawn) + drawn * each;
        let table = |cells: u64| cells * 8 + Scan::bytes(cells);
        // However small the window, there is a tile with all of its splats.
        let least = |drawn: u64| splats(drawn) + table(drawn / LEAST_RUN + 2) + drawn * 4;
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
        let fits = cells * 4 <= binding && self.drawn * 16 <= binding && met <= MOST_ITERATIONS;
        if !fits && bands::pixels(job.raster.window) == 1 {
            return Err(Error::TooManyPoints { points: self.drawn, limit: binding / 16 });
        }
        Ok((fits && used <= available).then(|| (available - used).min(binding)))
    }
}

/// Steps in which a subgroup walks so many columns and rows of tiles.
fn steps(tiles: [u32; 2], subgroup: u32) -> u64 {
    let [columns, rows] = pattern(subgroup);
    u64::from(tiles[0].div_ceil(columns)) * u64::from(tiles[1].div_ceil(rows))
}

/// Columns and rows of the pattern of tiles that the invocations of a subgroup own.
fn pattern(subgroup: u32) -> [u32; 2] {
    let columns = match subgroup {
        32 => 8,
        8.. => 4,
        _ => 2,
    };
    [columns, subgroup / columns]
}

impl Bins {
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let records = |name| Kept::new(name, Memory::Device);
        Ok(Self {
            radix: Radix::new(device)?,
            records: [records("sort records"), records("sort records, moved")],
            footprints: Kept::new("ordered footprints", Memory::Device),
            colors: Kept::new("ordered colors", Memory::Device),
            slopes: Kept::new("ordered tilts", Memory::Device),
            rectangles: Kept::new("ordered rectangles", Memory::Device),
            counts: Kept::new("tile counts by run", Memory::Device),
            cursors: Kept::new("tile cursors by run", Memory::Device),
            scan: None,
            overflow: device.buffer("scan overflow", 1, Memory::Device)?,
            longest: device.buffer("longest tile list", 1, Memory::Device)?,
            summary: device.buffer("tile summary", 3, Memory::Readback)?,
            entries: Kept::new("ordered tile entries", Memory::Device),
        })
    }

    /// Sorts and bins a window's splats for stages that go through its tiles ([`Self::tiles`]).
    pub fn bin(&mut self, device: &Device, job: &Job<'_>, timeline: &mut Timeline) -> Result<Bin, Error> {
        let Some(binning) = Binning::of(device, job)? else { return Ok(Bin::Nothing) };
        let Some(binned) = self.sort_and_count(device, job, binning, timeline)? else { return Ok(Bin::TooLarge) };
        let mut recorder = device.recorder()?;
        self.record_tile_store(&mut recorder, job, &binning)?;
        timeline.submit(recorder, "bin/tile-store")?;
        Ok(Bin::Done(binned))
    }

    /// Sorts a window's splats and counts those of each tile; `None` if the window must be cut.
    fn sort_and_count(
        &mut self,
        device: &Device,
        job: &Job<'_>,
        binning: Binning,
        timeline: &mut Timeline,
    ) -> Result<Option<Binned>, Error> {
        let Some(left) = binning.left(device, job)? else { return Ok(None) };
        self.reserve(device, job, &binning)?;
        let mut recorder = device.recorder()?;
        let last = match job.order {
            Order::Along(axis) => self.record_pick(&mut recorder, device, job, axis, binning.subgroup)?,
            _ => self.record_sort(&mut recorder, device, job, binning.subgroup)?,
        };
        self.record_gather(&mut recorder, device, job, binning.drawn, self.records[last].get().all())?;
        self.record_tile_count(&mut recorder, job, &binning)?;
        timeline.submit(recorder, "bin/sort and count")?;
        let words = self.summary.mapped_slice();
        let [overflow, entries, longest] = [words[0], words[1], words[2]];
        if overflow != 0 || u64::from(entries) * 4 > left {
            return Ok(None);
        }
        self.entries.reserve_within(device, u64::from(entries).max(1), left / 4)?;
        Ok(Some(Binned { binning, records: last, nearest: depth_keys(job.depth_range)[0], entries, longest }))
    }

    /// A binned window's tiles, for stages that go through them.
    pub fn tiles(&self, binned: Binned) -> OrderedTiles<'_> {
        OrderedTiles {
            binned,
            ends: self.cursors.get().slice(0, binned.binning.cells()),
            entries: self.entries.get().all(),
            records: self.records[binned.records].get().all(),
            footprints: self.footprints.get().all(),
            colors: self.colors.get().all(),
            slopes: self.slopes.get().all(),
            rectangles: self.rectangles.get().all(),
        }
    }

    /// Device bytes that sorting a window's splats takes, tiles not counted.
    pub fn least_bytes(device: &Device, job: &Job<'_>) -> u64 {
        let (cloud, drawn) = (job.raster.cloud, job.raster.stats.iter().map(|s| u64::from(s.visible)).sum::<u64>());
        order_bytes(device, job.order, cloud.len(), drawn) + drawn * splat_bytes(cloud)
    }

    /// The same where every point is drawn.
    pub fn most_bytes(device: &Device, cloud: &DeviceCloud) -> u64 {
        sort_bytes(device, cloud.len()) + cloud.len() * splat_bytes(cloud)
    }

    /// Device bytes of the buffers that hold a binned window.
    pub fn bytes(&self) -> u64 {
        let records: u64 = self.records.iter().map(|r| r.bytes()).sum();
        let splats = self.footprints.bytes() + self.colors.bytes() + self.slopes.bytes() + self.rectangles.bytes();
        let tiles = self.counts.bytes() + self.cursors.bytes() + self.entries.bytes();
        let scan = self.scan.as_ref().map_or(0, |s| Scan::bytes(s.capacity()));
        records + splats + tiles + scan + self.radix.kept_bytes()
    }

    /// Decides how a window is binned; sorts nothing.
    pub fn survey(device: &Device, job: &Job<'_>) -> Result<Survey, Error> {
        let Some(binning) = Binning::of(device, job)? else { return Ok(Survey::Nothing) };
        Ok(binning.left(device, job)?.map_or(Survey::TooLarge, |_| Survey::Cells(binning.cells())))
    }

    fn reserve(&mut self, device: &Device, job: &Job<'_>, binning: &Binning) -> Result<(), Error> {
        let points = job.raster.cloud.len();
        let picked = if let Order::Along(_) = job.order {
            self.records[0].reserve(device, binning.drawn)?;
            u64::from(order_runs(device, points).runs)
        } else {
            for records in &mut self.records {
                records.reserve(device, points)?;
            }
            self.radix.reserve(device, points)?;
            0
        };
        self.footprints.reserve(device, binning.drawn)?;
        self.colors.reserve(device, binning.drawn)?;
        self.slopes.reserve(device, if job.raster.cloud.has_normals() { binning.drawn } else { 1 })?;
        self.rectangles.reserve(device, binning.drawn)?;
        // The counters of a presorted order's runs are done with before those of tiles.
        let cells = binning.cells().max(picked);
        self.counts.reserve(device, cells)?;
        self.cursors.reserve(device, cells)?;
        // A smaller one is freed before a larger one is made.
        self.scan = self.scan.take().filter(|s| s.capacity() >= cells);
        if self.scan.is_none() {
            self.scan = Some(Scan::new(device, cells)?);
        }
        Ok(())
    }

    /// Records keys and sort; returns which of the records are the sorted ones.
    fn record_sort<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &Job<'a>,
        subgroup: u32,
    ) -> Result<usize, Error> {
        let cloud = job.raster.cloud;
        let records = self.records.each_ref().map(|r| r.get().slice(0, cloud.len()));
        let ([nearest, none], bits) =
            (keys(job.order, job.depth_range, cloud.len()), key_bits(job.order, job.depth_range, cloud.len()));
        for (first, count) in cloud.chunks() {
            let push = KeysPush { count: count as u32, first: first as u32, nearest, none };
            let (splats, bounds) = (cloud.splats.slice(first, count), cloud.bounds.slice(first, count));
            let points = cloud.point_colors.slice(first, count).cast();
            let run = Run::new(Dispatch::Invocations(count)).variant(keys_variant(job.order));
            recorder.run(&Keys { splats, bounds, points, records: records[0] }, push, &run)?;
        }
        Ok(self.radix.record(recorder, device, records, bits, subgroup)?)
    }

    fn record_gather<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &Job<'a>,
        drawn: u64,
        records: Slice<'a, [u32; 2]>,
    ) -> Result<(), Error> {
        let cloud = job.raster.cloud;
        let cut = Cut::new(device, cloud.len())?;
        let gather = Gather {
            composing: Composing::new(cloud, cut),
            bounds: cloud.bounds.all(),
            records,
            footprints: self.footprints.get().all(),
            colors: self.colors.get().all(),
            slopes: self.slopes.get().all(),
            rectangles: self.rectangles.get().all(),
        };
        let variant = compose::variant(cut, job.raster.footprint, Falloff::Flat);
        let push = GatherPush { count: drawn as u32, nearest: depth_keys(job.depth_range)[0] };
        let run = Run::new(Dispatch::Invocations(drawn)).variant(variant);
        Ok(recorder.run(&gather, push, &run)?)
    }

    /// Records what takes the drawn splats out of the cloud's order along an axis; returns which of the records they are.
    fn record_pick<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &Job<'a>,
        axis: Axis,
        subgroup: u32,
    ) -> Result<usize, Error> {
        let cloud = job.raster.cloud;
        let (Some(scan), Some(order)) = (&self.scan, cloud.along(axis.index)) else { return Ok(0) };
        let Runs { runs, length } = order_runs(device, cloud.len());
        let push = PresortedPush { count: cloud.len() as u32, run_length: length, backward: u32::from(axis.backward) };
        let (counts, starts) = (self.counts.get().slice(0, runs.into()), self.cursors.get().slice(0, runs.into()));
        let (bounds, records) = (cloud.bounds.all(), self.records[0].get().all());
        let run = || Run::new(Dispatch::Groups(runs.into())).variant(presorted_variant(subgroup));
        recorder.run(&Pick { order, bounds, counts }, push, &run())?;
        recorder.fill("bin/clear", self.overflow.all(), 0)?;
        scan.record(recorder, counts, starts, self.overflow.all())?;
        recorder.run(&Place { order, bounds, starts, records }, push, &run())?;
        Ok(0)
    }

    /// Records the counts of the tiles, their prefix sums, and the copy of the total to the host.
    fn record_tile_count<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &Job<'a>,
        binning: &Binning,
    ) -> Result<(), Error> {
        let Some(scan) = &self.scan else { return Ok(()) };
        let cells = binning.cells();
        let (counts, cursors) = (self.counts.get().slice(0, cells), self.cursors.get().slice(0, cells));
        recorder.fill("bin/clear", counts, 0)?;
        recorder.fill("bin/clear", self.overflow.all(), 0)?;
        let rectangles = self.rectangles.get().all();
        let run = Run::new(Dispatch::Invocations(binning.drawn));
        recorder.run(&TileCount { view: job.raster.cloud.view(), rectangles, counts }, binning.push(), &run)?;
        scan.record(recorder, counts, cursors, self.overflow.all())?;
        let (tiles, longest) = (binning.tiles(), self.longest.all());
        recorder.fill("bin/clear", longest, 0)?;
        let run = Run::new(Dispatch::Invocations(tiles));
        let push = MeasurePush { tiles: tiles as u32, runs: binning.runs.runs };
        recorder.run(&Measure { starts: cursors, longest }, push, &run)?;
        recorder.copy("bin/summary", self.overflow.all(), self.summary.slice(0, 1))?;
        recorder.copy("bin/summary", cursors.skip(cells - 1), self.summary.slice(1, 1))?;
        recorder.copy("bin/summary", longest, self.summary.slice(2, 1))?;
        Ok(())
    }

    fn record_tile_store<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &Job<'a>,
        binning: &Binning,
    ) -> Result<(), Error> {
        let store = TileStore {
            view: job.raster.cloud.view(),
            rectangles: self.rectangles.get().all(),
            cursors: self.cursors.get().slice(0, binning.cells()),
            entries: self.entries.get().all(),
        };
        let run = Run::new(Dispatch::Groups(binning.groups()));
        recorder.run(&store, binning.push(), &run.variant(store_variant(binning.subgroup)))?;
        // Each cell ends where the next one began; the last one is empty and has kept its cursor, the total.
        let inner = binning.cells() - 1;
        let (cursors, counts) = (self.cursors.get(), self.counts.get().slice(1, inner));
        let next = Expected::Below { ends: cursors.slice(1, inner), counts };
        Ok(recorder.agree("bin/tile-store", "run of a tile", cursors.slice(0, inner), next)?)
    }
}

/// Device bytes of the records of so many points, and of sorting them.
pub fn sort_bytes(device: &Device, points: u64) -> u64 {
    2 * RECORD_BYTES * points + Radix::bytes(device, points)
}

/// Device bytes of putting the drawn ones of so many points into an order.
fn order_bytes(device: &Device, order: Order, points: u64, drawn: u64) -> u64 {
    match order {
        Order::Along(_) => {
            let runs = u64::from(order_runs(device, points).runs);
            RECORD_BYTES * drawn + 8 * runs + Scan::bytes(runs)
        }
        _ => sort_bytes(device, points),
    }
}

/// How a presorted order is cut into runs, each of which a subgroup takes twice.
pub fn order_runs(device: &Device, points: u64) -> Runs {
    Runs::new(device.info().concurrent_runs, points, SHORTEST_RUN, 1 << 17)
}

/// Device bytes of a drawn splat in order.
fn splat_bytes(cloud: &DeviceCloud) -> u64 {
    16 + 16 + 8 + if cloud.has_normals() { 16 } else { 0 }
}

/// The key of the nearest depth, and the key, less that, of what lies beyond the farthest.
fn depth_keys(depth_range: [f32; 2]) -> [u32; 2] {
    let [near, far] = depth_range.map(depth_key);
    [near, far - near + 1]
}

/// What is subtracted from keys, and the key then of what is not drawn.
fn keys(order: Order, depth_range: [f32; 2], points: u64) -> [u32; 2] {
    match order {
        Order::Depth | Order::Along(_) => depth_keys(depth_range),
        Order::Index => [0, 1],
        Order::File => [0, points as u32],
    }
}

/// Bits of the keys of so many splats between two depths.
pub fn key_bits(order: Order, depth_range: [f32; 2], points: u64) -> u32 {
    (u32::BITS - keys(order, depth_range, points)[1].leading_zeros()).max(1)
}

const ORDER_DEPTH: u32 = 0;
const ORDER_INDEX: u32 = 1;
const ORDER_FILE: u32 = 2;

/// What shaders know of this module.
pub(crate) const CONSTANTS: [(&str, u32); 4] =
    [("TILE_SIDE", TILE_SIDE), ("BLOCK_SIDE", BLOCK_SIDE), ("ORDER_DEPTH", ORDER_DEPTH), ("ORDER_INDEX", ORDER_INDEX)];

/// The variant of `bin/keys`.
fn keys_variant(order: Order) -> Variant {
    let value = match order {
        Order::Depth | Order::Along(_) => ORDER_DEPTH,
        Order::Index => ORDER_INDEX,
        Order::File => ORDER_FILE,
    };
    Variant::plain().with("ORDER", value)
}

/// The passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let presorted = || SUBGROUPS.map(presorted_variant);
    vec![
        Shader::new::<Keys>([Order::Depth, Order::Index, Order::File].map(keys_variant)),
        Shader::new::<Gather>(compose::tiled_variants()),
        Shader::new::<Pick>(presorted()),
        Shader::new::<Place>(presorted()),
        Shader::plain::<TileCount>(),
        Shader::plain::<Measure>(),
        Shader::new::<TileStore>(SUBGROUPS.map(store_variant)),
    ]
}

/// The variant of `bin/pick` and `bin/place`.
fn presorted_variant(subgroup: u32) -> Variant {
    Variant::plain().subgroup(subgroup)
}

/// The key of a depth, as `depth_key` in WGSL.
fn depth_key(depth: f32) -> u32 {
    let bits = depth.to_bits();
    if bits >> 31 != 0 { !bits } else { bits | 1 << 31 }
}

/// The variant of `bin/tile-store`.
fn store_variant(subgroup: u32) -> Variant {
    let [columns, rows] = pattern(subgroup);
    Variant::plain().subgroup(subgroup).constant("LANE_COLUMNS", columns).constant("LANE_ROWS", rows)
}

/// The variant of stages that go through tiles with whole splats, from that of shape and falloff; `later`: a run that goes on
/// from what earlier ones left.
pub(crate) fn fold_variant(shape: Variant, later: bool, subgroup: u32) -> Variant {
    blocks(shape, subgroup).with("LATER", u32::from(later))
}

/// As [`fold_variant`], of stages that go through each tile region by region (shaders/shared/region_fold.wgsl).
pub(crate) fn region_variant(shape: Variant, later: bool, subgroup: u32) -> Variant {
    let columns = pattern(subgroup)[0];
    fold_variant(shape, later, subgroup).constant("PICKED", SEGMENT).constant("REGION_COLUMNS", columns)
}

/// The same where each block of a tile has a subgroup of its own ([`Binned::blocks`]): for stages that hold much for each pixel.
pub(crate) fn fold_blocks_variant(shape: Variant, later: bool, subgroup: u32) -> Variant {
    let mut variant = fold_variant(shape, later, subgroup).with("SHARED", BLOCKS);
    for (_, count) in &mut variant.counts {
        *count /= BLOCKS;
    }
    variant
}

/// The variant of stages that go through ordered tiles.
pub(crate) fn gather_variant(subgroup: u32) -> Variant {
    blocks(Variant::plain(), subgroup).with("SHAPE", Footprint::Disc as u32)
}

/// What shaders/shared/blocks.wgsl needs, and how many of a tile's splats a run takes.
fn blocks(variant: Variant, subgroup: u32) -> Variant {
    variant
        .with("TAKEN", SEGMENT)
        .subgroup(subgroup)
        .each("block", BLOCKS)
        .each("held", BLOCKS * BLOCK_SIDE * BLOCK_SIDE / subgroup)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most iterations of an invocation of `bin/tile-store`, by the loops as they stand in the shader.
    fn iterations(binning: &Binning) -> u64 {
        let [columns, rows] = binning.block.map(u64::from);
        // In the worst case each splat meets as many of a block's tiles as any splat meets at all.
        let [lane_columns, lane_rows] = pattern(binning.subgroup).map(u64::from);
        let most = binning.met_tiles.map(u64::from);
        let walked = most[0].min(columns).div_ceil(lane_columns) * most[1].min(rows).div_ceil(lane_rows);
        let length = u64::from(binning.runs.length);
        length * (walked + 1) + length.div_ceil(u64::from(binning.subgroup))
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
                            let binning = Binning::new(concurrent, window, drawn, [x, y], subgroup);
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
            // Block by block: the steps to pick splats; then every splat and the steps, for each of the block's regions.
            let steps = SEGMENT.div_ceil(subgroup);
            assert!(steps + (SEGMENT + steps + 1) * (BLOCK_SIDE.pow(2) / subgroup) < 60_000);
        }
    }

    #[test]
    fn a_splat_never_meets_more_tiles_than_binning_expects() {
        for extent in 1..=70u32 {
            let met = Binning::new(32, [0, 0, 1600, 1600], 1, [extent; 2], 8).met_tiles[0];
            let tiles = |first: u32| (first + extent - 1) / TILE_SIDE - first / TILE_SIDE + 1;
            assert!((0..TILE_SIDE).all(|first| tiles(first) <= met), "{extent}");
            assert!((0..TILE_SIDE).any(|first| tiles(first) + 1 >= met), "{extent}: at most one too many");
        }
    }

    #[test]
    fn patterns_of_tiles_fill_a_subgroup() {
        assert_eq!([4, 8, 16, 32].map(pattern), [[2, 2], [4, 2], [4, 4], [8, 4]]);
    }

    #[test]
    fn keys_keep_the_order_of_depths_and_what_is_not_drawn_comes_last() {
        let depths = [f32::NEG_INFINITY, -2.0, -0.0, 0.0, 1e-40, 1.0, 1.000_000_1, 3e38, f32::INFINITY];
        assert!(depths.windows(2).all(|pair| depth_key(pair[0]) < depth_key(pair[1])));
        assert_eq!(depth_keys([1.0, 1.0])[1], 1);
        // From 1 to 2 there are 2^23 steps.
        assert_eq!((depth_keys([1.0, 2.0])[1], key_bits(Order::Depth, [1.0, 2.0], 5)), ((1 << 23) + 1, 24));
        assert_eq!(key_bits(Order::Depth, [f32::NEG_INFINITY, f32::INFINITY], 5), 32);
        // Indices are in order already: one bit says what is drawn. In a file of 5 points keys go from 0 to 5.
        assert_eq!([Order::Index, Order::File].map(|order| key_bits(order, [1.0, 2.0], 5)), [1, 3]);
    }
}
