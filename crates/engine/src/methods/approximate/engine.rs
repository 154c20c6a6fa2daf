//! The engine of `weighted`, `average`, `unsorted`, `hybrid` and `mlab`.

use super::{ApproximateKind, Approximations, least_bytes, pixel_bytes};
use crate::methods::prelude::*;
use crate::methods::tiled::{self, Stage, TiledEngine};

/// Sums over the fragments of each pixel.
pub(crate) struct ApproximateEngine {
    /// The discs.
    pub discs: Discs,
    /// The sums.
    pub kind: ApproximateKind,
}

impl Stage for ApproximateEngine {
    fn discs(&self) -> Discs {
        self.discs
    }

    fn order(&self) -> Order {
        match self.kind {
            ApproximateKind::Weighted | ApproximateKind::Average => Order::Index,
            ApproximateKind::Unsorted => Order::File,
            ApproximateKind::Hybrid { .. } => Order::Depth,
            ApproximateKind::Mlab(_) => Order::Arrival,
        }
    }

    fn draw(
        &self,
        Resources { bins, own, .. }: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        _max_color: f32,
    ) -> Result<Outcome, Error> {
        own.of::<Approximations>(work.device)?.render(bins, work, bin, self)
    }
}

impl TiledEngine for ApproximateEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Vec<Window> {
        let bytes = pixel_bytes(self.kind);
        let most = budget.window_pixels(tiled::counted_bytes(frame) + bytes);
        // Per-pixel state must fit one binding. Only moments need more of it than the image.
        let bound = budget.binding.checked_div(bytes).unwrap_or(u64::MAX).max(1);
        bands::windows(frame.size, most.min(bound))
    }

    fn passes(&self) -> &'static [&'static str] {
        match self.kind {
            ApproximateKind::Weighted => &["weighted/accumulate"],
            ApproximateKind::Average => &["average/accumulate"],
            ApproximateKind::Unsorted => &["unsorted/accumulate"],
            ApproximateKind::Hybrid { tail: None, .. } => &["hybrid/accumulate"],
            ApproximateKind::Hybrid { tail: Some(_), .. } => &["hybrid/accumulate", "hybrid/gather", "hybrid/weigh"],
            ApproximateKind::Mlab(_) => &["mlab/accumulate"],
        }
    }

    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = pass.is_tilted(self.discs.shape == DiscShape::Oriented);
        least_bytes(pass.name, pass.facts, self.kind, tilted, pass.pixels())
    }
}
