//! Binning: the drawn splats of a window put into an order, and into a list for each 16 × 16 tile that their rectangles
//! meet, in that order. Stages that go through the lists have their pixels for themselves, and need no atomics. Lists
//! hold indices: splats themselves stay in canonical order, in which those of a tile lie close together, so that caches
//! serve them.
//!
//! The sort is stable and points come in canonical order, so that the lists follow from the points alone.

mod binning;
mod keys;
mod ordered_tiles;
mod passes;
mod sort;
mod tile_lists;

pub use binning::Binned;
pub use keys::key_bits;
pub use ordered_tiles::OrderedTiles;
pub(crate) use ordered_tiles::{fold_blocks_variant, fold_variant, gather_variant, region_variant};
pub use passes::*;
pub use sort::{order_runs, sort_bytes};

use self::binning::{BLOCK_SIDE, Binning, INDEX_BITS, TILE_SIDE};
use self::keys::{ORDER_DEPTH, ORDER_FILE, ORDER_INDEX, keys_variant};
use self::sort::{order_bytes, presorted_variant};
use self::tile_lists::{count_variant, store_variant};
use super::Error;
use super::bands::Budget;
use super::compose::Composing;
use super::foresight::Knowledge;
use super::project::DeviceCloud;
use super::radix::Radix;
use super::raster::Raster;
use super::scan::Scan;
use super::timeline::Timeline;
use crate::choices::Choices;
use crate::fields;
use crate::gpu::shader::{SUBGROUPS, Shader};
use crate::gpu::{self, Buffer, Device, Memory, Pass, Recorder, Run, Scratch, Variant};
use crate::prepare::axes::Axis;

/// The order of splats in tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// Depth of the centers, then index: the order of blending, front to back.
    #[default]
    Depth,
    /// Index: the canonical order, which costs hardly any sort.
    Index,
    /// Order of the files, the last splat first: over-blending front to back.
    File,
    /// Order of the files, the first splat first.
    Arrival,
    /// Along an axis of the world, in an order that the cloud brings ([`DeviceCloud::sort_along`]): nothing is sorted.
    Along(Axis),
}

/// Device bytes per pixel of a window that do not depend on the splats: the table of tiles is made to fit what is left.
pub const PIXEL_BYTES: u64 = 4;
/// Counters of tiles that come to the host at a time.
const COPIED_COUNTERS: u64 = 1 << 20;
/// Bytes of a record of the sort: key and index.
pub const RECORD_BYTES: u64 = 8;
/// Bytes of an entry of a tile where pairs are sorted: itself, two records, and at most a counter of a digit with its
/// cursor and prefix sums ([`Radix::bytes`]).
const PAIR_BYTES: u64 = 4 + 2 * RECORD_BYTES + 8 + 1;

/// The splats of a window to bin.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The projected cloud; its walker is not used.
    pub raster: Raster<'a>,
    /// The order of splats in tiles.
    pub order: Order,
    /// Near and far.
    pub depth_range: [f32; 2],
    /// The memory that may be used.
    pub budget: Budget,
    /// Bytes of it that are in use for something else.
    pub counted_bytes: u64,
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Bins by device {
        radix: Radix = Radix::new(device)?,
        records: [Scratch<[u32; 2]>; 2] =
            ["sort records", "sort records, moved"].map(|name| Scratch::new(name, Memory::Device)),
        counts: Scratch<u32> = Scratch::new("tile counts by run", Memory::Device),
        cursors: Scratch<u32> = Scratch::new("tile cursors by run", Memory::Device),
        scan: Scan = Scan::new(device, 0)?,
        longest: Buffer<u32> = device.buffer("longest tile list", 1, Memory::Device)?,
        entries: Scratch<u32> = Scratch::new("ordered tile entries", Memory::Device),
        pairs: [Scratch<[u32; 2]>; 2] =
            ["tile pairs", "tile pairs, moved"].map(|name| Scratch::new(name, Memory::Device)),
        counted: Option<Binning> = None,
    }
}

/// Outcome of binning a window.
#[derive(Debug, Clone, Copy)]
pub enum Bin {
    /// No splat is drawn.
    Nothing,
    /// The tiles take too much memory: the window must be cut.
    TooLarge,
    /// The window is binned.
    Done(Binned),
}

/// Outcome that binning a window would have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BinSurvey {
    /// No splat is drawn.
    Nothing,
    /// The tiles take too much memory: the window must be cut.
    TooLarge,
    /// The window would be binned, with this many counters of the tiles' splats.
    Cells(u64),
}

impl Bins {
    /// Sorts a window's splats and counts those of each tile. The tiles' lists are there once [`Self::record_tiles`]
    /// has run.
    pub fn bin(&mut self, device: &Device, job: &Job<'_>, timeline: &mut Timeline) -> Result<Bin, Error> {
        let Some(binning) = Binning::for_window(device, job)? else { return Ok(Bin::Nothing) };
        Ok(self.sort_and_count(device, job, binning, timeline)?.map_or(Bin::TooLarge, Bin::Done))
    }

