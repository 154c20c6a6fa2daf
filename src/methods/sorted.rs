//! `sorted`: splats sorted once by the depth of their centres, binned to tiles in that order, blended front to back tile by
//! tile, until nothing behind can be seen. Exact for flat discs; approximate where oriented ones cross.
//!
//! The order is that of the A-buffer, depth and then content: the sort is stable and points come in canonical order.

use super::abuffer::CountPush;
use super::bands::{self, Band, Budget, Window};
use super::renderer::{Facts, Target, Timeline};
use super::{Error, Outcome};
use crate::gpu::{Buffer, Device, Dispatch, Kept, Memory, Pass, Recorder, Run, Slice, Variant};
use crate::passes::compose::{self, Composing, ComposingGroup, Cut};
use crate::passes::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, View};
use crate::passes::radix::{Radix, Runs};
use crate::passes::raster::Raster;
use crate::passes::scan::Scan;
use crate::scene::{ColorSpace, Discs};
use crate::{gpu_struct, group, pass};

gpu_struct! {
    /// Push constants of `sorted/keys`; the shader says what the members are.
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

gpu_struct! {
    /// Push constants of `sorted/blend`; the shader says what the members are.
    pub struct BlendPush {
        columns: u32,
        tiles: u32,
        runs: u32,
        nearest: u32,
        segment: u32,
        most_opacity: f32,
        most_color: f32,
    }
}

pass! {
    /// Depth and index of each splat of a chunk.
    pub Keys(KeysPush) = "sorted/keys" {
        splats: Read<Splat>,
        bounds: Read<Bounds>,
        records: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Splats in order of depth.
    pub Gather(CountPush) = "sorted/gather" {
        composing: Shared<ComposingGroup>,
        bounds: Read<Bounds>,
        records: Read<[u32; 2]>,
        footprints: ReadWrite<[u32; 4]>,
        colors: ReadWrite<[f32; 4]>,
        slopes: ReadWrite<[f32; 4]>,
        rectangles: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Splats per tile and run.
    pub TileCount(TilePush) = "sorted/tile-count" in "sorted/tile_count" {
        view: Uniform<View>,
        rectangles: Read<[u32; 2]>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// Splats into their tiles.
    pub TileStore(TilePush) = "sorted/tile-store" in "sorted/tile_store" {
        view: Uniform<View>,
        rectangles: Read<[u32; 2]>,
        cursors: ReadWrite<u32>,
        entries: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Push constants of `sorted/measure`: tiles, and cells of each.
    pub struct MeasurePush {
        tiles: u32,
        runs: u32,
    }
}

pass! {
    /// The longest list of a tile.
    pub Measure(MeasurePush) = "sorted/measure" {
        starts: Read<u32>,
        longest: ReadWrite<u32>,
    }
}

gpu_struct! {
    /// Push constants of stages that go through ordered tiles; shaders/shared/tile_gather.wgsl says what the members are.
    pub struct GatherPush {
        columns: u32,
        first_tile: u32,
        tiles: u32,
        runs: u32,
        segment: u32,
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

pass! {
    /// Tiles to pixels.
    pub Blend(BlendPush) = "sorted/blend" {
        view: Uniform<View>,
        ends: Read<u32>,
        entries: Read<u32>,
        records: Read<[u32; 2]>,
        footprints: Read<[u32; 4]>,
        colors: Read<[f32; 4]>,
        slopes: Read<[f32; 4]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// Device bytes per pixel of a window that do not depend on the splats: the table of tiles is made to fit what is left.
pub const PIXEL_BYTES: u64 = 4;
/// Side of a tile in pixels.
const TILE_SIDE: u32 = 16;
/// Side of a block of pixels, `SIDE` in WGSL.
const BLOCK_SIDE: u32 = 8;
/// Tiles along the side of a block of tiles that one subgroup walks, where splats meet very many.
const WALK_BLOCK: u32 = 32;
/// Most iterations of an invocation that walks tiles: below what one driver allows (65 535).
const MOST_ITERATIONS: u64 = 50_000;
/// Splats of a tile that one run of `sorted/blend` takes, at five iterations each.
const SEGMENT: u32 = 8192;
/// Shortest run of splats that a subgroup walks.
const SHORTEST_RUN: u64 = 256;

/// What may be left out at the back of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stop {
    /// What changes no bit of the image.
    #[default]
    Exact,
    /// What changes no 8-bit value of the composed image by more than a quarter of a step.
    EightBit {
        /// Whether the image goes without background, so that color is divided by A.
        transparent: bool,
    },
}

/// Everything that stays the same while a window is rendered.
#[derive(Clone, Copy)]
pub struct WindowJob<'a> {
    /// The projected cloud; its walker is not used.
    pub raster: Raster<'a>,
    /// Shape and falloff.
    pub discs: Discs,
    /// In which space colors are blended.
    pub color: ColorSpace,
    /// Near and far.
    pub depth_range: [f32; 2],
    /// Upper bound of the color components that are blended.
    pub most_color: f32,
    /// When to stop.
    pub stop: Stop,
    /// The memory that may be used.
    pub budget: Budget,
}

/// Buffers, kept from frame to frame.
pub struct Sorted {
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
}

/// A window whose splats are sorted, and the tiles' numbers of them known.
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
    subgroup: u32,
}

impl Binned {
    /// Runs over all tiles that it takes to get through the longest list.
    fn segments(&self) -> u32 {
        self.longest.div_ceil(SEGMENT).max(1)
    }
}

/// Tiles with their splats in order of depth.
#[derive(Clone, Copy)]
pub struct OrderedTiles<'a> {
    /// How they were made.
    pub binned: Binned,
    ends: Slice<'a, u32>,
    entries: Slice<'a, u32>,
    /// Relative depth key and index of the splat, by rank.
    pub records: Slice<'a, [u32; 2]>,
    /// Fractions, pixel and radius, by rank.
    pub footprints: Slice<'a, [u32; 4]>,
    /// Colors as blended, and opacities, by rank.
    pub colors: Slice<'a, [f32; 4]>,
}

impl<'a> OrderedTiles<'a> {
    /// Records a stage that collects the fragments of a band's pixels.
    pub fn record<P: Pass + 'a>(
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
            let push = GatherPush {
                columns: binning.columns,
                first_tile: first * binning.columns,
                tiles,
                runs: binning.runs.runs,
                segment,
                band_start: band.pixels[0],
                band_end: band.pixels[1],
                first_fragment: band.first_fragment,
            };
            let run = Run::new(Dispatch::Groups(tiles.into())).push(&push).variant(gather_variant(binned.subgroup));
            recorder.run(&pass, &run)?;
        }
        Ok(())
    }
}

impl Binning {
    /// `drawn` splats, each over at most `extent` columns and rows of pixels.
    fn new(device: &Device, window: Window, drawn: u64, extent: [u32; 2], subgroup: u32) -> Self {
        let [columns, rows] = [(window[2] - window[0]).div_ceil(TILE_SIDE), (window[3] - window[1]).div_ceil(TILE_SIDE)];
        let [lane_columns, lane_rows] = pattern(subgroup);
        let steps = |[x, y]: [u32; 2]| u64::from(x.div_ceil(lane_columns)) * u64::from(y.div_ceil(lane_rows));
        // A span of n pixels meets at most this many tiles.
        let span = extent.map(|n| n.saturating_sub(1) / TILE_SIDE + 2);
        let met = [span[0].min(columns), span[1].min(rows)];
        let block = if steps(met) > steps([WALK_BLOCK; 2]) { [WALK_BLOCK; 2] } else { [columns, rows] };
        let most = steps([met[0].min(block[0]), met[1].min(block[1])]);
        let longest = MOST_ITERATIONS / (most + 2);
        Self { drawn, runs: Runs::new(device, drawn, SHORTEST_RUN.min(longest), longest), columns, rows, block }
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

    /// Subgroups of `sorted/tile-store`: one for each run and block.
    fn groups(&self) -> u64 {
        let blocks = self.columns.div_ceil(self.block[0]) * self.rows.div_ceil(self.block[1]);
        u64::from(self.runs.runs) * u64::from(blocks)
    }
}

/// Columns and rows of the pattern of tiles that the invocations of a subgroup own; as in shaders/shared/tile_push.wgsl.
fn pattern(subgroup: u32) -> [u32; 2] {
    let columns = match subgroup {
        32 => 8,
        8.. => 4,
        _ => 2,
    };
    [columns, subgroup / columns]
}

impl Sorted {
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let records = |name| Kept::new(name, Memory::Device);
        Ok(Self {
            radix: Radix::new(device)?,
            records: [records("sort records"), records("sort records, moved")],
            footprints: Kept::new("sorted footprints", Memory::Device),
            colors: Kept::new("sorted colors", Memory::Device),
            slopes: Kept::new("sorted tilts", Memory::Device),
            rectangles: Kept::new("sorted rectangles", Memory::Device),
            counts: Kept::new("tile counts by run", Memory::Device),
            cursors: Kept::new("tile cursors by run", Memory::Device),
            scan: None,
            overflow: device.buffer("scan overflow", 1, Memory::Device)?,
            longest: device.buffer("longest tile list", 1, Memory::Device)?,
            summary: device.buffer("tile summary", 3, Memory::Readback)?,
            entries: Kept::new("sorted tile entries", Memory::Device),
        })
    }

    /// Sorts, bins and blends a window into the target.
    pub fn render(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        target: &Target,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        let window = job.raster.window;
        let pixels = bands::pixels(window);
        if job.raster.stats.iter().all(|s| s.visible == 0) {
            let mut recorder = device.recorder()?;
            super::abuffer::record_nothing(&mut recorder, target, window)?;
            target.record_read_back(&mut recorder, pixels)?;
            timeline.add(recorder.submit("image/clear")?);
            return Ok(Outcome::Done);
        }
        let Some(binned) = self.bin(device, job, timeline)? else { return Ok(Outcome::Overflow) };
        facts.tile_entries += u64::from(binned.entries);
        facts.bands += 1;
        let mut recorder = device.recorder()?;
        self.record_tile_store(&mut recorder, job, &binned)?;
        self.record_blend(&mut recorder, job, &binned, target)?;
        target.record_read_back(&mut recorder, pixels)?;
        timeline.add(recorder.submit("sorted/blend")?);
        Ok(Outcome::Done)
    }

    /// Sorts a window's splats and counts those of each tile; `None` if the window must be cut. There must be a splat to draw.
    pub fn bin(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        timeline: &mut Timeline,
    ) -> Result<Option<Binned>, Error> {
        let subgroup = device.info().subgroup.ok_or_else(|| Error::NoSubgroups { device: device.info().name.clone() })?;
        let (cloud, window, stats) = (job.raster.cloud, job.raster.window, job.raster.stats);
        let drawn: u64 = stats.iter().map(|s| u64::from(s.visible)).sum();
        let binning = Binning::new(device, window, drawn, Stats::extent(stats), subgroup);
        let Some(left) = self.check(device, job, &binning)? else { return Ok(None) };
        self.reserve(device, job, &binning)?;

        let mut recorder = device.recorder()?;
        let bits = [job.depth_range[0], job.depth_range[1]].map(depth_key);
        let (nearest, none) = (bits[0], bits[1] - bits[0] + 1);
        let records = self.records.each_ref().map(|r| r.get().slice(0, cloud.len()));
        for (first, count) in cloud.chunks() {
            let push = KeysPush { count: count as u32, first: first as u32, nearest, none };
            let keys = Keys {
                splats: cloud.splats.slice(first, count),
                bounds: cloud.bounds.slice(first, count),
                records: records[0],
            };
            recorder.run(&keys, &Run::new(Dispatch::Invocations(count)).push(&push))?;
        }
        let key_bits = u32::BITS - none.leading_zeros();
        let last = self.radix.record(&mut recorder, device, records, key_bits, subgroup)?;
        self.record_gather(&mut recorder, device, job, drawn, records[last])?;
        self.record_tile_count(&mut recorder, job, &binning)?;
        timeline.add(recorder.submit("sorted/sort and count")?);
        let words = self.summary.mapped_slice();
        let [overflow, entries, longest] = [words[0], words[1], words[2]];
        if overflow != 0 || u64::from(entries) * 4 > left {
            return Ok(None);
        }
        self.entries.reserve_within(device, u64::from(entries).max(1), left / 4)?;
        Ok(Some(Binned { binning, records: last, nearest, entries, longest, subgroup }))
    }

    /// Records the lists of a binned window's tiles.
    pub fn record_tile_store<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        binned: &Binned,
    ) -> Result<(), Error> {
        let (rectangles, cursors) = (self.rectangles.get().all(), self.cursors.get().slice(0, binned.binning.cells()));
        let store = TileStore { view: job.raster.cloud.view(), rectangles, cursors, entries: self.entries.get().all() };
        let run = Run::new(Dispatch::Groups(binned.binning.groups())).push(&binned.binning.push());
        Ok(recorder.run(&store, &run.variant(tile_variant().subgroup(binned.subgroup)))?)
    }

    fn record_blend<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        binned: &Binned,
        target: &'a Target,
    ) -> Result<(), Error> {
        let binning = &binned.binning;
        let blend = Blend {
            view: job.raster.cloud.view(),
            ends: self.cursors.get().slice(0, binning.cells()),
            entries: self.entries.get().all(),
            records: self.records[binned.records].get().all(),
            footprints: self.footprints.get().all(),
            colors: self.colors.get().all(),
            slopes: self.slopes.get().all(),
            image: target.image(),
            depths: target.depths(),
        };
        let (stop, most_color) = stop(job.stop, job.color, job.most_color);
        let shape = compose::shape_variant(job.raster.footprint, job.discs.falloff);
        let variant = blend_variant(shape, stop, binned.subgroup);
        for segment in 0..binned.segments() {
            let push = BlendPush {
                columns: binning.columns,
                tiles: binning.tiles() as u32,
                runs: binning.runs.runs,
                nearest: binned.nearest,
                segment,
                most_opacity: job.raster.cloud.most_opacity(),
                most_color,
            };
            let run = Run::new(Dispatch::Groups(binning.tiles())).push(&push).variant(variant.clone());
            recorder.run(&blend, &run)?;
        }
        Ok(())
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
        }
    }

    /// Device bytes that sorting a window's splats takes, tiles not counted.
    pub fn least_bytes(device: &Device, job: &WindowJob<'_>) -> u64 {
        let drawn = job.raster.stats.iter().map(|s| u64::from(s.visible)).sum();
        bytes_for(device, job.raster.cloud, drawn)
    }

    /// The same where every point is drawn.
    pub fn most_bytes(device: &Device, cloud: &DeviceCloud) -> u64 {
        bytes_for(device, cloud, cloud.len())
    }

    /// Device bytes of the buffers that hold a binned window.
    pub fn bytes(&self) -> u64 {
        let records: u64 = self.records.iter().map(|r| r.bytes()).sum();
        let splats = self.footprints.bytes() + self.colors.bytes() + self.slopes.bytes() + self.rectangles.bytes();
        let tiles = self.counts.bytes() + self.cursors.bytes() + self.entries.bytes();
        let scan = self.scan.as_ref().map_or(0, |s| Scan::bytes(s.capacity()));
        records + splats + tiles + scan + self.radix.kept_bytes()
    }

    /// Bytes left for the tiles' entries; `None` if the window must be cut.
    fn check(&self, device: &Device, job: &WindowJob<'_>, binning: &Binning) -> Result<Option<u64>, Error> {
        let (points, binding) = (job.raster.cloud.len(), device.limits().binding_bytes);
        if points * 8 > binding {
            return Err(Error::TooManyPoints { points, limit: binding / 8 });
        }
        let needed = Self::least_bytes(device, job);
        let available = job.budget.left(0);
        if needed > available {
            return Err(Error::SortOverBudget { points, needed, available, budget: Budget::wanted(needed) });
        }
        let cells = binning.cells();
        let table = cells * 8 + Scan::bytes(cells);
        let fits = cells * 4 <= binding && binning.drawn * 16 <= binding;
        Ok((fits && table <= available - needed).then(|| (available - needed - table).min(binding)))
    }

    fn reserve(&mut self, device: &Device, job: &WindowJob<'_>, binning: &Binning) -> Result<(), Error> {
        let points = job.raster.cloud.len();
        for records in &mut self.records {
            records.reserve(device, points)?;
        }
        self.radix.reserve(device, points)?;
        self.footprints.reserve(device, binning.drawn)?;
        self.colors.reserve(device, binning.drawn)?;
        self.slopes.reserve(device, if job.raster.cloud.has_normals() { binning.drawn } else { 1 })?;
        self.rectangles.reserve(device, binning.drawn)?;
        let cells = binning.cells();
        self.counts.reserve(device, cells)?;
        self.cursors.reserve(device, cells)?;
        // A smaller one is freed before a larger one is made.
        self.scan = self.scan.take().filter(|s| s.capacity() >= cells);
        if self.scan.is_none() {
            self.scan = Some(Scan::new(device, cells)?);
        }
        Ok(())
    }

    fn record_gather<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &WindowJob<'a>,
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
        let variant = compose::variant(cut, job.raster.footprint, job.discs.falloff);
        let run = Run::new(Dispatch::Invocations(drawn)).push(&CountPush { count: drawn as u32 }).variant(variant);
        Ok(recorder.run(&gather, &run)?)
    }

    /// Records the counts of the tiles, their prefix sums, and the copy of the total to the host.
    fn record_tile_count<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &WindowJob<'a>,
        binning: &Binning,
    ) -> Result<(), Error> {
        let Some(scan) = &self.scan else { return Ok(()) };
        let cells = binning.cells();
        let (counts, cursors) = (self.counts.get().slice(0, cells), self.cursors.get().slice(0, cells));
        recorder.fill("sorted/clear", counts, 0)?;
        recorder.fill("sorted/clear", self.overflow.all(), 0)?;
        let rectangles = self.rectangles.get().all();
        let run = Run::new(Dispatch::Invocations(binning.drawn)).push(&binning.push()).variant(tile_variant());
        recorder.run(&TileCount { view: job.raster.cloud.view(), rectangles, counts }, &run)?;
        scan.record(recorder, counts, cursors, self.overflow.all())?;
        let (tiles, longest) = (binning.tiles(), self.longest.all());
        recorder.fill("sorted/clear", longest, 0)?;
        let run = Run::new(Dispatch::Invocations(tiles));
        let push = MeasurePush { tiles: tiles as u32, runs: binning.runs.runs };
        recorder.run(&Measure { starts: cursors, longest }, &run.push(&push))?;
        recorder.copy("sorted/summary", self.overflow.all(), self.summary.slice(0, 1))?;
        recorder.copy("sorted/summary", cursors.skip(cells - 1), self.summary.slice(1, 1))?;
        recorder.copy("sorted/summary", longest, self.summary.slice(2, 1))?;
        Ok(())
    }
}

