//! `abuffer`: exact order-independent transparency (MCTB12): count, scan, store, sort and blend.
//!
//! Each pixel's fragments lie together in one buffer of 8 bytes per fragment: depth key and index of the splat. Lists of up
//! to [`LOCAL_LENGTH`] fragments are sorted and blended by one invocation in a local array. Longer ones are sorted in runs of
//! that length, merged pairwise between two buffers, blended run by run and composed, so that no invocation loops longer
//! than a run, however long the list is.

use super::Error;
use super::bands::{self, Band, Budget, Window};
use super::renderer::{Facts, Target, Timeline};
use crate::gpu::{self, Buffer, Device, Dispatch, Memory, Recorder, Run, Slice, Variant};
use crate::passes::project::{Bounds, DeviceCloud, Footprint, Splat, Stats, Tilt, View};
use crate::passes::raster::{Chunk, Kept, Tiled, Walker, tile_offsets_len};
use crate::passes::scan::Scan;
use crate::scene::{DiscShape, Discs, Falloff};
use crate::{gpu_struct, pass};

/// The longest list that one invocation sorts in a local array; also the length of a run of a longer one.
pub const LOCAL_LENGTH: u32 = 256;
/// Lists up to this length take a smaller array: at 16 fragments twice as fast.
const SHORT_LENGTH: u32 = 32;
/// Pixels of one invocation of `abuffer/measure`.
const MEASURE_RUN: u64 = 64;
/// Bytes of a fragment: depth key and splat index.
pub const FRAGMENT_BYTES: u64 = 8;
/// Bytes per pixel of a window: count, offset, and their share of the scan's levels.
pub const PIXEL_BYTES: u64 = 9;

gpu_struct! {
    /// Push constants: a band of pixels.
    pub struct BandPush {
        band_start: u32,
        band_end: u32,
    }
}

gpu_struct! {
    /// Push constants: a number of elements.
    pub struct CountPush {
        count: u32,
    }
}

gpu_struct! {
    /// Push constants: length of the runs to merge.
    pub struct MergePush {
        width: u32,
    }
}

gpu_struct! {
    /// Longest list, and fragments in lists over [`LOCAL_LENGTH`].
    pub struct Lengths {
        longest: u32,
        in_long_lists: u32,
    }
}

gpu_struct! {
    /// A run of a long list.
    pub struct ListRun {
        start: u32,
        length: u32,
        run: u32,
        pixel: u32,
    }
}

gpu_struct! {
    /// A long list.
    pub struct LongList {
        pixel: u32,
        first_run: u32,
        runs: u32,
    }
}

gpu_struct! {
    /// Indirect arguments and counts of runs and lists.
    pub struct LongWork {
        run_groups: [u32; 3],
        run_count: u32,
        list_groups: [u32; 3],
        list_count: u32,
    }
}

gpu_struct! {
    /// A composed run.
    pub struct Partial {
        rgba: [f32; 4],
        key: [u32; 4],
    }
}

pass! {
    /// Fragments per pixel.
    pub Count(crate::passes::raster::RasterPush) = "abuffer/count" {
        view: Uniform<View>,
        splats: Read<Splat>,
        tilts: Read<Tilt>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        tile_offsets: Read<u32>,
        counts: ReadWrite<u32>,
    }
}

pass! {
    /// The longest list.
    pub Measure(CountPush) = "abuffer/measure" {
        counts: Read<u32>,
        lengths: ReadWrite<Lengths>,
    }
}

