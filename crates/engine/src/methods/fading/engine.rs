//! The engine of `moments` and `wavelet`.

use super::{Fading, Fadings, least_bytes, most_pixels};
use crate::methods::bytes::PassRuns;
use crate::methods::engine::Work;
use crate::methods::tiled::{self, Stage, TiledEngine};
use crate::methods::{Error, Frame, Outcome, Resources};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Order};
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
        Resources { bins, own, .. }: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        _max_color: f32,
    ) -> Result<Outcome, Error> {
        own.of::<Fadings>(work.device)?.render(bins, work, bin, self)
    }
}

impl TiledEngine for FadingEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Vec<Window> {
        bands::windows(frame.size, most_pixels(budget, self.fading, tiled::counted_bytes(frame)))
    }

    fn passes(&self) -> &'static [&'static str] {
        self.fading.stages()
    }

    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        let tilted = pass.is_tilted(self.discs.shape == DiscShape::Oriented);
        least_bytes(pass.name, pass.facts, self.fading, tilted, pass.pixels())
    }
}
