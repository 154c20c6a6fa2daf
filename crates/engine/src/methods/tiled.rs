//! Common parts of the methods over tiles of ordered splats: `sorted`, `stochastic` and the approximations.

use super::abuffer;
use super::explain::PRESORTED;
use crate::methods::prelude::*;
use crate::passes::bin::RECORD_BYTES;
use crate::scene;

gpu_struct! {
    /// Push constants of stages that need nothing but their place.
    pub struct SumPush {
        walk: TileWalk,
    }
}

group! {
    /// Bindings of stages that keep sums for each pixel, besides the tiles.
    pub Sums as SumsGroup {
        into: Shared<PixelsGroup>,
        /// State that a run leaves to the next.
        kept: ReadWrite<[f32; 4]>,
    }
}

/// Bytes of a pixel's state between two runs.
pub(super) const STATE_BYTES: u64 = 64;
/// Up to so many pixels a window has room for their state whatever else there is.
pub(super) const SMALL_WINDOW: u64 = 256;

/// A stage that goes through tiles of splats.
pub(crate) trait Stage {
    /// The discs that become splats.
    fn discs(&self) -> Discs;

    /// The order in which it wants them.
    fn order(&self) -> Order;

    /// The raster path.
    ///
    /// # Errors
    /// The hardware rasterizer was requested and isn't supported.
    fn walker(&self, device: &Device, window: Window) -> Result<Walker, Error> {
        walker(device, scene::Raster::Auto, window)
    }

    /// Bytes per pixel that are in use while splats are binned, beside list lengths.
    fn used_bytes(&self, _frame: &Frame) -> u64 {
        0
    }

    /// Decides how a window is binned; draws nothing.
    ///
    /// # Errors
    /// Returns an error if [`Bins::survey`] fails.
    fn survey(&self, work: &mut Work<'_>, bin: &bin::Job<'_>) -> Result<Outcome, Error> {
        Ok(work.facts.note_survey(Bins::survey(work.device, bin)?))
    }

    /// Bins a window and draws it; `max_color` bounds the color components.
    ///
    /// # Errors
    /// Returns an error if [`Bins::bin`] or the drawing fails.
    fn draw(
        &self,
        resources: &mut Resources,
        work: &mut Work<'_>,
        bin: bin::Job<'_>,
        max_color: f32,
    ) -> Result<Outcome, Error>;
}

/// A stage that is all of its method besides the projection: an engine by itself.
pub(crate) trait TiledEngine: Stage {
    /// Cuts a frame into windows that fit the budget.
    fn windows(&self, frame: &Frame, budget: Budget) -> Vec<Window>;

    /// Cuts a window that turned out to be too large; `None` for a single pixel.
    fn halves(&self, window: Window) -> Option<[Window; 2]> {
        bands::halves(window)
    }

    /// Returns the passes behind the tiles, in the order in which they run.
    fn passes(&self) -> &'static [&'static str];

    /// Returns the number of bytes that one of them must at least move.
    fn least_bytes(&self, _pass: &PassRuns<'_>) -> Option<u64> {
        None
    }
}

impl<S: TiledEngine> Engine for S {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(TiledEngine::windows(self, frame, budget))
    }

    fn halves(&self, window: Window) -> Option<[Window; 2]> {
        TiledEngine::halves(self, window)
    }

    fn channels(&self) -> Channels {
        Channels::LISTS_BESIDE
    }

    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        render(self, cloud, buffers, work)
    }
}

impl<S: TiledEngine> Explain for S {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        disc_bytes(pass, &self.discs()).or_else(|| TiledEngine::least_bytes(self, pass))
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        explain(plan, self.passes(), self.order());
    }
}

/// Returns bytes per pixel of a window that are in use before its splats are binned.
pub(super) fn counted_bytes(frame: &Frame) -> u64 {
    if frame.fragments { abuffer::PIXEL_BYTES } else { bin::PIXEL_BYTES }
}

