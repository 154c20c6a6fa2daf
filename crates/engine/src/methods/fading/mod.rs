//! Approximations that go through the tiles of splats twice and more: first they find how the light of each pixel fades
//! with depth, as far as a few numbers tell, then they sum colors weighted by it. `moments` and `wavelet`. No order of
//! splats is needed, and no memory that grows with fragments.

mod passes;

pub use passes::*;

use self::passes::with_cells;
pub(super) use self::passes::{by_moments, with_moments};
use super::tiled::{self, SMALL_WINDOW, STATE_BYTES, Stage, SumPush, Sums, TiledEngine};
use crate::methods::prelude::*;
use crate::scene::{MomentCount, Moments};

/// The numbers that tell how the light of a pixel fades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fading {
    /// `moments`
    Moments(Moments),
    /// `wavelet`, by its rank.
    Wavelet(u32),
}

impl Fading {
    /// The stages, in the order in which they run.
    fn stages(self) -> &'static [&'static str] {
        match self {
            Self::Moments(_) => &["moments/gather", "moments/accumulate"],
            Self::Wavelet(_) => &["wavelet/range", "wavelet/gather", "wavelet/accumulate"],
        }
    }

    /// Pairs of floats for each pixel: the moments and the nearest place; or the cells.
    fn pairs(self) -> u64 {
        match self {
            Self::Moments(moments) => pairs(moments.moments),
            Self::Wavelet(rank) => 2 << rank,
        }
    }
}

/// Returns the number of pairs of floats of a pixel's moments, and of its nearest place.
pub(super) fn pairs(moments: MomentCount) -> u64 {
    u64::from(moments.get()) + 2
}

/// Bytes of a pair of floats, as also the range of depths of a pixel is.
pub(super) const PAIR_BYTES: u64 = 8;

/// Returns the number of device bytes of a pixel while a window is rendered.
pub fn pixel_bytes(fading: Fading) -> u64 {
    STATE_BYTES + PAIR_BYTES * (fading.pairs() + 1)
}

/// Most pixels of a window: what is known of them and what runs leave fit a binding each, and a quarter of the budget.
fn most_pixels(budget: Budget, fading: Fading, other_bytes: u64) -> u64 {
    let bound = (budget.binding / STATE_BYTES.max(PAIR_BYTES * fading.pairs())).max(1);
    budget.window_pixels(other_bytes + pixel_bytes(fading)).min(bound)
}

fields! {
    /// Buffers, kept from frame to frame.
    pub struct Fadings {
        known: Scratch<[f32; 2]> = Scratch::new("fading of pixels", Memory::Device),
        ranges: Scratch<[f32; 2]> = Scratch::new("ranges of depths of pixels", Memory::Device),
        state: Scratch<[f32; 4]> = Scratch::new("weighted sums of pixels", Memory::Device),
    }
}

impl Fadings {
    /// Bins a window's splats, finds how its light fades and sums its colors into the target.
    pub(crate) fn render(
        &mut self,
        bins: &mut Bins,
        work: &mut Work<'_>,
        mut bin: bin::Job<'_>,
        engine: &FadingEngine,
    ) -> Result<Outcome, Error> {
        let (device, frame, target, pixels) = (work.device, work.frame, work.target, work.pixels());
        bin.counted_bytes += pixels * pixel_bytes(engine.fading);
        let small = SMALL_WINDOW * pixel_bytes(engine.fading);
        tiled::blend(bins, work, (&bin, small), "accumulate", |bins, work, binned| {
            self.reserve(device, pixels, engine.fading, binned.region_segments() > 1)?;
            let mut recorder = work.timeline.recorder(device)?;
            self.record(bins, &mut recorder, (bin.raster, engine, frame.depth_range()), binned, target)?;
            Ok(Some(recorder))
        })
    }

    fn reserve(&mut self, device: &Device, pixels: u64, fading: Fading, kept: bool) -> Result<(), Error> {
        let ranged = matches!(fading, Fading::Wavelet(_));
        self.known.reserve(device, pixels * fading.pairs())?;
        self.ranges.reserve(device, if ranged { pixels } else { 1 })?;
        self.state.reserve(device, if kept { pixels * STATE_BYTES / 16 } else { 1 })?;
        Ok(())
    }