    /// Records the lists of a binned window's tiles, for the stages after it that go through them. Once for each
    /// window: in the submission of the first such stage, so that nobody waits for them.
    pub fn record_tiles<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        cloud: &'a DeviceCloud,
        binned: Binned,
    ) -> Result<OrderedTiles<'a>, Error> {
        if binned.binning.pairs {
            self.record_pairs(recorder, cloud, &binned)?;
        } else {
            self.record_tile_store(recorder, cloud, &binned)?;
        }
        Ok(self.tiles(cloud, binned))
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
        let mut recorder = timeline.recorder(device)?;
        let last = match job.order {
            Order::Along(axis) => {
                if timeline.foresight.knowledge() != Knowledge::None {
                    // There may be fewer drawn points than records.
                    recorder.fill("bin/clear", self.records[0].get().all(), u32::MAX)?;
                }
                self.record_pick(&mut recorder, device, job, axis, binning.lanes.subgroup)?
            }
            _ => self.record_sort(&mut recorder, job, binning.lanes.subgroup)?,
        };
        self.record_tile_count(&mut recorder, job, &binning, last)?;
        let total = self.cursors.get().slice(binning.total(), 1);
        let counts = [self.scan.overflow.all(), total, self.longest.all()];
        let answer = timeline.ask(device, recorder, ("bin/summary", "bin/sort and count"), &counts)?;
        let [overflow, entries, longest] = [answer.words[0], answer.words[1], answer.words[2]];
        if overflow != 0 || u64::from(entries) > left {
            return Ok(None);
        }
        let entries = entries.max(1);
        self.entries.reserve_within(device, entries.into(), left)?;
        if binning.pairs {
            for pairs in &mut self.pairs {
                pairs.reserve_within(device, entries.into(), left)?;
            }
            self.radix.reserve(device, entries.into())?;
        }
        self.counted = Some(binning);
        Ok(Some(Binned { binning, records: last, longest, entries, counts: answer.place }))
    }

    /// Forgets which window was binned last.
    pub fn forget_tile_counts(&mut self) {
        self.counted = None;
    }

    /// Copies to the host how many splats each tile of the window has that was binned last; none if none was since
    /// [`Self::forget_tile_counts`]. Its passes must have been submitted.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn tile_counts(&self) -> Result<Vec<u32>, gpu::Error> {
        let Some(binning) = self.counted else { return Ok(Vec::new()) };
        let (tiles, runs) = (binning.tiles(), u64::from(binning.runs.runs));
        let at_once = (COPIED_COUNTERS / runs).max(1);
        let mut counts = Vec::new();
        let mut first = 0;
        while first < tiles {
            let some = at_once.min(tiles - first);
            let words = self.counts.get().read(first * runs, some * runs)?;
            counts.extend(words.chunks_exact(runs as usize).map(|of_tile| of_tile.iter().sum::<u32>()));
            first += some;
        }
        Ok(counts)
    }

    /// Returns a binned window's tiles, for stages behind [`Self::record_tiles`].
    pub fn tiles<'a>(&'a self, cloud: &'a DeviceCloud, binned: Binned) -> OrderedTiles<'a> {
        let tiled = Tiled {
            splats: Composing::new(cloud, binned.cut()),
            ends: self.cursors.get().slice(0, binned.binning.total() + 1),
            entries: self.entries.get().all(),
            bounds: cloud.bounds.all(),
        };
        OrderedTiles { binned, tiled }
    }

    /// Returns the number of device bytes that sorting a window's splats takes, tiles not counted.
    pub fn least_bytes(device: &Device, job: &Job<'_>) -> u64 {
        let (cloud, drawn) = (job.raster.cloud, job.raster.stats.iter().map(|s| u64::from(s.visible)).sum::<u64>());
        order_bytes(device, job.order, cloud.len(), drawn)
    }

    /// Returns the same where every point is drawn.
    pub fn most_bytes(device: &Device, cloud: &DeviceCloud) -> u64 {
        sort_bytes(device, cloud.len())
    }

    /// Returns the number of device bytes of the buffers that hold a binned window.
    pub fn bytes(&self) -> u64 {
        let records: u64 = self.records.iter().chain(&self.pairs).map(Scratch::bytes).sum();
        let tiles = self.counts.bytes() + self.cursors.bytes() + self.entries.bytes();
        records + tiles + self.scan.kept_bytes() + self.radix.kept_bytes()
    }

    /// Decides how a window is binned; sorts nothing.
    pub fn survey(device: &Device, job: &Job<'_>) -> Result<BinSurvey, Error> {
        let Some(binning) = Binning::for_window(device, job)? else { return Ok(BinSurvey::Nothing) };
        Ok(binning.left(device, job)?.map_or(BinSurvey::TooLarge, |_| BinSurvey::Cells(binning.cells())))
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
        // The counters of a presorted order's runs are done with before those of tiles.
        let cells = binning.cells().max(picked);
        self.counts.reserve(device, cells)?;
        self.cursors.reserve(device, cells)?;
        Ok(self.scan.reserve(device, cells)?)
    }
}

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 6] = [
    ("TILE_SIDE", TILE_SIDE),
    ("BLOCK_SIDE", BLOCK_SIDE),
    ("INDEX_BITS", INDEX_BITS),
    ("ORDER_DEPTH", ORDER_DEPTH),
    ("ORDER_INDEX", ORDER_INDEX),
    ("ORDER_FILE", ORDER_FILE),
];

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let presorted = || SUBGROUPS.map(presorted_variant);
    vec![
        Shader::new::<Keys>([Order::Depth, Order::Index, Order::File, Order::Arrival].map(keys_variant)),
        Shader::new::<Pick>(presorted()),
        Shader::new::<Place>(presorted()),
        Shader::new::<TileCount>([false, true].map(count_variant)),
        Shader::plain::<Measure>(),
        Shader::plain::<Pairs>(),
        Shader::new::<TileStore>(SUBGROUPS.map(store_variant)),
    ]
}