pass! {
    /// Fragments into their pixels' slots.
    pub Store(crate::passes::raster::RasterPush) = "abuffer/store" {
        view: Uniform<View>,
        splats: Read<Splat>,
        tilts: Read<Tilt>,
        bounds: Read<Bounds>,
        large: Read<u32>,
        tile_offsets: Read<u32>,
        offsets: Read<u32>,
        counts: ReadWrite<u32>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Sorts and blends short lists.
    pub Resolve(BandPush) = "abuffer/resolve" {
        view: Uniform<View>,
        colors_0: Read<[f32; 4]>,
        colors_1: Read<[f32; 4]>,
        colors_2: Read<[f32; 4]>,
        colors_3: Read<[f32; 4]>,
        splats_0: Read<Splat>,
        splats_1: Read<Splat>,
        splats_2: Read<Splat>,
        splats_3: Read<Splat>,
        tilts_0: Read<Tilt>,
        tilts_1: Read<Tilt>,
        tilts_2: Read<Tilt>,
        tilts_3: Read<Tilt>,
        offsets: Read<u32>,
        fragments: Read<[u32; 2]>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

pass! {
    /// Lists the runs of long lists.
    pub Split(BandPush) = "abuffer/split" {
        offsets: Read<u32>,
        work: ReadWrite<LongWork>,
        runs: ReadWrite<ListRun>,
        lists: ReadWrite<LongList>,
    }
}

pass! {
    /// Counts to indirect arguments.
    pub Arguments = "abuffer/arguments" {
        work: ReadWrite<LongWork>,
    }
}

pass! {
    /// Sorts each run.
    pub SortRuns = "abuffer/sort-runs" in "abuffer/sort_runs" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Merges pairs of runs.
    pub Merge(MergePush) = "abuffer/merge" {
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        unmerged: Read<[u32; 2]>,
        merged: ReadWrite<[u32; 2]>,
    }
}

pass! {
    /// Blends each run.
    pub BlendRuns = "abuffer/blend-runs" in "abuffer/blend_runs" {
        view: Uniform<View>,
        colors_0: Read<[f32; 4]>,
        colors_1: Read<[f32; 4]>,
        colors_2: Read<[f32; 4]>,
        colors_3: Read<[f32; 4]>,
        splats_0: Read<Splat>,
        splats_1: Read<Splat>,
        splats_2: Read<Splat>,
        splats_3: Read<Splat>,
        tilts_0: Read<Tilt>,
        tilts_1: Read<Tilt>,
        tilts_2: Read<Tilt>,
        tilts_3: Read<Tilt>,
        work: ReadWrite<LongWork>,
        runs: Read<ListRun>,
        fragments: Read<[u32; 2]>,
        partials: ReadWrite<Partial>,
    }
}

pass! {
    /// Composes the runs of each long list.
    pub Combine = "abuffer/combine" {
        work: ReadWrite<LongWork>,
        lists: Read<LongList>,
        partials: Read<Partial>,
        image: ReadWrite<[f32; 4]>,
        depths: ReadWrite<f32>,
    }
}

/// The footprint of a disc's shape.
pub fn footprint(shape: DiscShape) -> Footprint {
    match shape {
        DiscShape::Flat => Footprint::Disc,
        DiscShape::Oriented => Footprint::Oriented,
    }
}

/// The variant of a stage that composes: windows over the points, shape and falloff.
pub fn compose_variant(windows: Windows, footprint: Footprint, falloff: Falloff) -> Variant {
    Variant::plain()
        .with("SHAPE", footprint as u32)
        .with("FALLOFF", u32::from(falloff == Falloff::Gaussian))
        .with("WINDOWS", windows.count)
        .with("WINDOW_LENGTH", windows.len)
}

/// The variant of `abuffer/resolve` for lists of `lowest` to `capacity` fragments.
pub fn resolve_variant(compose: Variant, lowest: u32, capacity: u32) -> Variant {
    compose.constant("LOWEST", lowest).constant("CAPACITY", capacity)
}

/// How per-point buffers are cut so that every point can be reached from one pass: 1 or 4 windows of `len` points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Windows {
    /// 1 or 4.
    pub count: u32,
    /// Points of a window.
    pub len: u32,
}

impl Windows {
    /// The windows for so many points on a device, or an error if four do not reach.
    pub fn new(device: &Device, points: u64) -> Result<Self, Error> {
        // Splats are the widest element; 64 of any element are a multiple of every offset alignment.
        let len = (device.limits().binding_bytes / size_of::<Splat>() as u64 & !63).min(1 << 30);
        let limit = 4 * len;
        if points > limit {
            return Err(Error::TooManyPoints { points, limit });
        }
        Ok(Self { count: if points <= len { 1 } else { 4 }, len: len as u32 })
    }

    /// The windows of a buffer; those beyond its end repeat its first element and are not read.
    pub fn of<T: gpu::GpuType>(self, buffer: &Buffer<T>) -> [Slice<'_, T>; 4] {
        let len = u64::from(self.len);
        std::array::from_fn(|i| {
            let start = i as u64 * len;
            if start < buffer.len() { buffer.slice(start, len.min(buffer.len() - start)) } else { buffer.slice(0, 1) }
        })
    }
}

/// Buffers of the A-buffer, kept from frame to frame.
pub struct ABuffer {
    counts: Kept<u32>,
    offsets: Kept<u32>,
    scan: Option<Scan>,
    overflow: Buffer<u32>,
    lengths: Buffer<Lengths>,
    summary: Buffer<u32>,
    tile_offsets: Kept<u32>,
    fragments: Kept<[u32; 2]>,
    merged: Kept<[u32; 2]>,
    runs: Kept<ListRun>,
    lists: Kept<LongList>,
    partials: Kept<Partial>,
    work: Buffer<LongWork>,
}

/// What count and scan found in a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Counted {
    overflow: bool,
    total: u32,
    lengths: Lengths,
}

impl Eq for Lengths {}

impl Counted {
    fn note(&self, bands: &[Band], facts: &mut Facts) {
        facts.bands += bands.len() as u64;
        facts.fragments += u64::from(self.total);
        facts.max_list = facts.max_list.max(self.lengths.longest);
    }
}

/// Everything that stays the same while a window is rendered.
pub struct WindowJob<'a> {
    /// The projected cloud.
    pub cloud: &'a DeviceCloud,
    /// What its projection found.
    pub stats: &'a [Stats],
    /// Shape and falloff.
    pub discs: Discs,
    /// Who visits pixels.
    pub walker: Walker,
    /// The rectangle.
    pub window: Window,
    /// The memory that may be used.
    pub budget: Budget,
}

