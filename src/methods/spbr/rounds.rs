//! How ensembles come one after the other: rounds of as many as there are planes, and the dispatches of a round.

use std::ops::Range;

use crate::prepare::ensembles::{Deal, Rows};

/// A first element that any device's offset alignment allows to bind from.
const ALIGNED: u64 = 64;

/// A dispatch: some consecutive slots of one cloud in one round, whose points lie in one binding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Slots, counted from the cloud's first one of the round.
    pub slots: Range<u64>,
    /// What is bound of the list.
    pub bound: Range<u64>,
    /// Place in there of the first slot's point, or of the first point of the rows, modulo 2³².
    pub base: u32,
    /// Rows of a later pass, and its first ensemble.
    pub rows: Option<(Rows, u32)>,
}

/// The dispatches of a cloud's slots of a round: those of its ensembles, at most `longest` points bound and `most` slots in
/// each.
pub fn pieces(first_point: u64, deal: &Deal, round: Range<u32>, longest: u64, most: u64) -> Vec<Piece> {
    let (mut next, mut found) = (round.start, Vec::new());
    if deal.points == 0 {
        return found;
    }
    let first = deal.slots(round.start).start;
    while next < round.end {
        let pass = deal.pass(next);
        let end = pass.ensembles.end.min(round.end);
        let slots = deal.slots(next).start..deal.slots(end - 1).end;
        let Some(rows) = pass.rows else {
            for slots in parts(slots, most.min(longest - ALIGNED)) {
                let bound = bound_of(first_point + slots.start..first_point + slots.end);
                let base = (first_point + slots.start - bound.start) as u32;
                found.push(Piece { slots: slots.start - first..slots.end - first, bound, base, rows: None });
            }
            next = end;
            continue;
        };
        let start = first_point + rows.first;
        let mut add = |slots: Range<u64>, points: Range<u64>| {
            let bound = bound_of(points);
            let rows = Some((rows, pass.ensembles.start));
            let base = start.wrapping_sub(bound.start) as u32;
            found.extend(parts(slots, most).map(|slots| {
                let slots = slots.start - first..slots.end - first;
                Piece { slots, bound: bound.clone(), base, rows }
            }));
        };
        if rows.len() + ALIGNED <= longest {
            add(slots, start..start + rows.len());
        } else {
            // What a binding cannot hold as a whole: of each ensemble as many rows as fit.
            let row = u64::from(rows.columns) << rows.block_bits;
            let fit = ((longest - ALIGNED) / row).max(1);
            for ensemble in next..end {
                let slots = deal.slots(ensemble);
                for k in (0..rows.count).step_by(fit as usize) {
                    let within = |row: u64| (slots.start + (row << rows.block_bits)).min(slots.end);
                    let last = (k + fit).min(rows.count);
                    add(within(k)..within(last), start + k * row..start + last * row);
                }
            }
        }
        next = end;
    }
    found
}

/// A range whose start may be bound.
fn bound_of(points: Range<u64>) -> Range<u64> {
    points.start / ALIGNED * ALIGNED..points.end
}

/// A range in parts of at most `most`.
fn parts(all: Range<u64>, most: u64) -> impl Iterator<Item = Range<u64>> {
    let end = all.end;
    all.step_by(most.max(1) as usize).map(move |start| start..start.saturating_add(most.max(1)).min(end))
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

    /// The points of all pieces in order, with the ensemble of each, as the shader finds them.
    fn points(pieces: &[Piece], deal: &Deal, round: Range<u32>, longest: u64) -> Vec<(u32, u64)> {
        let mut found = Vec::new();
        let first = deal.slots(round.start).start;
        let ensemble_of = |slot: u64| round.clone().find(|e| deal.slots(*e).contains(&slot)).unwrap();
        for piece in pieces {
            assert!(piece.bound.start % ALIGNED == 0 && piece.bound.end - piece.bound.start <= longest, "{piece:?}");
            for n in piece.slots.clone() {
                let ensemble = ensemble_of(first + n);
                let point = match piece.rows {
                    None => piece.base.wrapping_add((n - piece.slots.start) as u32),
                    Some((rows, start)) => {
                        let n = first + n - deal.slots(ensemble).start;
                        piece.base.wrapping_add((rows.point(ensemble - start, n) - rows.first) as u32)
                    }
                };
                let point = piece.bound.start + u64::from(point);
                assert!(piece.bound.contains(&point), "{piece:?}");
                found.push((ensemble, point));
            }
        }
        found
    }

    #[test]
    fn pieces_hold_the_points_of_each_ensemble_in_order() {
        for (first, count, m, l, longest, most) in [
            (0, 100, 1000, 17, 1000, 50),
            (70, 100, 1000, 17, 1000, u64::MAX),
            (70, 1000, 2500, 3, 1100, u64::MAX),
            (70, 300_000, 700_000, 3, 40_000, u64::MAX),
            (5, 300_000, 900_000, 30, 40_000, 7_000),
            (0, 1000, 2500, 100, 1200, 30),
            (5, 1, 9, 9, 100, 100),
            (5, 1, 0, 9, 100, 100),
        ] {
            let deal = Deal { points: count, slots: m, ensembles: l, place: 3, seed: 7 };
            for round in [0..l / 2, l / 2..l] {
                if round.is_empty() {
                    continue;
                }
                let pieces = pieces(first, &deal, round.clone(), longest, most);
                assert!(pieces.iter().all(|p| p.slots.end - p.slots.start <= most));
                let found = points(&pieces, &deal, round.clone(), longest);
                let wanted = round.flat_map(|e| deal.hand(e).into_iter().map(move |p| (e, first + p)));
                assert!(found.into_iter().eq(wanted), "{deal:?}");
            }
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
