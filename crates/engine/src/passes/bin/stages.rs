//! Stages over all tiles, in as many runs as it takes to get through the longest list of a tile.

use super::{Binned, Lanes};
use crate::choices::Choices;
use crate::gpu::{Pass, Recorder, Run, Variant};
use crate::passes::Error;

/// A run of several that together process the tiles' splats.
#[derive(Debug, Clone, Copy)]
pub struct OneRun {
    /// `true` if it goes on from the result of others.
    pub later: bool,
    /// `true` if there are several, so that each leaves what it knows.
    pub kept: bool,
    /// The invocations that go through the tiles.
    pub lanes: Lanes,
}

impl OneRun {
    /// Returns a run by its number among so many.
    pub fn new(number: u32, of: u32, lanes: Lanes) -> Self {
        Self { later: number > 0, kept: of > 1, lanes }
    }
}

/// The only run, and the first and the second of two.
impl Choices for OneRun {
    fn all() -> Vec<Self> {
        let numbers = [(0, 1), (0, 2), (1, 2)].into_iter();
        numbers
            .flat_map(|(number, of)| Lanes::all().into_iter().map(move |lanes| Self::new(number, of, lanes)))
            .collect()
    }
}

/// Stages that go through the tiles block by block.
pub(crate) struct Stages {
    /// Shape and falloff.
    pub shape: Variant,
    /// The tiles.
    pub binned: Binned,
    /// Runs that it takes to get through the longest list of a tile.
    pub runs: u32,
}

impl Stages {
    /// Records all runs of a stage; `variant` makes its variants from that of shape and falloff.
    pub fn record<'a, P: Pass + 'a>(
        &self,
        recorder: &mut Recorder<'a>,
        pass: &P,
        push: impl Fn(u32) -> P::Push,
        variant: impl Fn(Variant, OneRun) -> Variant,
    ) -> Result<(), Error> {
        (0..self.runs).try_for_each(|number| {
            let run = OneRun::new(number, self.runs, self.binned.lanes());
            let over = Run::new(self.binned.over_blocks());
            Ok(recorder.run(pass, push(number), &over.variant(variant(self.shape.clone(), run)))?)
        })
    }
}
