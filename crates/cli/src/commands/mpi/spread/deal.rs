//! Deals the points of a scene to all ranks, run by run.

use pellucid_core::points::{Known, Points};
use pellucid_engine::passes::portion::{Portion, Runs, joined};
use pellucid_engine::{Result, methods};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::stored::Stored;
use pellucid_scene::supply::Failure;
use pellucid_session::Assembled;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::super::ranks::{Ranks, encoded};
use super::orders::Order;
use crate::commands::bar::Bar;

/// Blocks that are read at once, at most.
const AT_ONCE: usize = 8;

/// Points that are kept in one piece, about.
const CHUNK: usize = 1 << 18;

/// The points of the first rank, and what it needs to order others about.
pub struct Spread {
    pub portion: Portion,
    /// Points that each rank has.
    dealt: Vec<u64>,
    /// Bytes of points that were sent to others before the first frame.
    sent: u64,
    /// Bytes that were read of nodes for it.
    read: u64,
}

impl Spread {
    /// Describes how the points were dealt, for people.
    pub fn described(&self) -> String {
        let points: Vec<String> = self.dealt.iter().map(u64::to_string).collect();
        let mib = self.sent as f64 / f64::from(1 << 20);
        format!("points were spread over {} ranks: {} ({mib:.1} MiB sent)", points.len(), points.join(", "))
    }

    /// Returns how the points were dealt as JSON, for programs.
    pub fn to_json(&self) -> Value {
        json!({"points": self.dealt, "sent": self.sent, "read": self.read})
    }
}

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
    /// Starts the distribution: no rank has points yet.
    pub fn new(ranks: &'a Ranks, known: &'a Known, piece: usize) -> Self {
        let dealt = vec![0; ranks.count()];
        Self { ranks, known, piece, portion: Portion::default(), dealt, waiting: Vec::new(), owner: 0, sent: 0 }
    }

    /// Distributes all points; returns what identifies them.
    ///
    /// # Errors
    /// Returns an error if the clouds can't be read or the work was canceled.
    pub fn deal(&mut self, assembled: &Assembled, progress: &Bar) -> Result<String> {
        progress.counted("dealing points", self.known.count);
        let identity = match (assembled.stored(), assembled.arranged()) {
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
        self.put_all((points, None), progress, |runs| {
            let mut bytes = Vec::new();
            runs.pack(&mut bytes);
            hash.update(&bytes);
        });
        hash.finalize().to_hex().to_string()
    }

    /// Points in files, some blocks at a time. Nothing that was read stays.
    fn deal_stored(&mut self, stored: &Stored, progress: &Bar) -> Result<()> {
        stored.forget();
        let at_once = rayon::current_num_threads().min(AT_ONCE);
        let numbers: Vec<usize> = (0..stored.blocks().len()).collect();
        for some in numbers.chunks(at_once) {
            let read = some.par_iter().map(|block| stored.block(*block)).collect::<Result<Vec<_>, Failure>>();
            for (points, block) in read.map_err(failed)?.into_iter().zip(some) {
                let points = joined(vec![points], &self.known.bounds);
                self.put_all((&points, Some(stored.blocks()[*block].radius)), progress, |_| {});
            }
        }
        Ok(())
    }

    /// Deals points in canonical order, with the radius of their block; `see` sees them before.
    fn put_all(&mut self, (points, radius): (&Points, Option<f32>), progress: &Bar, mut see: impl FnMut(&Runs)) {
        let starts = Runs::starts(points);
        let mut first = 0;
        while first + 1 < starts.len() {
            let (owner, mut end) = (self.owner_of(0), first + 1);
            let count = |end: usize| starts[end] - starts[first];
            while end + 1 < starts.len() && count(end) < CHUNK && self.owner_of(count(end)) == owner {
                end += 1;
            }
            let runs = Runs::of(points, &starts[first..=end], radius);
            see(&runs);
            self.put(owner, runs);
            self.dealt[owner] += count(end) as u64;
            progress.inc(count(end) as u64);
            first = end;
        }
    }

    /// Returns the rank that owns the point with so many points before it that were not sent yet.
    fn owner_of(&self, before: usize) -> usize {
        let (before, ranks) = (self.dealt.iter().sum::<u64>() + before as u64, self.ranks.count());
        let owner = u128::from(before) * ranks as u128 / u128::from(self.known.count.max(1));
        (owner as usize).min(ranks - 1)
    }

    fn put(&mut self, owner: usize, runs: Runs) {
        if owner == 0 {
            return self.portion.add(runs);
        }
        if owner != self.owner || self.waiting.len() >= self.piece {
            self.flush();
            self.owner = owner;
        }
        runs.pack(&mut self.waiting);
    }

    /// Sends what waits.
    fn flush(&mut self) {
        if !self.waiting.is_empty() {
            self.sent += self.waiting.len() as u64;
            self.ranks.send(self.owner, &encoded(&Order::Keep));
            self.ranks.send(self.owner, &self.waiting);
            self.waiting.clear();
        }
    }

    /// Returns the points that this rank keeps, after so many bytes were read.
    pub fn finish(self, read: u64) -> Spread {
        Spread { portion: self.portion, dealt: self.dealt, sent: self.sent, read }
    }
}

/// A failure to read points as an error of rendering.
pub fn failed(failure: Failure) -> pellucid_engine::Error {
    methods::Error::from(failure).into()
}
