//! `image-space`: 1-pixel points whose holes are closed by filters of the image (Dobrev, Rosenthal, Linsen 2010,
//! Section 3). Layers of such images are blended by [`super::peel_layers`].
//!
//! An image is kept in tiles of 16 × 16 pixels, each of which knows its range of depths and whether it has background.
//! Before each run of a filter a work list is made of the tiles that it may change, and the filter is dispatched
//! indirectly over it. A filter that runs until nothing changes is recorded as often as it may run: after a run that
//! changed nothing all lists are empty. A tile has two places: a filter reads one and writes the other, so that nothing
//! is copied, and tiles that are not listed cost nothing.

mod engine;
mod passes;
pub mod windows;

pub(crate) use engine::{Filtering, ImageSpaceEngine, finish, pass_group};
pub(crate) use passes::CONSTANTS;
use passes::resolve_variant;

pub use passes::{
    Antialias, Deliver, DeliverPush, Fill, Filter, FilterPush, List, ListPush, Listed, Measure, Occlusion, Resolve,
    ResolvePush, Smooth, Tiled, TiledGroup, shaders,
};

use super::opaque::NearestSplat;
use super::own::FamilyBuffers;
use super::peel::PeelWork;
use super::points::{self, Choice};
use crate::methods::prelude::*;
use crate::scene::ImageSpace;
use windows::TILE;

/// Pixels of a tile.
const AREA: u64 = (TILE * TILE) as u64;
/// Bytes per pixel of a window and its halo: nearest point, and two places for depth and color.
const PIXEL_BYTES: u64 = 8 + 2 * (4 + 16);
/// Additional bytes per pixel where layers are peeled: limit, and number of layers.
const LAYER_BYTES: u64 = 4 + 4;
/// Bytes per tile: its properties, and its place in the work list.
const TILE_BYTES: u64 = 16 + 8;
/// Most tiles of a window, so that one dimension of workgroups holds them on every device.
const MOST_TILES: u64 = 65_535;
/// Words of a window's totals: tiles of each filter, and the last run of background fill and of occlusion fill that had
/// any.
const TOTALS: u64 = 6;
/// Names of the filters' fills and copies.
const CLEAR: &str = "image-space/clear";

/// Returns how far the filters of a frame reach, in pixels: as far as a pixel of the last layer depends on points.
/// Smoothing and antialiasing change no depth, so that no later layer depends on them.
pub fn halo(filters: &ImageSpace, layers: u32) -> u32 {
    let closing = (filters.fill.most() + filters.occlusion.most()).saturating_mul(layers);
    closing.saturating_add(filters.smooth + u32::from(filters.antialias))
}

/// Cuts a frame into windows whose images fit, with their halos.
///
/// # Errors
/// The halo of a single pixel does not fit.
fn frame_windows(size: [u32; 2], filtering: &Filtering, budget: Budget) -> Result<Vec<Window>, Error> {
    let layer_bytes = if filtering.layers.is_some() { LAYER_BYTES } else { 0 };
    let tile_bytes = TILE_BYTES + AREA * (PIXEL_BYTES + layer_bytes);
    let bound = (budget.binding / size_of::<[f32; 4]>() as u64).saturating_sub(1) / (2 * AREA);
    let limit = bound.min(MOST_TILES);
    let halo = filtering.halo();
    let within = |bytes: u64| windows::windows(size, (bytes / tile_bytes).min(limit).max(1), halo);
    // Half of it, unless only all of it will do.
    within(budget.bytes / 2).or_else(|| within(budget.bytes)).ok_or_else(|| {
        let tiles = windows::fewest_tiles(size, halo);
        if tiles > limit {
            return Error::HaloTooLarge { halo, tiles, limit };
        }
        Error::HaloOverBudget { halo, needed: tiles * tile_bytes, available: budget.bytes }
    })
}

/// Input and settings of a window.
#[derive(Clone, Copy)]
pub struct FilterJob<'a> {
    /// The cloud, whose view is set to `outer`.
    pub cloud: &'a DeviceCloud,
    /// Result that is delivered.
    pub window: Window,
    /// The window with its halo: the rectangle that is rendered.
    pub outer: Window,
    /// Settings of how points are shaded.
    pub how: &'a Projecting,
    /// The filters.
    pub filters: ImageSpace,
    /// d̃ in world units.
    pub distance: f32,
    /// Depth of background where edges are looked for.
    pub far: f32,
    /// `true` if 64-bit atomics are used.
    pub wide: bool,
    /// `true` if opacities count.
    pub transparent: bool,
}

