//! Runs of stages that go through tiles: each takes as many of a tile's splats as an invocation may loop over.

use super::{Binned, Lanes, TileWalk};
use crate::choices::Choices;
use crate::gpu::{Error, Pass, Recorder, Run, Variant};

/// A run of several that together process the splats of all tiles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OneRun {
    /// `true` if it goes on from the result of others.
    pub later: bool,
    /// `true` if there are several, so that each leaves its state.
    pub kept: bool,
    /// The invocations that go through the tiles.
    pub lanes: Lanes,
}

impl OneRun {
    /// Returns a run by its number among so many.
    pub fn new(number: u32, of: u32, lanes: Lanes) -> Self {
        Self { later: number > 0, kept: of > 1, lanes }
    }

    /// Returns a variant of stages that leave their state between runs, from one of [`super::region_variant`] or
    /// [`super::fold_blocks_variant`].
    pub fn keeping(self, variant: Variant) -> Variant {
        variant.with("KEPT", u32::from(self.kept))
    }
}

impl Binned {
    /// Records `runs` of a pass over the blocks of all tiles, as many as [`Self::segments`] or
    /// [`Self::region_segments`] tells.
    pub(crate) fn record_runs<'a, P: Pass + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        pass: &P,
        runs: u32,
        push: impl Fn(TileWalk) -> P::Push,
        variant: impl Fn(OneRun) -> Variant,
    ) -> Result<(), Error> {
        (0..runs).try_for_each(|number| {
            let run = OneRun::new(number, runs, self.lanes());
            recorder.run(pass, push(self.walk(number)), &Run::new(self.over_blocks()).variant(variant(run)))
        })
    }
}

/// Returns the variants of a stage, from those of shapes: each shape and way with the only run, and with the first and
/// the second of two.
pub(crate) fn run_variants<W: Copy>(
    shapes: Vec<Variant>,
    ways: &[W],
    of: impl Fn(Variant, OneRun, W) -> Variant,
) -> Vec<Variant> {
    let mut all = Vec::new();
    for (shape, way) in shapes.iter().flat_map(|shape| ways.iter().map(move |way| (shape, *way))) {
        for lanes in Lanes::all() {
            let runs = [(false, false), (false, true), (true, true)].map(|(later, kept)| OneRun { later, kept, lanes });
            let mut different = runs.map(|run| of(shape.clone(), run, way)).to_vec();
            // Not every stage keeps something.
            different.dedup();
            all.extend(different);
        }
    }
    all
}