impl Binned {
    /// Records `runs` of a pass over the blocks of all tiles, as many as [`Self::segments`] or
    /// [`Self::region_segments`] tells.
    pub(crate) fn record_runs<'a, P: Pass + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        pass: &P,
        runs: u32,
        push: impl Fn(TileWalk) -> P::Push,
        variant: &Variant,
    ) -> Result<(), gpu::Error> {
        let over = Run::new(self.over_blocks()).variant(variant.clone());
        (0..runs).try_for_each(|number| recorder.run(pass, push(self.walk(number, runs)), &over))
    }
}

/// Returns the variants of a stage that goes through tiles, from those of shapes: each shape, way and division.
pub(crate) fn tile_variants<W: Copy>(
    shapes: Vec<Variant>,
    ways: &[W],
    of: impl Fn(Variant, Lanes, W) -> Variant,
) -> Vec<Variant> {
    let of = &of;
    let each = |shape: Variant| {
        ways.iter().flat_map(move |way| {
            let shape = shape.clone();
            Lanes::all().into_iter().map(move |lanes| of(shape.clone(), lanes, *way))
        })
    };
    shapes.into_iter().flat_map(each).collect()
}

/// Splats of a tile that one run takes, at five iterations each. Runs are composed by themselves and then joined, so
/// that the smallest opacities don't round away in a sum of millions.
const SEGMENT: u32 = 2048;
/// Returns the same for stages that go through tiles region by region, whose workgroups note that many: wide ones may
/// not take the room of others.
const fn region_segment(subgroup: u32) -> u32 {
    if subgroup < 16 { SEGMENT } else { SEGMENT / 2 }
}
/// Subgroups of a workgroup where a device prefers several.
const TEAM: u32 = 4;

/// Division of the invocations of a workgroup that goes through tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lanes {
    /// Invocations of a subgroup, which has a tile or a block of a tile to itself.
    pub subgroup: u32,
    /// Subgroups of a workgroup: a GPU holds too few workgroups for one each, a CPU has nothing of more.
    pub team: u32,
}

impl Lanes {
    /// Returns those of a device.
    fn of(device: &Device) -> Result<Self, Error> {
        let info = device.info();
        let subgroup = info.subgroup.ok_or_else(|| Error::NoSubgroups { device: info.name.clone() })?;
        let fits = picked_bytes(subgroup, TEAM) <= device.limits().shared_bytes;
        Ok(Self { subgroup, team: if info.prefers.shared_work && fits { TEAM } else { 1 } })
    }

    /// Returns the number of points whose splats can be sorted at once.
    fn most_points(self, device: &Device) -> u64 {
        // Stages that go through tiles region by region keep a bit for each region of a block beside the index.
        let index_bits = INDEX_BITS.min(32 - BLOCK_SIDE.pow(2) / self.subgroup);
        (device.limits().binding_bytes / RECORD_BYTES).min(1 << index_bits)
    }

    /// Returns the number of workgroups of so many subgroups.
    fn groups(self, subgroups: u64) -> u64 {
        subgroups.div_ceil(self.team.into())
    }
}

/// Returns the number of points whose splats a device can sort at once: what reaches them by index binds their records
/// as a whole. Without subgroups nothing is sorted, and there is no limit.
pub fn most_points(device: &Device) -> u64 {
    Lanes::of(device).map_or(u64::MAX, |lanes| lanes.most_points(device))
}

/// Bytes of a workgroup's memory that stages take which go through tiles region by region.
const fn picked_bytes(subgroup: u32, team: u32) -> u32 {
    region_segment(subgroup) * team * 4
}

// Every device has 16 KiB.
const _: () = assert!(picked_bytes(4, 1) <= 16 << 10);

impl Choices for Lanes {
    fn all() -> Vec<Self> {
        [1, TEAM].into_iter().flat_map(|team| SUBGROUPS.map(|subgroup| Self { subgroup, team })).collect()
    }
}