impl FilterJob<'_> {
    pub(super) fn tiles(&self) -> [u32; 2] {
        windows::tiles(self.outer)
    }

    pub(super) fn tile_count(&self) -> u64 {
        let [columns, rows] = self.tiles();
        u64::from(columns) * u64::from(rows)
    }

    /// Returns the size of the rendered rectangle, in pixels.
    pub(super) fn outer_size(&self) -> [u32; 2] {
        [self.outer[2] - self.outer[0], self.outer[3] - self.outer[1]]
    }

    pub(super) fn deliver_push(&self) -> DeliverPush {
        let ([columns, _], window) = (self.tiles(), self.window);
        DeliverPush {
            columns,
            tiles: self.tile_count() as u32,
            left: window[0] - self.outer[0],
            top: window[1] - self.outer[1],
            width: window[2] - window[0],
            height: window[3] - window[1],
        }
    }

    /// The filters in the order of their runs, with the number of their iterations.
    fn runs(&self) -> [(Filter, u32); 4] {
        let ImageSpace { fill, occlusion, smooth, antialias, .. } = self.filters;
        let iterations = [fill.most(), occlusion.most(), smooth, u32::from(antialias)];
        std::array::from_fn(|i| (Filter::ALL[i], iterations[i]))
    }

    /// Work lists of a layer: of the resolve, of the filters' runs, numbered from 1, and of the delivery.
    fn slot_count(&self) -> u32 {
        self.deliver_slot() + 1
    }

    fn deliver_slot(&self) -> u32 {
        1 + self.runs().iter().map(|(_, iterations)| iterations).sum::<u32>()
    }

    /// Returns the dispatch for everything that goes through all tiles, before there are lists.
    pub(super) fn measure_dispatch(&self) -> Dispatch<'static> {
        Dispatch::Groups(self.tile_count())
    }

    pub(super) fn list_dispatch(&self) -> Dispatch<'static> {
        Dispatch::Invocations(self.tile_count())
    }
}

/// Dispatches of a layer that the device may empty.
#[derive(Clone, Copy)]
pub(super) struct Emptied<'a> {
    /// Indirect arguments of the passes that find the nearest points, four words for each chunk.
    pub nearest: Slice<'a, u32>,
    pub measure: Slice<'a, u32>,
    pub list: Slice<'a, u32>,
}

fields! {
    /// Buffers of filtered images, kept from frame to frame.
    pub struct Filterer by device {
        pub(super) nearest: Scratch<NearestSplat> = Scratch::new("nearest points", Memory::Device),
        tiles: Scratch<[u32; 4]> = Scratch::new("image tiles", Memory::Device),
        pub(super) depths: Scratch<f32> = Scratch::new("tile depths", Memory::Device),
        pub(super) colors: Scratch<[f32; 4]> = Scratch::new("tile colors", Memory::Device),
        pub(super) entries: Scratch<[u32; 2]> = Scratch::new("listed tiles", Memory::Device),
        slots: Scratch<u32> = Scratch::new("filter dispatches", Memory::Device),
        totals: Buffer<u32> = device.buffer("filtered tiles", TOTALS, Memory::Device)?,
        totals_host: Buffer<u32> = device.buffer("filtered tiles, host", TOTALS, Memory::Readback)?,
        pub(super) work: Buffer<PeelWork> = device.buffer("layer work", 1, Memory::Device)?,
    }
}

impl FamilyBuffers for Filterer {
    fn made(device: &Device) -> Result<Self, Error> {
        Ok(Self::new(device)?)
    }
}

impl Filterer {
    /// Renders a window of one opaque image, which a survey does not bring to the target.
    pub(crate) fn render(&mut self, work: &mut Work<'_>, job: &FilterJob<'_>) -> Result<(), Error> {
        let device = work.device;
        self.reserve(device, job)?;
        let mut recorder = work.timeline.recorder(device)?;
        self.record_clear(&mut recorder, job)?;
        let cut = Cut::new(device, job.cloud.len())?;
        self.record_points(&mut recorder, job, (None, None))?;
        self.record_image(&mut recorder, job, cut, None)?;
        job.cloud.record_stats(&mut recorder)?;
        self.record_summary(&mut recorder)?;
        if !work.survey {
            let target = work.target;
            let pixels = bands::pixels(job.window);
            target.pixels().record_nothing(&mut recorder, job.window)?;
            let (entries, depths, colors) = (self.entries.get().all(), self.depths(job), self.colors(job));
            let (image, image_depths) = (target.image(), target.depths());
            let deliver = Deliver { entries, depths, colors, image, image_depths };
            recorder.run(&deliver, job.deliver_push(), &Run::new(self.deliver_dispatch(job)))?;
            target.record_read_back(&mut recorder, pixels)?;
        }
        work.timeline.submit(recorder, "points and filters")?;
        self.note(job, 1, work.facts);
        Ok(())
    }