/// What the stages before blending yield, for tests and inspection.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lists {
    /// Prefix sums of the list lengths: one more than pixels.
    pub offsets: Vec<u32>,
    /// Depth key and splat index of each fragment, in the order of arrival within a list.
    pub fragments: Vec<[u32; 2]>,
}

/// What became of a window.
pub enum Outcome {
    /// It is in the target.
    Done,
    /// A 32-bit sum overflowed: it must be cut.
    Overflow,
}

impl ABuffer {
    /// No buffers but the small ones yet.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self {
            counts: Kept::new("fragment counts", Memory::Device),
            offsets: Kept::new("fragment offsets", Memory::Device),
            scan: None,
            overflow: device.buffer("scan overflow", 1, Memory::Device)?,
            lengths: device.buffer("list lengths", 1, Memory::Device)?,
            summary: device.buffer("fragment summary", 4, Memory::Readback)?,
            tile_offsets: Kept::new("tile offsets", Memory::Device),
            fragments: Kept::new("fragments", Memory::Device),
            merged: Kept::new("merged fragments", Memory::Device),
            runs: Kept::new("list runs", Memory::Device),
            lists: Kept::new("long lists", Memory::Device),
            partials: Kept::new("partial sums", Memory::Device),
            work: device.buffer("long work", 1, Memory::Device)?,
        })
    }

    /// Counts, then stores, sorts and blends band by band into the target.
    pub fn render(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        target: &Target,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        let counted = self.count(device, job, timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(device, job, &counted)?;
        self.reserve_fragments(device, &bands, &counted)?;
        counted.note(&bands, facts);
        facts.fragment_bytes = facts.fragment_bytes.max(self.fragments.get().bytes());
        for (i, band) in bands.iter().enumerate() {
            let mut recorder = device.recorder()?;
            self.record_store(&mut recorder, job, band)?;
            self.record_blend(&mut recorder, device, job, target, band, &counted)?;
            if i + 1 == bands.len() {
                target.record_read_back(&mut recorder, bands::pixels(job.window))?;
            }
            timeline.add(recorder.submit("abuffer/store and blend")?);
        }
        Ok(Outcome::Done)
    }

    /// Counts and plans the bands; stores nothing.
    pub fn survey(
        &mut self,
        device: &Device,
        job: &WindowJob<'_>,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        let counted = self.count(device, job, timeline)?;
        if counted.overflow {
            return Ok(Outcome::Overflow);
        }
        let bands = self.plan_bands(device, job, &counted)?;
        counted.note(&bands, facts);
        Ok(Outcome::Done)
    }

    /// Fragment counts of every pixel of the window, in its order; what the last count left, read from the prefix sums.
    pub fn read_counts(&self, window: Window) -> Result<Vec<u32>, Error> {
        let offsets = self.offsets.get().read(0, bands::pixels(window) + 1)?;
        Ok(offsets.windows(2).map(|w| w[1] - w[0]).collect())
    }

    /// Count, scan and store of a window that fits as one band, without sorting or blending.
    pub fn lists(&mut self, device: &Device, job: &WindowJob<'_>) -> Result<Lists, Error> {
        let mut timeline = Timeline::default();
        let counted = self.count(device, job, &mut timeline)?;
        let pixels = bands::pixels(job.window);
        let band = Band { pixels: [0, pixels as u32], fragments: u64::from(counted.total) };
        self.reserve_fragments(device, &[band], &counted)?;
        let mut recorder = device.recorder()?;
        self.record_store(&mut recorder, job, &band)?;
        recorder.submit("abuffer/store")?;
        Ok(Lists {
            offsets: self.offsets.get().read(0, pixels + 1)?,
            fragments: self.fragments.get().read(0, u64::from(counted.total))?,
        })
    }

    fn count(&mut self, device: &Device, job: &WindowJob<'_>, timeline: &mut Timeline) -> Result<Counted, Error> {
        let pixels = bands::pixels(job.window);
        let longest_scan = (pixels + 1).max(job.stats.iter().map(|s| u64::from(s.large)).max().unwrap_or(0));
        self.counts.reserve(device, pixels + 1)?;
        self.offsets.reserve(device, pixels + 1)?;
        self.tile_offsets.reserve(device, tile_offsets_len(job.stats))?;
        if self.scan.as_ref().is_none_or(|s| s.capacity() < longest_scan) {
            self.scan = None;
            self.scan = Some(Scan::new(device, longest_scan)?);
        }
        let (Some(scan), counts, offsets) = (&self.scan, self.counts.get(), self.offsets.get()) else {
            unreachable!("the scan was made above")
        };

        let mut recorder = device.recorder()?;
        let tiled = self.tiled(job);
        recorder.fill("abuffer/clear", counts.slice(0, pixels + 1), 0)?;
        recorder.fill("abuffer/clear", self.overflow.all(), 0)?;
        recorder.fill("abuffer/clear", self.lengths.all(), 0)?;
        tiled.record_tiles(&mut recorder, scan, self.overflow.all())?;
        tiled.record(&mut recorder, [0, pixels as u32], |c: Chunk<'_>| Count {
            view: c.view,
            splats: c.splats,
            tilts: c.tilts,
            bounds: c.bounds,
            large: c.large,
            tile_offsets: c.tile_offsets,
            counts: counts.all(),
        })?;
        let measure =
            Run::new(Dispatch::Invocations(pixels.div_ceil(MEASURE_RUN))).push(&CountPush { count: pixels as u32 });
        recorder
            .run(&Measure { counts: counts.all(), lengths: self.lengths.all() }, &measure.variant(measure_variant()))?;
        scan.record(&mut recorder, counts.slice(0, pixels + 1), offsets.slice(0, pixels + 1), self.overflow.all())?;
        recorder.copy("abuffer/summary", self.overflow.all(), self.summary.slice(0, 1))?;
        recorder.copy("abuffer/summary", self.lengths.all().cast(), self.summary.slice(1, 2))?;
        recorder.copy("abuffer/summary", offsets.slice(pixels, 1), self.summary.slice(3, 1))?;
        timeline.add(recorder.submit("abuffer/count and scan")?);
        let words = self.summary.mapped_slice();
        Ok(Counted {
            overflow: words[0] != 0,
            lengths: Lengths { longest: words[1], in_long_lists: words[2] },
            total: words[3],
        })
    }

    fn tiled<'a>(&'a self, job: &WindowJob<'a>) -> Tiled<'a> {
        Tiled::new(job.cloud, job.stats, self.tile_offsets.get(), job.walker, footprint(job.discs.shape), job.window)
    }

    /// Bytes that a band needs per fragment: twice the fragment and the runs' records where long lists are merged.
    fn bytes_per_fragment(counted: &Counted) -> u64 {
        if counted.lengths.in_long_lists > 0 { 2 * FRAGMENT_BYTES + 1 } else { FRAGMENT_BYTES }
    }

    fn plan_bands(&self, device: &Device, job: &WindowJob<'_>, counted: &Counted) -> Result<Vec<Band>, Error> {
        let pixels = bands::pixels(job.window);
        let tiles = self.tile_offsets.get().bytes();
        let used = pixels * PIXEL_BYTES + tiles;
        let left = job.budget.left(used);
        let each = Self::bytes_per_fragment(counted);
        let capacity = (left / each).min(device.limits().binding_bytes / FRAGMENT_BYTES);
        if u64::from(counted.total) <= capacity {
            return Ok(vec![Band { pixels: [0, pixels as u32], fragments: u64::from(counted.total) }]);
        }
        let offsets = self.offsets.get().read(0, pixels + 1)?;
        bands::bands(&offsets, capacity).map_err(|(pixel, length)| {
            let [x, y] = bands::place(job.window, pixel);
            let needed = u64::from(length) * each;
            Error::PixelOverBudget {
                x,
                y,
                length,
                needed,
                available: capacity * each,
                budget: Budget::wanted(tiles, needed),
            }
        })
    }

    fn reserve_fragments(&mut self, device: &Device, bands: &[Band], counted: &Counted) -> Result<(), Error> {
        let most = bands.iter().map(|b| b.fragments).max().unwrap_or(0).max(1);
        self.fragments.reserve(device, most)?;
        if counted.lengths.in_long_lists > 0 {
            let long = most.min(u64::from(counted.lengths.in_long_lists));
            let local = u64::from(LOCAL_LENGTH);
            // A long list has more than `local` fragments, so it fills more than half of its runs.
            let runs = (2 * long).div_ceil(local);
            self.merged.reserve(device, most)?;
            self.runs.reserve(device, runs)?;
            self.lists.reserve(device, long.div_ceil(local))?;
            self.partials.reserve(device, runs)?;
        }
        Ok(())
    }

    fn record_store<'a>(&'a self, recorder: &mut Recorder<'a>, job: &WindowJob<'a>, band: &Band) -> Result<(), Error> {
        if band.fragments == 0 {
            return Ok(());
        }
        Ok(self.tiled(job).record(recorder, band.pixels, |c: Chunk<'a>| Store {
            view: c.view,
            splats: c.splats,
            tilts: c.tilts,
            bounds: c.bounds,
            large: c.large,
            tile_offsets: c.tile_offsets,
            offsets: self.offsets.get().all(),
            counts: self.counts.get().all(),
            fragments: self.fragments.get().all(),
        })?)
    }

    fn record_blend<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        device: &Device,
        job: &WindowJob<'a>,
        target: &'a Target,
        band: &Band,
        counted: &Counted,
    ) -> Result<(), Error> {
        let windows = Windows::new(device, job.cloud.len())?;
        let compose = compose_variant(windows, footprint(job.discs.shape), job.discs.falloff);
        let [colors_0, colors_1, colors_2, colors_3] = windows.of(&job.cloud.colors);
        let [splats_0, splats_1, splats_2, splats_3] = windows.of(&job.cloud.splats);
        let [tilts_0, tilts_1, tilts_2, tilts_3] = windows.of(&job.cloud.tilts);
        let view = job.cloud.view();
        let (offsets, fragments) = (self.offsets.get().all(), self.fragments.get().all());
        let push = BandPush { band_start: band.pixels[0], band_end: band.pixels[1] };
        let over_band = |variant| {
            Run::new(Dispatch::Invocations(u64::from(band.pixels[1] - band.pixels[0]))).push(&push).variant(variant)
        };
        let resolve = Resolve {
            view,
            colors_0,
            colors_1,
            colors_2,
            colors_3,
            splats_0,
            splats_1,
            splats_2,
            splats_3,
            tilts_0,
            tilts_1,
            tilts_2,
            tilts_3,
            offsets,
            fragments,
            image: target.image(),
            depths: target.depths(),
        };
        for (lowest, capacity) in classes(counted.lengths.longest) {
            recorder.run(&resolve, &over_band(resolve_variant(compose.clone(), lowest, capacity)))?;
        }
        if counted.lengths.in_long_lists == 0 {
            return Ok(());
        }

        let (work, runs, lists) = (self.work.all(), self.runs.get().all(), self.lists.get().all());
        let partials = self.partials.get().all();
        let over_runs = Run::new(Dispatch::Indirect(self.work.all().cast().first(3)));
        recorder.fill("abuffer/clear", work, 0)?;
        recorder.run(&Split { offsets, work, runs, lists }, &over_band(Variant::plain()))?;
        recorder.run(&Arguments { work }, &Run::new(Dispatch::Groups(1)))?;
        recorder.run(&SortRuns { work, runs, fragments }, &over_runs.clone().variant(sort_runs_variant()))?;
        let (mut unmerged, mut merged) = (fragments, self.merged.get().all());
        let mut width = LOCAL_LENGTH;
        while width < counted.lengths.longest {
            recorder.run(&Merge { work, runs, unmerged, merged }, &over_runs.clone().push(&MergePush { width }))?;
            (unmerged, merged) = (merged, unmerged);
            width = width.saturating_mul(2);
        }
        let blend = BlendRuns {
            view,
            colors_0,
            colors_1,
            colors_2,
            colors_3,
            splats_0,
            splats_1,
            splats_2,
            splats_3,
            tilts_0,
            tilts_1,
            tilts_2,
            tilts_3,
            work,
            runs,
            fragments: unmerged,
            partials,
        };
        recorder.run(&blend, &over_runs.variant(compose))?;
        let over_lists = Run::new(Dispatch::Indirect(self.work.all().cast().skip(4).first(3)));
        recorder
            .run(&Combine { work, lists, partials, image: target.image(), depths: target.depths() }, &over_lists)?;
        Ok(())
    }
}

