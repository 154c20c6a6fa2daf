//! How ensembles come one after the other: rounds of as many as there are planes, and the dispatches of a round.

use std::ops::Range;

use super::share::Share;
use crate::prepare::ensembles::slots;

/// A first element that any device's offset alignment allows to bind from.
const ALIGNED: u64 = 64;

/// How often a dispatch may go round its points, so that the shader's division by floats is right but for one.
const MOST_TURNS: u64 = 1 << 20;

/// A dispatch: some consecutive slots of one cloud in one round, whose points lie in one binding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Slots, counted from the cloud's first one of the round.
    pub slots: Range<u64>,
    /// What is bound of the list.
    pub bound: Range<u64>,
    /// Place in there of the point that the others are counted from, and of the first slot's counted from it.
    pub base: u64,
    /// See `base`.
    pub point: u64,
    /// Points after which they repeat.
    pub repeat: u64,
}

/// The dispatches of a cloud's slots of a round: those of its ensembles, at most `longest` points bound and `most`
/// slots in each.
pub fn pieces(share: &Share, ensembles: u32, round: Range<u32>, longest: u64, most: u64) -> Vec<Piece> {
    let first = slots(share.slots, ensembles, round.start).start;
    let end = if round.is_empty() { first } else { slots(share.slots, ensembles, round.end - 1).end };
    let count = share.points.end - share.points.start;
    let (mut next, mut found) = (first, Vec::new());
    while next < end && count > 0 {
        let point = next % count;
        let whole = count + ALIGNED <= longest;
        // What a binding cannot hold as a whole is gone through without going round.
        let from = if whole { share.points.start } else { share.points.start + point };
        let room = if whole { u64::MAX } else { (longest - ALIGNED).min(count - point) };
        let taken = (end - next).min(room).min(most).min(count.saturating_mul(MOST_TURNS));
        let start = from / ALIGNED * ALIGNED;
        let bound_end = if whole { share.points.end } else { from + taken };
        found.push(Piece {
            slots: next - first..next - first + taken,
            bound: start..bound_end,
            base: from - start,
            point: if whole { point } else { 0 },
            repeat: if whole { count } else { taken },
        });
        next += taken;
    }
    found
}

/// Bits of a key that are left for epochs beside the index of one of `points`, at most 31.
pub fn epoch_bits(points: u64) -> u32 {
    points.saturating_sub(1).leading_zeros().saturating_sub(32).min(31)
}

/// Numbers of epochs, newest last: each more than the one before, and none is 0, which stands for nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epochs {
    bits: u32,
    next: u32,
}

impl Epochs {
    /// Of planes that have just been cleared. Without bits there is one epoch.
    pub fn new(bits: u32) -> Self {
        Self { bits, next: 1 }
    }

    /// How many there are.
    pub fn most(bits: u32) -> u32 {
        ((1u32 << bits) - 1).max(1)
    }

    /// The next epoch in the uppermost bits of a word; `None` when the planes must be cleared again.
    pub fn take(&mut self) -> Option<u32> {
        let epoch = self.next;
        self.next += 1;
        (epoch <= Self::most(self.bits)).then(|| if self.bits == 0 { 0 } else { epoch << (32 - self.bits) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(points: Range<u64>, slots: u64) -> Share {
        Share { points, slots, depth: 1.0, unit: 1.0, uniform: true, capped: false, opacity: 0.5, largest: 1.0 }
    }

    /// The points of all pieces in order, as the shader finds them.
    fn points(pieces: &[Piece], longest: u64) -> Vec<u64> {
        let mut found = Vec::new();
        for piece in pieces {
            assert!(piece.bound.start % ALIGNED == 0 && piece.bound.end - piece.bound.start <= longest, "{piece:?}");
            for n in 0..piece.slots.end - piece.slots.start {
                let place = piece.bound.start + piece.base + (piece.point + n) % piece.repeat;
                assert!(piece.bound.contains(&place), "{piece:?}");
                found.push(place);
            }
        }
        found
    }

    #[test]
    fn pieces_hold_each_slot_once_in_order() {
        for (range, m, l, longest, most) in [
            (0..100, 1000, 7, 1000, 50),
            (70..170, 1000, 7, 1000, u64::MAX),
            (70..1070, 2500, 3, 200, u64::MAX),
            (0..1000, 2500, 100, 200, 30),
            (5..6, 9, 9, 100, 100),
            (5..6, 0, 9, 100, 100),
        ] {
            let (n, share) = (range.end - range.start, share(range.clone(), m));
            let mut next = 0;
            for (a, b) in [(0, l / 2), (l / 2, l)] {
                let pieces = pieces(&share, l, a..b, longest, most);
                for point in points(&pieces, longest) {
                    assert_eq!(point, range.start + next % n);
                    next += 1;
                }
                assert!(pieces.windows(2).all(|p| p[0].slots.end == p[1].slots.start));
            }
            assert_eq!(next, m);
        }
    }

    #[test]
    fn epochs_rise_and_end() {
        assert_eq!([1, 2, 3, 1 << 20, 1 << 31, 1 << 32].map(epoch_bits), [31, 31, 30, 12, 1, 0]);
        let mut epochs = Epochs::new(2);
        assert_eq!([epochs.take(), epochs.take(), epochs.take()], [Some(1 << 30), Some(2 << 30), Some(3 << 30)]);
        assert_eq!(epochs.take(), None);
        let mut single = Epochs::new(0);
        assert_eq!([single.take(), single.take()], [Some(0), None]);
    }
}