    pub(super) fn reserve(&mut self, device: &Device, job: &FilterJob<'_>) -> Result<(), Error> {
        let tiles = job.tile_count();
        self.nearest.reserve(device, bands::pixels(job.outer))?;
        self.tiles.reserve(device, tiles)?;
        self.entries.reserve(device, tiles)?;
        self.depths.reserve(device, Self::places(job) + 1)?;
        self.colors.reserve(device, Self::places(job) + 1)?;
        self.slots.reserve(device, 4 * u64::from(job.slot_count()))?;
        Ok(())
    }

    /// Pixels of both sides of all tiles.
    fn places(job: &FilterJob<'_>) -> u64 {
        2 * AREA * job.tile_count()
    }

    pub(super) fn depths(&self, job: &FilterJob<'_>) -> Slice<'_, f32> {
        self.depths.get().slice(0, Self::places(job) + 1)
    }

    pub(super) fn colors(&self, job: &FilterJob<'_>) -> Slice<'_, [f32; 4]> {
        self.colors.get().slice(0, Self::places(job) + 1)
    }

    /// Returns the nearest points of the pixels that are rendered.
    pub(super) fn nearest(&self, job: &FilterJob<'_>) -> Slice<'_, NearestSplat> {
        self.nearest.get().slice(0, bands::pixels(job.outer))
    }

    /// Records that the image is empty, and the pixel that stands for everything outside of it.
    pub(super) fn record_clear<'a>(&'a self, recorder: &mut Recorder<'a>, job: &FilterJob<'a>) -> Result<(), Error> {
        job.cloud.record_clear(recorder)?;
        let outside = Self::places(job);
        let fills = [
            (self.nearest(job).cast(), u32::MAX),
            (self.totals.all().cast(), 0),
            (self.work.all().cast(), 0),
            (self.depths.get().slice(outside, 1).cast(), f32::INFINITY.to_bits()),
            (self.colors.get().slice(outside, 1).cast(), BACKGROUND_ALPHA.to_bits()),
        ];
        Ok(recorder.fill_all(CLEAR, &fills)?)
    }

    /// Records the copy of the numbers of listed tiles to the host, for [`Self::note`].
    pub(super) fn record_summary<'a>(&'a self, recorder: &mut Recorder<'a>) -> Result<(), Error> {
        recorder.copy("image-space/summary", self.totals.all(), self.totals_host.all())?;
        Ok(())
    }

    /// Adds what the filters of a window had, of whose image there were so many layers.
    pub(super) fn note(&self, job: &FilterJob<'_>, layers: u32, facts: &mut Facts) {
        facts.image_tiles += job.tile_count() * u64::from(layers);
        let totals = self.totals_host.mapped_slice();
        for (sum, listed) in facts.filtered_tiles.iter_mut().zip(totals) {
            *sum += u64::from(*listed);
        }
        // Runs are numbered from 1, those of the second filter behind all of the first.
        let before = [0, job.filters.fill.most()];
        for (most, (last, before)) in facts.closing_runs.iter_mut().zip(totals[4..].iter().zip(before)) {
            *most = (*most).max(last.saturating_sub(before));
        }
    }

    /// Records the points of a layer: of a later one with limits, and of one whose dispatches the device may empty,
    /// with these.
    pub(super) fn record_points<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &FilterJob<'a>,
        (limits, emptied): (Option<Slice<'a, u32>>, Option<Emptied<'a>>),
    ) -> Result<(), Error> {
        let choice = Choice { cull: job.filters.cull, limits, dispatches: emptied.map(|e| e.nearest), several: None };
        points::record_nearest(recorder, job.cloud, self.nearest(job), job.wide, &choice)?;
        let (nearest, tiles) = (self.nearest(job).cast(), self.tiles.get().all());
        let dispatch = emptied.map_or(job.measure_dispatch(), |e| Dispatch::Indirect(e.measure));
        let measure = Measure { nearest, tiles, work: self.work.all() };
        Ok(recorder.run(&measure, Self::resolve_push(job), &Run::new(dispatch))?)
    }

    fn resolve_push(job: &FilterJob<'_>) -> ResolvePush {
        let [width, height] = job.outer_size();
        ResolvePush { columns: job.tiles()[0], width, height }
    }