/// Returns a window by tiles of splats; the lengths of lists are counted only where they are asked for.
pub(super) fn render(
    stage: &impl Stage,
    cloud: &mut DeviceCloud,
    buffers: &mut Buffers,
    work: &mut Work<'_>,
) -> Result<Outcome, Error> {
    let Buffers { tiles, resources } = buffers;
    let (device, frame, window, discs) = (work.device, work.frame, work.window, stage.discs());
    let how = super::projecting::discs(frame, cloud, &discs);
    let stats = work.project(cloud, &how)?;
    let walker = stage.walker(device, window)?;
    // Splats are visited one by one only to be counted.
    let visited = frame.fragments && walker == Walker::Compute;
    let Some(budget) = work.reserve_tiles(tiles, &stats, visited)? else { return Ok(Outcome::Overflow) };
    let raster = Raster { cloud, stats: &stats, tiles, walker, footprint: how.footprint, window };
    let (pixels, max_color) = (bands::pixels(window), cloud.max_color(&how));
    let mut counted_bytes = pixels * stage.used_bytes(frame);
    if frame.fragments {
        if resources.lists.tally(work, raster)? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        counted_bytes += pixels * abuffer::PIXEL_BYTES;
    }
    let bin = bin::Job { raster, order: stage.order(), depth_range: frame.key_range(), budget, counted_bytes };
    let outcome = if work.survey { stage.survey(work, &bin)? } else { stage.draw(resources, work, bin, max_color)? };
    if outcome == Outcome::Done {
        work.finish();
        work.note(&stats, walker);
    }
    Ok(outcome)
}

/// Bins the splats of a window, hands its tiles to `draw`, which records their pixels or finds that the window must be
/// cut (`None`), and copies the window to the host. The smallest window takes `small` bytes beside those of the tiles.
pub(super) fn blend<'a, 'w: 'a>(
    bins: &'a mut Bins,
    work: &mut Work<'w>,
    (bin, small): (&bin::Job<'_>, u64),
    name: &str,
    draw: impl FnOnce(&'a Bins, &mut Work<'w>, Binned) -> Result<Option<Recorder<'a>>, Error>,
) -> Result<Outcome, Error> {
    let (device, target, pixels) = (work.device, work.target, work.pixels());
    let mut recorder;
    match bins.bin(device, bin, work.timeline).map_err(|error| beside(error, small))? {
        Bin::TooLarge => return Ok(Outcome::Overflow),
        Bin::Nothing => {
            recorder = work.timeline.recorder(device)?;
            target.pixels().record_nothing(&mut recorder, work.window)?;
        }
        Bin::Done(binned) => {
            work.note_binned(binned);
            let Some(drawn) = draw(bins, work, binned)? else { return Ok(Outcome::Overflow) };
            recorder = drawn;
            work.facts.bands += 1;
        }
    }
    target.record_read_back(&mut recorder, pixels)?;
    work.timeline.submit(recorder, name)?;
    Ok(Outcome::Done)
}

/// Returns an error whose budget leaves room for `more` bytes besides.
fn beside(error: Error, more: u64) -> Error {
    match error {
        Error::SortOverBudget { points, needed, available, .. } => {
            Error::SortOverBudget { points, needed, available, budget: Budget::wanted(needed + more) }
        }
        other => other,
    }
}

/// The stages that go through tiles of ordered splats.
const STAGES: [&str; 13] = [
    "sorted/blend",
    "hybrid/accumulate",
    "hybrid/gather",
    "hybrid/weigh",
    "mlab/accumulate",
    "moments/gather",
    "moments/accumulate",
    "wavelet/range",
    "wavelet/gather",
    "wavelet/accumulate",
    "weighted/accumulate",
    "average/accumulate",
    "unsorted/accumulate",
];

/// Returns the passes that sort splats and put them into tiles.
pub(super) fn order_group() -> PassGroup {
    PassGroup::new(&ORDER, Absent::Discs("splats are not sorted"))
}

/// Returns the passes that go through an order of points that was made beforehand.
pub(super) fn presorted_group() -> PassGroup {
    PassGroup::new(&PRESORTED, Absent::Always("points were not sorted in advance"))
}

/// Returns the stages that go through tiles of ordered splats.
pub(super) fn stage_group() -> PassGroup {
    PassGroup::new(&STAGES, Absent::Discs("this frame processes tiles of splats by other passes, or has none"))
}

