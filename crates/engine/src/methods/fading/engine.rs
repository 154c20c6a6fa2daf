//! The engine of `moments` and `wavelet`.

use super::{Fading, WindowJob, least_bytes, most_pixels};
use crate::gpu::DeviceInfo;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Channels, Counts, Engine, Work};
use crate::methods::explain::{Explain, Plan};
use crate::methods::tiled::{self, Stage};
use crate::methods::{Buffers, Error, Frame, Outcome, Resources};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Order};
use crate::passes::project::DeviceCloud;
use crate::scene::{DiscShape, Discs};

/// Colors weighted by the light before each fragment, of which a few numbers tell for each pixel.
pub(crate) struct FadingEngine {
    /// The discs.
    pub discs: Discs,
    /// The numbers.
    pub fading: Fading,
}

impl Stage for FadingEngine {
    fn discs(&self) -> Discs {
        self.discs
    }

    fn order(&self) -> Order {
        Order::Index
    }

    fn draw(
        &self,
        Resources { bins, fadings, .. }: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        _max_color: f32,
    ) -> Result<Outcome, Error> {
        let depth_range = work.frame.depth_range();
        fadings.render(bins, work, &WindowJob { bin, discs: self.discs, fading: self.fading, depth_range })
    }
}

impl Engine for FadingEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(bands::windows(frame.size, most_pixels(budget, self.fading, tiled::counted_bytes(frame))))
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

impl Explain for FadingEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = pass.is_tilted(self.discs.shape == DiscShape::Oriented);
        let own = || least_bytes(pass.name, pass.facts, self.fading, tilted, pass.pixels());
        tiled::disc_bytes(pass, &self.discs).or_else(own)
    }

    fn explain(&self, plan: &mut Plan<'_>) {
        tiled::explain_stages(plan, self.fading.stages(), self.order());
    }
}
