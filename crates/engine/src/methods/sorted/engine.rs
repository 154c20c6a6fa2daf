//! The engine of `sorted`.

use super::record_blend;
use crate::methods::engine::Work;
use crate::methods::tiled::{self, Stage, TiledEngine};
use crate::methods::{Error, Frame, Outcome, Resources};
use crate::passes::bands::{self, Budget, Window};
use crate::passes::bin::{self, Order};
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
        let (device, frame, target) = (work.device, work.frame, work.target);
        tiled::blend(&mut resources.bins, work, (&bin, 0), "sorted/blend", |bins, work, binned| {
            let mut recorder = work.timeline.recorder(device)?;
            let splats = (bin.raster, self.discs.falloff, max_color);
            record_blend(bins, &mut recorder, frame, splats, binned, target)?;
            Ok(Some(recorder))
        })
    }
}

impl TiledEngine for SortedEngine {
    /// Splats of a tile are composed in runs of 2048: another tile would group them in another way.
    fn windows(&self, frame: &Frame, budget: Budget) -> Vec<Window> {
        bands::tile_windows(frame.size, budget.window_pixels(tiled::counted_bytes(frame)))
    }

    fn halves(&self, window: Window) -> Option<[Window; 2]> {
        bands::tile_halves(window)
    }

    fn passes(&self) -> &'static [&'static str] {
        &["sorted/blend"]
    }
}