fn bytes_for(device: &Device, cloud: &DeviceCloud, drawn: u64) -> u64 {
    let slopes = if cloud.has_normals() { 16 } else { 0 };
    cloud.len() * 16 + Radix::bytes(device, cloud.len()) + drawn * (16 + 16 + 8 + slopes)
}

/// The value of `STOP` in WGSL, and the bound on colors that goes with it.
pub fn stop(stop: Stop, color: ColorSpace, most_color: f32) -> (u32, f32) {
    match (stop, color) {
        (Stop::Exact, _) => (1, most_color),
        (Stop::EightBit { transparent }, space) => {
            // The background may come behind. Without one, C / A moves by at most T (m + 1) / A, and A is above 0.9 here.
            let most = most_color.max(1.0);
            let most = if transparent { (most + 1.0) * 1.2 } else { most };
            (if space == ColorSpace::Linear { 2 } else { 3 }, most)
        }
    }
}

/// The key of a depth, as `depth_key` in WGSL.
fn depth_key(depth: f32) -> u32 {
    let bits = depth.to_bits();
    if bits >> 31 != 0 { !bits } else { bits | 1 << 31 }
}

/// The variant of the passes that meet splats with tiles.
pub fn tile_variant() -> Variant {
    Variant::plain().constant("TILE_SIDE", TILE_SIDE)
}

/// The variant of stages that go through ordered tiles.
pub fn gather_variant(subgroup: u32) -> Variant {
    blocks(Variant::plain(), subgroup).with("SHAPE", Footprint::Disc as u32)
}

/// A variant of `sorted/blend`, from that of shape and falloff.
pub fn blend_variant(shape: Variant, stop: u32, subgroup: u32) -> Variant {
    blocks(shape, subgroup).with("STOP", stop)
}

/// What shaders/shared/blocks.wgsl needs.
fn blocks(variant: Variant, subgroup: u32) -> Variant {
    let blocks = (TILE_SIDE / BLOCK_SIDE).pow(2);
    variant
        .with("TAKEN", SEGMENT)
        .constant("TILE_SIDE", TILE_SIDE)
        .subgroup(subgroup)
        .each("block", blocks)
        .each("held", blocks * BLOCK_SIDE * BLOCK_SIDE / subgroup)
}
