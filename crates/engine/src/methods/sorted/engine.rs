//! The engine of `sorted`.

use super::{WindowJob, render};
use crate::gpu::DeviceInfo;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Channels, Counts, Engine, Work};
use crate::methods::explain::{Explain, Plan};
use crate::methods::tiled::{self, Stage};
use crate::methods::{Buffers, Error, Frame, Outcome, Resources};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Order};
use crate::passes::project::DeviceCloud;
use crate::scene::Discs;

/// Splats sorted once, blended tile by tile.
pub(crate) struct SortedEngine {
    /// The discs.
    pub discs: Discs,
}

impl Stage for SortedEngine {
    fn discs(&self) -> Discs {
        self.discs
    }

    fn order(&self) -> Order {
        Order::Depth
    }

    fn draw(
        &self,
        resources: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        max_color: f32,
    ) -> Result<Outcome, Error> {
        render(&mut resources.bins, work, &WindowJob { bin, discs: self.discs, max_color })
    }
}

impl Engine for SortedEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    /// Splats of a tile are composed in runs of 2048: another tile would group them in another way.
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(bands::tile_windows(frame.size, budget.window_pixels(tiled::counted_bytes(frame))))
    }

    fn halves(&self, window: Window) -> Option<[Window; 2]> {
        bands::tile_halves(window)
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_BESIDE
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        tiled::render(self, cloud, buffers, work)
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        tiled::counts(buffers, frame, window)
    }
}

impl Explain for SortedEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        tiled::disc_bytes(pass, &self.discs)
    }

    fn explain(&self, plan: &mut Plan<'_>) {
        tiled::explain(plan, "sorted/blend", self.order());
    }
}