    /// Records colors and depths of the points that were found.
    fn record_resolve<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &FilterJob<'a>,
        cut: Cut,
        emptied: Option<Emptied<'a>>,
    ) -> Result<(), Error> {
        let cloud = job.cloud;
        self.record_list(recorder, job, Listed::Resolve, (0, 0), emptied)?;
        let resolve = Resolve {
            camera: cloud.view(),
            points_hi: cut.slices(&cloud.points_hi),
            points_lo: cut.slices(&cloud.points_lo),
            point_colors: cut.slices(&cloud.point_colors),
            normals: cut.slices(&cloud.normals),
            nearest: self.nearest(job).cast(),
            entries: self.entries.get().all(),
            depths: self.depths(job),
            colors: self.colors(job),
        };
        let variant = resolve_variant(job.how.shaded(cloud.has_normals()).cut(cut), job.transparent);
        let run = Run::new(self.listed_dispatch(0)).variant(variant);
        Ok(recorder.run(&resolve, Self::resolve_push(job), &run)?)
    }

    /// The tiles of a work list.
    fn listed_dispatch(&self, slot: u32) -> Dispatch<'_> {
        Dispatch::Indirect(self.slots.get().slice(4 * u64::from(slot), 3))
    }

    /// Returns the tiles of a filtered image that are not background alone.
    pub(super) fn deliver_dispatch(&self, job: &FilterJob<'_>) -> Dispatch<'_> {
        self.listed_dispatch(job.deliver_slot())
    }

    /// Records the image of the points found, its filters, and the list of tiles to deliver.
    pub(super) fn record_image<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &FilterJob<'a>,
        cut: Cut,
        emptied: Option<Emptied<'a>>,
    ) -> Result<(), Error> {
        recorder.fill(CLEAR, self.slots.get().all(), 0)?;
        self.record_resolve(recorder, job, cut, emptied)?;
        let mut run = 0;
        for (filter, iterations) in job.runs() {
            for iteration in 0..iterations {
                run += 1;
                let before = if iteration > 0 && filter.is_settling() { run - 1 } else { 0 };
                self.record_list(recorder, job, Listed::Filter(filter), (run, before), emptied)?;
                self.record_filter(recorder, job, filter, run)?;
            }
        }
        self.record_list(recorder, job, Listed::Deliver, (job.deliver_slot(), 0), emptied)
    }

    fn record_list<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &FilterJob<'a>,
        listed: Listed,
        (slot, before): (u32, u32),
        emptied: Option<Emptied<'a>>,
    ) -> Result<(), Error> {
        let list = List {
            tiles: self.tiles.get().all(),
            entries: self.entries.get().all(),
            arguments: self.slots.get().all(),
            totals: self.totals.all(),
        };
        let [columns, rows] = job.tiles();
        let (distance, threshold) = (job.distance, job.filters.antialias_threshold);
        let push = ListPush { columns, rows, before, slot, distance, threshold };
        let dispatch = emptied.map_or(job.list_dispatch(), |e| Dispatch::Indirect(e.list));
        Ok(recorder.run(&list, push, &Run::new(dispatch).variant(listed.variant()))?)
    }

    fn record_filter<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        job: &FilterJob<'a>,
        filter: Filter,
        run: u32,
    ) -> Result<(), Error> {
        let (entries, tiles) = (self.entries.get().all(), self.tiles.get().all());
        let tiled = Tiled { entries, tiles, depths: self.depths(job), colors: self.colors(job) };
        let [width, height] = job.outer_size();
        let push = FilterPush {
            columns: job.tiles()[0],
            tiles: job.tile_count() as u32,
            width,
            height,
            run,
            distance: job.distance,
            far: job.far,
            threshold: job.filters.antialias_threshold,
        };
        let how = Run::new(self.listed_dispatch(run));
        match filter {
            Filter::Fill => recorder.run(&Fill { tiled }, push, &how)?,
            Filter::Occlusion => recorder.run(&Occlusion { tiled }, push, &how)?,
            Filter::Smooth => recorder.run(&Smooth { tiled }, push, &how)?,
            Filter::Antialias => recorder.run(&Antialias { tiled }, push, &how)?,
        }
        Ok(())
    }
}

/// Alpha of background between filters: a point of no opacity is not background.
const BACKGROUND_ALPHA: f32 = -1.0;

/// Floats that shaders know of this module.
pub(crate) const FLOATS: [(&str, f32); 1] = [("BACKGROUND_ALPHA", BACKGROUND_ALPHA)];

/// Returns the number of bytes that a pass must at least read and write: those of filters by the tiles that they had.
pub fn least_bytes(name: &str, facts: &Facts, cloud: &DeviceCloud, cull: bool) -> Option<u64> {
    let [fill, occlusion, smooth, antialias] = facts.filtered_tiles.map(|tiles| tiles * AREA);
    let normals = if cull && cloud.has_normals() { 16 } else { 0 };
    match name {
        // Later layers visit the points again, but how many layers each window had is not known.
        "points/nearest" if facts.layers <= 1 => {
            Some(facts.points * (32 + normals) * facts.windows.max(1) + facts.visible * 8)
        }
        "image-space/measure" => Some(facts.image_tiles * AREA * 8),
        "image-space/fill" => Some(fill * 2 * 20),
        "image-space/occlusion" => Some(occlusion * 2 * 20),
        "image-space/smooth" => Some(smooth * 2 * 16),
        "image-space/antialias" => Some(antialias * (4 + 2 * 16)),
        _ => None,
    }
}
