//! The engine of lists of fragments: `abuffer` and `linked-list`.

use std::cell::OnceCell;

use super::abuffer::{
    self, InOrder, Lists, ListsJob, PIXEL_BYTES, RUN_PIXEL_BYTES, Shown, Slots, StoreFragments, list_bytes,
};
use super::ellipsoids::Ellipsoids;
use super::linked_list::LinkedLists;
use super::projecting::discs as projecting;
use crate::methods::prelude::*;
use crate::methods::projected::project;
use crate::methods::{Stop, tiled};
use crate::scene::{Peel, Raster as Way};

/// Pixels of a splat's rectangle, on average, from which on an A-buffer is filled tile by tile (measured on lavapipe).
const ORDERED_AREA: u64 = 32;

/// Lists of fragments, each pixel's sorted and blended.
pub(crate) struct ListEngine {
    /// The discs.
    pub discs: Discs,
    /// `true` if fragments are stored in linked lists.
    pub linked: bool,
    /// The depths that pixels get.
    pub shown: Shown,
}

impl ListEngine {
    /// Returns the engine that finds other depths than the first fragment's in the images of a method, by the same
    /// fragments in the same order. `None` for methods whose images don't follow from sorted lists of all fragments.
    pub fn showing(method: &Method, shown: Shown) -> Option<Self> {
        let merged = |discs| Discs { long_lists: LongLists::Merge, ..discs };
        let (discs, linked) = match *method {
            Method::ABuffer(discs) => (discs, false),
            Method::LinkedList(discs) => (discs, true),
            Method::Peel(Peel { discs, layers: 0 }) => (merged(discs), false),
            // Oriented discs that cross are not in the order of their depths.
            Method::Sorted(discs) if discs.shape == DiscShape::Flat => {
                (Discs { raster: Way::Auto, ..merged(discs) }, false)
            }
            _ => return None,
        };
        Some(Self { discs, linked, shown })
    }

    fn storing(&self, cloud: &DeviceCloud) -> &'static dyn StoreFragments {
        match (self.linked, self.are_ellipsoids(cloud)) {
            (true, true) => &Ellipsoids { linked: true },
            (false, true) => &Ellipsoids { linked: false },
            (true, false) => &LinkedLists,
            (false, false) => &Slots,
        }
    }

    fn are_ellipsoids(&self, cloud: &DeviceCloud) -> bool {
        cloud.has_gaussians() && self.discs.gaussians.kernel == Kernel::Ellipsoid
    }

    /// Ellipsoids have no stage for the rasterizer.
    fn walker(&self, device: &Device, cloud: &DeviceCloud, window: Window) -> Result<Walker, Error> {
        if self.are_ellipsoids(cloud) { Ok(Walker::Compute) } else { walker(device, self.discs.raster, window) }
    }

    /// Returns `true` if lists are filled tile by tile from sorted splats. Only flat discs then arrive in blending
    /// order, and it only pays for large splats.
    fn in_order(&self, device: &Device, frame: &Frame, job: &bin::Job<'_>) -> bool {
        let visible: u64 = job.raster.stats.iter().map(|s| u64::from(s.visible)).sum();
        // Only lists of fragments tell other depths than the first, and frames that ask for some go through the lists
        // more than once, in the same way.
        !self.linked
            && self.shown == Shown::First
            && !frame.shading.edl.edl
            && !frame.depths
            && job.raster.footprint == Footprint::Disc
            && self.discs.long_lists == LongLists::Merge
            && job.raster.walker == Walker::Compute
            && device.info().subgroup.is_some()
            && job.raster.cloud.len() <= bin::most_points(device)
            && Stats::area(job.raster.stats) >= visible.max(1) * ORDERED_AREA
            && Bins::least_bytes(device, job) <= job.budget.left(0) / 4
    }

    /// Returns the lists of a frame that fits in one window and band, before sorting.
    pub fn lists(
        &self,
        device: &Device,
        cloud: &mut DeviceCloud,
        buffers: &mut Buffers,
        (frame, budget): (&Frame, Budget),
        timeline: &mut Timeline,
    ) -> Result<Lists, Error> {
        let [width, height] = frame.size;
        let (window, how) = ([0, 0, width, height], projecting(frame, cloud, &self.discs));
        let stats = project(device, cloud, (frame, window), &how, timeline)?;
        let walker = self.walker(device, cloud, window)?;
        buffers.tiles.reserve(device, &stats)?;
        let tiles = &buffers.tiles;
        let raster = Raster { cloud, stats: &stats, tiles, walker, footprint: how.footprint, window };
        let stop = compose::stop(Stop::Exact, frame.color, 1.0);
        let job = ListsJob {
            raster,
            discs: self.discs,
            storing: self.storing(cloud),
            stop,
            shown: self.shown,
            budget,
            samples: None,
        };
        buffers.resources.lists.lists(device, &job, timeline)
    }
}

impl Engine for ListEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        if self.discs.gaussians.kernel == Kernel::Ellipsoid {
            // Should there be some: each pixel has a run, whose sums take three times as much of a binding as a pixel's
            // color.
            let budget = Budget { binding: budget.binding / 4, ..budget };
            return Ok(windows_of(frame, budget, PIXEL_BYTES + RUN_PIXEL_BYTES));
        }
        Ok(windows_of(frame, budget, PIXEL_BYTES))
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_WITHIN
    }

    fn render(
        &self,
        cloud: &mut DeviceCloud,
        Buffers { tiles, resources: Resources { lists, bins, .. } }: &mut Buffers,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let (device, frame, window) = (work.device, work.frame, work.window);
        let how = projecting(frame, cloud, &self.discs);
        let stats = work.project(cloud, &how)?;
        let walker = self.walker(device, cloud, window)?;
        let visited = walker == Walker::Compute;
        let Some(budget) = work.reserve_tiles(tiles, &stats, visited)? else {
            return Ok(Outcome::Overflow);
        };
        let raster = Raster { cloud, stats: &stats, tiles, walker, footprint: how.footprint, window };
        let stop = compose::stop(frame.stop, frame.color, cloud.max_color(&how));
        let (storing, shown) = (self.storing(cloud), self.shown);
        let mut job = ListsJob { raster, discs: self.discs, storing, stop, shown, budget, samples: None };
        let counted_bytes = bands::pixels(window) * PIXEL_BYTES;
        let bin = bin::Job { raster, order: Order::Depth, depth_range: frame.key_range(), budget, counted_bytes };
        let (mut ordered, in_order) = (0, OnceCell::new());
        if self.in_order(device, frame, &bin)
            && let Bin::Done(binned) = bins.bin(device, &bin, work.timeline)?
        {
            work.note_binned(binned);
            let bins: &Bins = bins;
            job.storing = in_order.get_or_init(|| InOrder { bins, binned });
            job.budget.tiles += bins.bytes();
            ordered = 1;
        }
        let outcome = if work.survey { lists.survey(work, &job)? } else { lists.render(work, &job)? };
        if outcome == Outcome::Done {
            work.facts.ordered += ordered;
            work.note(&stats, walker);
        }
        Ok(outcome)
    }
}

impl Explain for ListEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = self.discs.shape == DiscShape::Oriented;
        let lists = || list_bytes(pass, tilted).or_else(|| abuffer::least_bytes(pass.name, pass.lengths()));
        pass.projected(tilted).or_else(|| tiled::binned_bytes(pass)).or_else(lists)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        abuffer::lists(plan, &self.discs, self.linked);
    }
}
