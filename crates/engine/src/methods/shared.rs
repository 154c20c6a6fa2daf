//! Splats and tiles that the images of a frame with samples share in a window: each shows the same splats, moved by a
//! fraction of a pixel. The first image projects and bins them, without its shift and with rectangles that hold for
//! any; the others take them from there, and every stage moves the splats that it reads.
//!
//! A moved place is rounded once more than a projected one: by 2^-25 of a pixel (shaders/shared/stored_splat.wgsl).

use std::cell::RefCell;
use std::rc::Rc;

use super::projected::{PendingStats, Projected};
use super::{Error, Frame, Timeline};
use crate::gpu::Device;
use crate::passes::bands::Window;
use crate::passes::bin::{self, Binned, Bins, Order};
use crate::passes::project::{DeviceCloud, Footprint, PointsPush, Projecting};

/// Pixels beyond the largest shift that rectangles hold for: far more than rounding takes.
const SLACK: f32 = 1.0 / 256.0;

/// Splats and tiles that the images of a frame share in a window.
pub(crate) struct Shared {
    images: u32,
    kept: RefCell<Kept>,
}

/// The last projection of the first image, and its last binning.
#[derive(Default)]
struct Kept {
    projection: Option<KeptProjection>,
    bins: Option<KeptBins>,
    /// Images whose nearest points were found last.
    points: Option<Several>,
    /// Projections so far.
    projections: u64,
}

struct KeptProjection {
    number: u64,
    window: Window,
    how: Projecting,
    /// Views that the cloud had been given by then.
    views: u64,
    found: PendingStats,
}

struct KeptBins {
    /// The projection whose splats they hold.
    projection: u64,
    /// Binnings of all windows by then.
    binnings: u64,
    order: Order,
    footprint: Footprint,
    depth_range: [f32; 2],
    binned: Binned,
}

/// Images of a frame with samples whose nearest points are found by one walk over the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Several {
    /// Turn of the first one.
    pub first: u32,
    /// Number of them.
    pub images: u32,
    /// Number of all images of the frame.
    pub samples: u32,
    /// Elements from an image's nearest points to the next one's.
    pub stride: u32,
    /// `true` if all points are shaded once.
    pub shaded: bool,
}

impl Several {
    /// Returns the push constants of a walk that finds them.
    pub fn of(self, push: PointsPush) -> PointsPush {
        let Self { first, images, samples, stride, .. } = self;
        PointsPush { first_turn: first, images, samples, stride, ..push }
    }

    /// Returns `true` if the image whose turn it is belongs to them.
    pub fn has(&self, turn: u32) -> bool {
        (self.first..self.first + self.images).contains(&turn)
    }
}

impl Shared {
    /// Returns what so many images of a window have in common: nothing yet.
    pub fn new(images: u32) -> Self {
        Self { images, kept: RefCell::default() }
    }

    /// Forgets everything: the first image begins, perhaps once more.
    pub fn forget(&self) {
        self.kept.take();
    }

    /// The first image is finished: its counts are known, and later images may use what it left.
    pub fn settle(&self, timeline: &Timeline) {
        let Kept { projection, bins, .. } = &mut *self.kept.borrow_mut();
        if let Some(KeptProjection { found, .. }) = projection {
            *found = PendingStats::Known(Rc::from(found.stats(timeline)));
        }
        if let Some(KeptBins { binned, .. }) = bins {
            *binned = binned.stored(timeline);
        }
    }

    /// Returns the pixels by which an image may be moved at most, in x and y.
    pub fn most_shift(&self) -> f32 {
        0.5 - 0.5 / self.images as f32 + SLACK
    }

    /// Keeps which images' nearest points were found.
    pub fn keep_points(&self, several: Several) {
        self.kept.borrow_mut().points = Some(several);
    }

    /// Returns the images whose nearest points were found last.
    pub fn points(&self) -> Option<Several> {
        self.kept.borrow().points
    }

    /// Keeps the projection that the cloud holds.
    pub fn keep_projection(&self, cloud: &DeviceCloud, (window, how): (Window, &Projecting), found: &PendingStats) {
        let mut kept = self.kept.borrow_mut();
        kept.projections += 1;
        let (number, views, found) = (kept.projections, cloud.views(), found.clone());
        kept.projection = Some(KeptProjection { number, window, how: *how, views, found });
    }

    /// Returns the results of the projection of an earlier image, if the cloud still holds it; its splats are moved to
    /// where an image has them.
    ///
    /// # Errors
    /// The device failed.
    pub fn projected(
        &self,
        device: &Device,
        cloud: &mut DeviceCloud,
        (frame, window): (&Frame, Window),
        how: &Projecting,
        timeline: &mut Timeline,
    ) -> Result<Option<Projected>, Error> {
        let mut kept = self.kept.borrow_mut();
        let same = |kept: &&mut KeptProjection| (kept.views, kept.window, kept.how) == (cloud.views(), window, *how);
        let Some(kept) = kept.projection.as_mut().filter(same) else { return Ok(None) };
        let PendingStats::Known(stats) = &kept.found else { return Ok(None) };
        cloud.set_view(&frame.camera, frame.size, window, how);
        cloud.move_splats(self.most_shift());
        kept.views = cloud.views();
        let mut recorder = timeline.recorder(device)?;
        cloud.record_view(&mut recorder);
        timeline.put_off(recorder);
        Ok(Some(Projected { stats: stats.to_vec(), found: PendingStats::Known(Rc::clone(stats)) }))
    }

    /// The number of the projection that a cloud holds, if images share it.
    fn current(kept: &Kept, cloud: &DeviceCloud) -> Option<u64> {
        kept.projection.as_ref().filter(|kept| kept.views == cloud.views()).map(|kept| kept.number)
    }

    /// Keeps tiles of the projection that the cloud holds.
    pub fn keep_bins(&self, bins: &Bins, job: &bin::Job<'_>, binned: Binned) {
        let mut kept = self.kept.borrow_mut();
        let &bin::Job { raster, order, depth_range, .. } = job;
        let (binnings, footprint) = (bins.binnings(), raster.footprint);
        kept.bins = Self::current(&kept, raster.cloud).map(|projection| KeptBins {
            projection,
            binnings,
            order,
            footprint,
            depth_range,
            binned,
        });
    }

    /// Returns the tiles of an earlier image, if they hold the splats of a job, and nobody has binned others since.
    pub fn binned(&self, bins: &Bins, job: &bin::Job<'_>) -> Option<Binned> {
        let kept = self.kept.borrow();
        let &bin::Job { raster, order, depth_range, .. } = job;
        let found = kept.bins.as_ref().filter(|kept| kept.binned.is_stored() && kept.binnings == bins.binnings())?;
        let same = (found.order, found.footprint, found.depth_range) == (order, raster.footprint, depth_range);
        (same && Self::current(&kept, raster.cloud) == Some(found.projection)).then_some(found.binned)
    }
}