    /// Records the stages one after the other, each over all tiles.
    fn record<'a>(
        &'a self,
        bins: &'a Bins,
        recorder: &mut Recorder<'a>,
        (raster, engine, depth_range): (Raster<'a>, &FadingEngine, [f32; 2]),
        binned: Binned,
        target: &'a Target,
    ) -> Result<(), Error> {
        let tiles = bins.record_tiles(recorder, raster.cloud, binned)?.tiled;
        let sums = Sums { into: target.pixels(), kept: self.state.get().all() };
        let shape = compose::variant(binned.cut(), raster.footprint, engine.discs.falloff);
        let (known, ranges) = (self.known.get().all(), self.ranges.get().all());
        let runs = binned.region_segments();
        let through = bin::region_variant(shape, binned.lanes());
        match engine.fading {
            Fading::Moments(moments) => {
                let estimate = Estimate::new(&moments, depth_range);
                let push = |walk| MomentPush { walk, estimate };
                let variant = with_moments(through, moments.moments.get());
                let (gather, weigh) = (GatherMoments { tiles, known }, WeighByMoments { tiles, sums, known });
                binned.record_runs(recorder, &gather, runs, push, &variant)?;
                binned.record_runs(recorder, &weigh, runs, push, &variant)?;
            }
            Fading::Wavelet(rank) => {
                let push = |walk| SumPush { walk };
                let variant = with_cells(through.clone(), 2 << rank);
                let gather = GatherCells { tiles, ranges, cells: known };
                let weigh = WeighByCells { tiles, sums, ranges, cells: known };
                binned.record_runs(recorder, &FindRange { tiles, ranges }, runs, push, &through)?;
                binned.record_runs(recorder, &gather, runs, push, &variant)?;
                binned.record_runs(recorder, &weigh, runs, push, &variant)?;
            }
        }
        Ok(())
    }
}

/// Returns the number of bytes that a stage must at least read and write: `tilted` whether discs are oriented. Of
/// splats each pair with a tile, and what it reads, leaves or both of the window's pixels.
pub fn least_bytes(name: &str, facts: &Facts, fading: Fading, tilted: bool, pixels: u64) -> Option<u64> {
    let known = PAIR_BYTES * fading.pairs();
    let (color, pixel) = match name {
        "moments/gather" => (4, known),
        "moments/accumulate" => (16, known + 20),
        "wavelet/range" => (4, PAIR_BYTES),
        "wavelet/gather" => (4, PAIR_BYTES + known),
        "wavelet/accumulate" => (16, PAIR_BYTES + known + 20),
        _ => return None,
    };
    // Index, then splat, depth, and color or opacity.
    let splat = 4 + 16 + 4 + color + if tilted { 16 } else { 0 };
    Some(facts.tile_entries * splat + pixels * pixel)
}

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

#[cfg(test)]
mod tests {
    use super::*;
    fn eight() -> Fading {
        Fading::Moments(Moments { moments: MomentCount::Eight, ..Moments::default() })
    }

    #[test]
    fn bytes_of_pixels() {
        assert_eq!((pixel_bytes(eight()), pixel_bytes(Fading::Wavelet(5))), (64 + 11 * 8, 64 + 65 * 8));
        let budget = Budget { bytes: 1 << 30, tiles: 0, binding: 1 << 20 };
        assert_eq!(most_pixels(budget, Fading::Wavelet(5), 0), (1 << 20) / 512);
        assert_eq!(most_pixels(Budget { bytes: 1 << 20, ..budget }, eight(), 8), (1 << 18) / 160);
    }

    #[test]
    fn least_bytes_by_hand() {
        let facts = Facts { tile_entries: 20, ..Facts::default() };
        let of = |name, tilted| least_bytes(name, &facts, eight(), tilted, 100);
        assert_eq!(of("moments/gather", false), Some(20 * 28 + 100 * 80));
        assert_eq!(of("moments/accumulate", true), Some(20 * 56 + 100 * 100));
        let cells = |name| least_bytes(name, &facts, Fading::Wavelet(1), false, 100);
        assert_eq!(cells("wavelet/range"), Some(20 * 28 + 800));
        assert_eq!(cells("wavelet/gather"), Some(20 * 28 + 100 * (8 + 32)));
        assert_eq!(cells("sorted/blend"), None);
    }
}
