//! Hands out units of work: each rank begins with the one of its own number, and asks for more when it is done.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use mpi::topology::SimpleCommunicator;
use mpi::traits::*;

use super::ranks::{Ranks, patiently};

/// Tags of a question for a unit, and of its answer.
const ASK: i32 = 2;
const ANSWER: i32 = 3;

/// Answer of the work queue when no unit is left.
const NONE: u64 = u64::MAX;

/// Work queue from which a rank gets its next unit. The first rank holds the units of all; a thread of its own answers
/// the others, since the rank itself is at work.
pub struct Desk {
    own: Option<usize>,
    /// Units that nobody has begun; those of the first rank count.
    left: Arc<Mutex<Range<usize>>>,
    /// The thread that answers, on the first rank.
    server: Option<JoinHandle<()>>,
    /// True if others have to ask the first rank.
    asks: bool,
}

impl Desk {
    /// Opens a work queue with so many units, the same on all ranks.
    pub fn open(ranks: &Ranks, units: usize) -> Self {
        let (own, count) = (ranks.own(), ranks.count());
        let left = Arc::new(Mutex::new(count.min(units)..units));
        let is_served = units > count && count > 1;
        let server = (is_served && ranks.is_first()).then(|| {
            let left = Arc::clone(&left);
            std::thread::spawn(move || answer(&left, count - 1))
        });
        Self { own: (own < units).then_some(own), left, server, asks: is_served && !ranks.is_first() }
    }

    /// Waits until nobody asks any more. Every rank has to have got `None`.
    pub fn close(self) {
        if let Some(server) = self.server {
            // It has nothing to say, and doesn't panic.
            let _ = server.join();
        }
    }
}

impl Iterator for Desk {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if let Some(own) = self.own.take() {
            return Some(own);
        }
        if self.asks {
            let first = SimpleCommunicator::world();
            let first = first.process_at_rank(0);
            first.send_with_tag(&0u64, ASK);
            patiently(|| first.immediate_probe_with_tag(ANSWER));
            let (unit, _) = first.receive_with_tag::<u64>(ANSWER);
            self.asks = unit != NONE;
            return usize::try_from(unit).ok().filter(|_| self.asks);
        }
        take(&self.left)
    }
}

fn take(left: &Mutex<Range<usize>>) -> Option<usize> {
    left.lock().unwrap_or_else(PoisonError::into_inner).next()
}

/// Answers until so many ranks know that nothing is left.
fn answer(left: &Mutex<Range<usize>>, mut others: usize) {
    let world = SimpleCommunicator::world();
    while others > 0 {
        let (question, status) = patiently(|| world.any_process().immediate_matched_probe_with_tag(ASK));
        let _ = question.matched_receive::<u64>();
        let unit = take(left).map_or(NONE, |unit| unit as u64);
        others -= usize::from(unit == NONE);
        world.process_at_rank(status.source_rank()).send_with_tag(&unit, ANSWER);
    }
}
