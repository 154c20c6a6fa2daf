//! The dispatches of a window in their order.

use std::collections::VecDeque;
use std::mem::take;
use std::ops::Range;

use super::rounds::{Epochs, Piece, pieces};
use super::{SpbrJob, Stage};

/// A dispatch.
#[derive(Debug, Clone)]
pub struct Task {
    /// The ensembles of its round.
    pub ensembles: Range<u32>,
    /// The epoch of their keys.
    pub epoch: u32,
    /// `true` if planes must be cleared before it.
    pub renews: bool,
    /// The pass.
    pub stage: Stage,
    /// Place of its cloud among the others.
    pub cloud: usize,
    /// Range of slots and points.
    pub piece: Piece,
}

/// The dispatches of all rounds: of each, every stage goes over all clouds before the next.
pub struct Tasks<'a> {
    job: &'a SpbrJob<'a>,
    epochs: Epochs,
    /// First ensemble of the next round.
    next: u32,
    renews: bool,
    round: VecDeque<Task>,
}

impl<'a> Tasks<'a> {
    /// Returns the tasks of a window.
    pub fn new(job: &'a SpbrJob<'a>) -> Self {
        Self {
            job,
            epochs: Epochs::new(job.epoch_bits()),
            next: job.drawn.start,
            renews: false,
            round: VecDeque::new(),
        }
    }

    fn begin_round(&mut self) {
        let (job, bits) = (self.job, self.job.epoch_bits());
        let ensembles = self.next..job.drawn.end.min(self.next + job.planes() as u32);
        let epoch = self.epochs.take().unwrap_or_else(|| {
            self.renews = true;
            self.epochs = Epochs::new(bits);
            self.epochs.take().unwrap_or_default()
        });
        for stage in job.form.stages() {
            for (cloud, share) in job.shares.iter().enumerate() {
                let deal = share.deal(job.ensembles[1], cloud as u32, job.seed);
                let most = job.dispatch_slots();
                let pieces = pieces(share.points.start, &deal, ensembles.clone(), job.longest(), most);
                self.round.extend(pieces.into_iter().map(|piece| Task {
                    ensembles: ensembles.clone(),
                    epoch,
                    renews: false,
                    stage: *stage,
                    cloud,
                    piece,
                }));
            }
        }
        self.next = ensembles.end;
    }
}

impl Iterator for Tasks<'_> {
    type Item = Task;

    fn next(&mut self) -> Option<Task> {
        while self.round.is_empty() && self.next < self.job.drawn.end {
            self.begin_round();
        }
        let task = self.round.pop_front()?;
        // If a round has no slots, the next one that has some clears the planes.
        Some(Task { renews: take(&mut self.renews), ..task })
    }
}
