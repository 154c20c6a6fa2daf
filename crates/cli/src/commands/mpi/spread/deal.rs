//! Deals the points of a scene to all ranks, run by run.

use pellucid_engine::points::{Known, Points};
use pellucid_engine::prepare::Arranged;
use pellucid_engine::scene::stored::Stored;
use pellucid_engine::supply::{Failure, Portion, Run, joined};
use pellucid_engine::{Result, methods, passes};
use rayon::prelude::*;

use super::super::ranks::Ranks;
use super::{Spread, orders};
use crate::commands::bar::Bar;
use crate::commands::loaded::Resolved;

/// Blocks that are read at once, at most.
const AT_ONCE: usize = 8;

/// Gives each rank the next part of the points.
pub struct Dealer<'a> {
    ranks: &'a Ranks,
    known: &'a Known,
    /// Bytes of a message.
    piece: usize,
    portion: Portion,
    /// Points that each rank has got.
    dealt: Vec<u64>,
    /// Runs that are not sent yet, and to whom they go.
    waiting: Vec<u8>,
    owner: usize,
    sent: u64,
}

impl<'a> Dealer<'a> {
    /// Nobody has any.
    pub fn new(ranks: &'a Ranks, known: &'a Known, piece: usize) -> Self {
        let dealt = vec![0; ranks.count()];
        Self { ranks, known, piece, portion: Portion::default(), dealt, waiting: Vec::new(), owner: 0, sent: 0 }
    }

    /// Deals all points; returns what identifies them.
    ///
    /// # Errors
    /// They can't be read, or it was cancelled.
    pub fn deal(&mut self, resolved: &Resolved, progress: &Bar) -> Result<String> {
        progress.counted("dealing points", self.known.count());
        let identity = match (&resolved.stored, &resolved.arranged) {
            (Some(stored), _) => {
                self.deal_stored(stored, progress)?;
                String::new()
            }
            (None, Arranged::Canonical(points)) => self.deal_held(points, progress),
            // Refused before.
            (None, Arranged::Dealt(_) | Arranged::Supplied(_)) => String::new(),
        };
        self.flush();
        Ok(identity)
    }

    /// Points in memory, in canonical order.
    fn deal_held(&mut self, points: &Points, progress: &Bar) -> String {
        let mut hash = blake3::Hasher::new();
        for run in Run::all(points, None) {
            let mut bytes = Vec::new();
            run.pack(&mut bytes);
            hash.update(&bytes);
            self.put(run, progress);
        }
        hash.finalize().to_hex().to_string()
    }

    /// Points in files, some blocks at a time. Nothing that was read stays.
    fn deal_stored(&mut self, stored: &Stored, progress: &Bar) -> Result<()> {
        stored.forget();
        let at_once = rayon::current_num_threads().min(AT_ONCE);
        let numbers: Vec<usize> = (0..stored.blocks().len()).collect();
        for some in numbers.chunks(at_once) {
            let read = some.par_iter().map(|block| {
                let points = stored.block(*block)?;
                Ok((joined(vec![points], &self.known.bounds()), stored.blocks()[*block].radius))
            });
            let read = read.collect::<Result<Vec<_>, Failure>>().map_err(failed)?;
            for (points, radius) in read {
                Run::all(&points, Some(radius)).for_each(|run| self.put(run, progress));
            }
        }
        Ok(())
    }

    fn put(&mut self, run: Run, progress: &Bar) {
        let (points, ranks) = (run.points.len() as u64, self.ranks.count());
        if points == 0 {
            return;
        }
        let before: u64 = self.dealt.iter().sum();
        let owner = u128::from(before) * ranks as u128 / u128::from(self.known.count().max(1));
        let owner = (owner as usize).min(ranks - 1);
        if owner != self.owner || self.waiting.len() >= self.piece {
            self.flush();
            self.owner = owner;
        }
        self.dealt[owner] += points;
        if owner == 0 {
            self.portion.add(run);
        } else {
            run.pack(&mut self.waiting);
        }
        progress.inc(points);
    }

    /// Sends what waits.
    fn flush(&mut self) {
        if !self.waiting.is_empty() {
            self.sent += self.waiting.len() as u64;
            orders::send_runs(self.ranks, self.owner, &self.waiting);
            self.waiting.clear();
        }
    }

    /// What this rank keeps, after so many bytes were read.
    pub fn finish(self, read: u64) -> Spread {
        Spread { portion: self.portion, dealt: self.dealt, sent: self.sent, read }
    }
}

/// A failure to read points as an error of rendering.
pub fn failed(failure: Failure) -> pellucid_engine::Error {
    let error = match failure {
        Failure::Coarsest { allowed, points } => passes::Error::Coarsest { allowed, points },
        Failure::Cancelled => passes::Error::Cancelled,
        Failure::Store(error) => passes::Error::Store(error),
    };
    methods::Error::from(error).into()
}