/// The classes of short lists, each with its array: the shortest and longest length. Pixels without fragments are in the first.
fn classes(longest: u32) -> Vec<(u32, u32)> {
    let mut found = vec![(0, SHORT_LENGTH)];
    if longest > SHORT_LENGTH {
        found.push((SHORT_LENGTH + 1, longest.min(LOCAL_LENGTH).next_power_of_two()));
    }
    found
}

/// The capacities that [`classes`] can ask for.
pub fn capacities() -> impl Iterator<Item = (u32, u32)> {
    [(0, SHORT_LENGTH)].into_iter().chain([64, 128, LOCAL_LENGTH].map(|c| (SHORT_LENGTH + 1, c)))
}

/// The variant of `abuffer/measure`.
pub fn measure_variant() -> Variant {
    Variant::plain().with("RUN", MEASURE_RUN as f64)
}

/// The variant of `abuffer/sort-runs`.
pub fn sort_runs_variant() -> Variant {
    Variant::plain().constant("CAPACITY", LOCAL_LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_cover_every_short_length_once() {
        for longest in 0..=300 {
            let found = classes(longest);
            for n in 0..=longest.min(LOCAL_LENGTH) {
                assert_eq!(
                    found.iter().filter(|(low, high)| (*low..=*high).contains(&n)).count(),
                    1,
                    "{n} of {longest}"
                );
            }
            assert!(found.iter().all(|c| capacities().any(|k| k == *c)), "{found:?}");
        }
    }
}
