//! The engine of `weighted`, `average`, `unsorted`, `hybrid` and `mlab`.

use super::{Kind, WindowJob, least_bytes, pixel_bytes};
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

/// Sums over the fragments of each pixel.
pub(crate) struct ApproximateEngine {
    /// The discs.
    pub discs: Discs,
    /// The sums.
    pub kind: Kind,
}

impl Stage for ApproximateEngine {
    fn discs(&self) -> Discs {
        self.discs
    }

    fn order(&self) -> Order {
        match self.kind {
            Kind::Weighted | Kind::Average => Order::Index,
            Kind::Unsorted => Order::File,
            Kind::Hybrid { .. } => Order::Depth,
            Kind::Mlab(_) => Order::Arrival,
        }
    }

    fn draw(
        &self,
        Resources { bins, approximations, .. }: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        _max_color: f32,
    ) -> Result<Outcome, Error> {
        let depth_range = work.frame.depth_range();
        approximations.render(bins, work, &WindowJob { bin, discs: self.discs, kind: self.kind, depth_range })
    }
}

impl Engine for ApproximateEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        let bytes = pixel_bytes(self.kind);
        let most = budget.window_pixels(tiled::counted_bytes(frame) + bytes);
        // Per-pixel state must fit one binding. Only moments need more of it than the image.
        let bound = budget.binding.checked_div(bytes).unwrap_or(u64::MAX).max(1);
        Ok(bands::windows(frame.size, most.min(bound)))
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

impl Explain for ApproximateEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = pass.is_tilted(self.discs.shape == DiscShape::Oriented);
        let own = || least_bytes(pass.name, pass.facts, self.kind, tilted, pass.pixels());
        tiled::disc_bytes(pass, &self.discs).or_else(own)
    }

    fn explain(&self, plan: &mut Plan<'_>) {
        let stage = match self.kind {
            Kind::Weighted => "weighted/accumulate",
            Kind::Average => "average/accumulate",
            Kind::Unsorted => "unsorted/accumulate",
            Kind::Hybrid { tail: None, .. } => "hybrid/accumulate",
            Kind::Hybrid { tail: Some(_), .. } => {
                let stages = ["hybrid/accumulate", "hybrid/gather", "hybrid/weigh"];
                return tiled::explain_stages(plan, &stages, self.order());
            }
            Kind::Mlab(_) => "mlab/accumulate",
        };
        tiled::explain(plan, stage, self.order());
    }
}
