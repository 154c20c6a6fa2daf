//! The engine of samples.

use std::cell::{Cell, RefCell};

use super::lists::{self, Wanted};
use super::{DeepSource, Sink};
use crate::methods::Stop;
use crate::methods::abuffer::{self, ListsJob, Sampling, Shown, Slots, StoreFragments, Taken};
use crate::methods::ellipsoids::Ellipsoids;
use crate::methods::prelude::*;
use crate::methods::projecting::discs as projecting;
use crate::methods::soft::Solids;
use crate::output::deep::State;

/// Hands on the samples of each window.
pub(crate) struct DeepEngine<'a> {
    /// Source of the samples.
    pub source: DeepSource,
    /// Order that the samples need.
    pub state: State,
    /// Sink that takes the samples; nobody asks for them if a frame is only surveyed.
    pub sink: RefCell<&'a mut Sink<'a>>,
    /// Samples at most, of the windows so far.
    pub most: Cell<u64>,
}

impl DeepEngine<'_> {
    fn take(&self, taken: &Taken<'_>, solids: Option<&Solids>, wanted: Wanted) -> Result<(), Error> {
        let (lengths, samples) = lists::pixels(taken, solids, wanted);
        let mut sink = self.sink.borrow_mut();
        (**sink)(&lengths, &samples).map_err(Error::Samples)
    }

    /// The samples of a window of discs, Gaussians or ellipsoids; how many there are at most, or `None` if the window
    /// must be cut.
    fn discs(
        &self,
        cloud: &mut DeviceCloud,
        Buffers { tiles, resources: Resources { lists, .. } }: &mut Buffers,
        work: &mut Work<'_>,
        (discs, layers): (Discs, u32),
    ) -> Result<Option<u64>, Error> {
        let (frame, window) = (work.frame, work.window);
        let how = projecting(frame, cloud, &discs);
        let stats = work.project(cloud, &how)?;
        let Some(budget) = work.reserve_tiles(tiles, &stats, true)? else { return Ok(None) };
        let raster = Raster { cloud, stats: &stats, tiles, walker: Walker::Compute, footprint: how.footprint, window };
        let gaussians = cloud.has_gaussians().then_some(discs.gaussians);
        let (storing, stop): (&dyn StoreFragments, f32) = match gaussians {
            Some(settings) if settings.kernel == Kernel::Ellipsoid => (&Ellipsoids { linked: false }, 0.0),
            Some(settings) => (&Slots, settings.stop),
            None => (&Slots, 0.0),
        };
        let bodies = self.state == State::Sorted;
        // Of an event a surface, and what lies behind it.
        let each = if storing.needs().every_run && !bodies { 2 } else { 1 };
        let ends = compose::stop(Stop::Exact, frame.color, 1.0);
        let job = ListsJob { raster, discs, storing, stop: ends, shown: Shown::First, budget, samples: Some(each) };
        let wanted = Wanted { state: self.state, layers, stop };
        let most = lists.samples(work, &job, Sampling { bodies }, &mut |taken| self.take(taken, None, wanted))?;
        if most.is_some() {
            work.note(&stats, Walker::Compute);
        }
        Ok(most)
    }
}

impl Engine for DeepEngine<'_> {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        match &self.source {
            DeepSource::Discs(..) => {
                // Each pixel has a run, whose sums take three times as much of a binding as a pixel's color.
                let budget = Budget { binding: budget.binding / 4, ..budget };
                Ok(windows_of(frame, budget, abuffer::PIXEL_BYTES + abuffer::RUN_PIXEL_BYTES))
            }
            DeepSource::Shells(spheres) => {
                let budget = Budget { binding: budget.binding / 4, bytes: budget.bytes / 2, ..budget };
                spheres.windows(frame, budget)
            }
        }
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let most = match &self.source {
            DeepSource::Discs(discs, layers) => self.discs(cloud, buffers, work, (*discs, *layers))?,
            DeepSource::Shells(spheres) => {
                let wanted = Wanted { state: self.state, layers: 0, stop: 0.0 };
                spheres.samples(cloud, buffers, work, &mut |taken, solids| self.take(taken, solids, wanted))?
            }
        };
        let Some(most) = most else { return Ok(Outcome::Overflow) };
        self.most.set(self.most.get() + most);
        Ok(Outcome::Done)
    }
}

impl Explain for DeepEngine<'_> {
    /// Frames with plans are those of images.
    fn explain(&self, _plan: &mut FramePlan<'_>) {}
}
