//! `sorted`: splats sorted once by the depth of their centers, binned to tiles in that order, blended front to back
//! tile by tile, until nothing behind can be seen. Exact for flat discs; approximate where oriented ones cross.
//!
//! The order is that of the A-buffer, depth and then content.

use crate::methods::prelude::*;
use crate::methods::tiled::{self, Stage, TiledEngine};

gpu_struct! {
    /// Push constants of `sorted/blend`.
    pub struct BlendPush {
        walk: TileWalk,
        // Largest opacity, and largest color component, background included: bounds of the splats behind.
        max_opacity: f32,
        max_color: f32,
    }
}

pass! {
    /// Composes the splats of a tile front to back: one subgroup per block of a tile hands them from lane to lane and
    /// keeps pixels in registers. A run takes 2048 splats; runs are joined.
    pub Blend(BlendPush) = "sorted/blend" {
        tiles: Shared<TiledGroup>,
        into: Shared<PixelsGroup>,
    }
}

/// Records the blending of all tiles of a window; `max_color` bounds the color components that are blended.
fn record_blend<'a>(
    bins: &'a Bins,
    recorder: &mut Recorder<'a>,
    frame: &Frame,
    (raster, falloff, max_color): (Raster<'a>, Falloff, f32),
    binned: Binned,
    target: &'a Target,
) -> Result<(), Error> {
    let tiles = bins.record_tiles(recorder, raster.cloud, binned)?.tiled;
    let blend = Blend { tiles, into: target.pixels() };
    let (stop, max_color) = compose::stop(frame.stop, frame.color, max_color);
    let shape = compose::variant(binned.cut(), raster.footprint, falloff);
    let push = |walk| BlendPush { walk, max_opacity: raster.cloud.max_opacity(), max_color };
    let variant = blend_variant(shape, binned.lanes(), stop);
    Ok(binned.record_runs(recorder, &blend, binned.segments(), push, &variant)?)
}

/// A variant of `sorted/blend`, from that of shape and falloff.
fn blend_variant(shape: Variant, lanes: Lanes, stop: u32) -> Variant {
    bin::fold_blocks_variant(shape, lanes).with("STOP", stop)
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    vec![Shader::new::<Blend>(bin::tile_variants(compose::variants(), &STOPS, blend_variant))]
}

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