/// The plan of a frame of stages, one after the other: the sort of splats, the stages, and the counting of lists.
fn explain(plan: &mut FramePlan<'_>, names: &[&'static str], order: Order) {
    let (facts, why) = (plan.facts, plan.why);
    plan.projected();
    let counters = if plan.seen() { plan.order(order, why) } else { 0 };
    abuffer::counted_beside(plan, counters);
    let windows = plan.if_seen(format!("{} window(s) with splats", facts.bands));
    for name in names {
        plan.add(name, plan.seen(), windows.clone());
    }
    plan.emptied();
    plan.rest(&ORDER, NOTHING);
    without_lists(plan, &format!("splats are sorted, so fragments need no lists: {why}"));
}

/// The passes of lists in the plan of a frame without lists.
pub(super) fn without_lists(plan: &mut FramePlan<'_>, reason: &str) {
    plan.rest(&abuffer::COUNT, "lengths of lists were not requested, and the method does not need them");
    plan.rest(&abuffer::list_passes(), reason);
}

/// Returns the number of bytes that a pass of a frame of discs must at least move, except those of a stage: projection,
/// counted lists and tiles.
pub(super) fn disc_bytes(pass: &PassRuns<'_>, discs: &Discs) -> Option<u64> {
    let tilted = discs.shape == DiscShape::Oriented;
    let counted = || abuffer::list_bytes(pass, tilted);
    pass.projected(tilted).or_else(counted).or_else(|| binned_bytes(pass))
}

/// Returns the number of bytes that a pass must at least move which puts splats into tiles.
pub(super) fn binned_bytes(pass: &PassRuns<'_>) -> Option<u64> {
    if pass.cloud.sorts_pairs() && pass.name.starts_with("radix/") {
        // Records of splats in some runs, in others pairs of tile and splat.
        return None;
    }
    least_bytes(pass.name, pass.runs, pass.facts)
}

/// Bytes that a pass must at least read and write; `runs` of it over the frame.
/// How much of the tiles `sorted/blend` reads depends on where it stops.
fn least_bytes(name: &str, runs: u64, facts: &Facts) -> Option<u64> {
    let sorted = facts.points * RECORD_BYTES;
    match name {
        // Columns and depth of each, and the record.
        "bin/keys" => Some((facts.points * (4 + 4) + sorted) * facts.bands),
        "radix/count" => Some(sorted * runs),
        "radix/scatter" => Some(2 * sorted * runs),
        // An index and a rectangle of each, and the record.
        "bin/pick" => Some(facts.points * (4 + 8) * facts.bands),
        "bin/place" => Some(facts.points * (4 + 8) * facts.bands + facts.soft_visible * RECORD_BYTES),
        // Record and rectangle.
        "bin/tile-count" => Some(facts.visible * (RECORD_BYTES + 8) + facts.tile_entries * 8),
        "bin/tile-store" => Some(facts.visible * (RECORD_BYTES + 8) + facts.tile_entries * (8 + 4)),
        // Record, rectangle and place.
        "bin/pairs" => Some(facts.visible * (RECORD_BYTES + 8 + 4) + facts.tile_entries * RECORD_BYTES),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_bytes_by_hand() {
        let facts = Facts { points: 10, visible: 5, tile_entries: 20, bands: 2, ..Facts::default() };
        assert_eq!(least_bytes("bin/keys", 4, &facts), Some(2 * 10 * 16));
        assert_eq!(least_bytes("radix/count", 4, &facts), Some(4 * 80));
        assert_eq!(least_bytes("radix/scatter", 4, &facts), Some(4 * 160));
        assert_eq!(least_bytes("bin/pick", 2, &facts), Some(2 * 10 * 12));
        let soft = Facts { soft_visible: 3, ..facts.clone() };
        assert_eq!(least_bytes("bin/place", 2, &soft), Some(2 * 10 * 12 + 3 * 8));
        assert_eq!(least_bytes("bin/tile-count", 2, &facts), Some(5 * 16 + 20 * 8));
        assert_eq!(least_bytes("bin/tile-store", 2, &facts), Some(5 * 16 + 20 * 12));
        assert_eq!(least_bytes("bin/pairs", 2, &facts), Some(5 * 20 + 20 * 8));
        assert_eq!(least_bytes("sorted/blend", 2, &facts), None);
    }
}
