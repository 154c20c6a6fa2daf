//! The sequence of ensembles: rounds of as many as there are planes, and the dispatches of a round.

use std::cmp::Ordering;
use std::ops::Range;

use crate::prepare::ensembles::{Deal, PassRows};

/// A first element that any device's offset alignment allows to bind from.
pub const ALIGNED: u64 = 64;

/// A dispatch: some consecutive slots of one cloud in one round, whose points are in one binding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Slots, counted from the cloud's first one of the round.
    pub slots: Range<u64>,
    /// The bound part of the list.
    pub bound: Range<u64>,
    /// Place in there, modulo 2³², of the first slot's point, or of the one that those of rows are counted from.
    pub base: u32,
    /// Points of a later pass.
    pub rows: Option<Again>,
}

/// Way in which a dispatch finds points of a later pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Again {
    /// The rows.
    pub rows: PassRows,
    /// The pass's first ensemble.
    pub ensemble: u32,
    /// First point of the first row, counted from the piece's base.
    pub start: u32,
    /// The number of points after which the cloud wraps around; more than exist where it doesn't.
    pub around: u32,
}

/// Returns the dispatches of a cloud's slots of a round: those of its ensembles, at most `longest` points bound and
/// `most` slots in each.
pub fn pieces(first_point: u64, deal: &Deal, round: Range<u32>, longest: u64, most: u64) -> Vec<Piece> {
    let mut cut = Cutting { first_point, deal, first: deal.slots(round.start).start, longest, most, found: Vec::new() };
    let mut next = round.start;
    while next < round.end && deal.points > 0 {
        let pass = deal.pass(next);
        let end = pass.ensembles.end.min(round.end);
        let slots = deal.slots(next).start..deal.slots(end - 1).end;
        match pass.rows {
            None => cut.add_in_order(slots.clone(), slots.start),
            Some(rows) => cut.add_rows(&rows, pass.ensembles.start, slots, next..end),
        }
        next = end;
    }
    cut.found
}

/// Pieces as they are found.
struct Cutting<'a> {
    first_point: u64,
    deal: &'a Deal,
    /// The round's first slot.
    first: u64,
    longest: u64,
    most: u64,
    found: Vec<Piece>,
}

impl Cutting<'_> {
    /// Slots of consecutive points, from `point` of the cloud on.
    fn add_in_order(&mut self, slots: Range<u64>, point: u64) {
        let (from, ahead) = (self.first_point + point, slots.start);
        for slots in parts(slots, self.most.min(self.longest - ALIGNED)) {
            let bound = bound_of(from + slots.start - ahead..from + slots.end - ahead);
            let base = (from + slots.start - ahead - bound.start) as u32;
            self.add(slots, bound, base, None);
        }
    }

    /// Slots of later ensembles: of all at once if their points fit a binding, else of each as many rows as fit.
    fn add_rows(&mut self, rows: &PassRows, ensemble: u32, slots: Range<u64>, round: Range<u32>) {
        let all = rows.first..rows.first + rows.len();
        let again = |start, around| Again { rows: *rows, ensemble, start, around };
        if all.end <= rows.points && rows.len() + ALIGNED <= self.longest {
            self.add_bound(slots, all.start, all, again(0, u32::MAX));
        } else if rows.points + ALIGNED <= self.longest {
            self.add_bound(slots, 0, 0..rows.points, again(rows.first as u32, rows.points as u32));
        } else {
            for ensemble in round {
                self.add_by_rows(rows, ensemble - again(0, 0).ensemble, self.deal.slots(ensemble), again(0, u32::MAX));
            }
        }
    }

    /// Adds slots of one ensemble, `hand` of its pass, by rows; no row has both the cloud's last and first point.
    fn add_by_rows(&mut self, rows: &PassRows, hand: u32, slots: Range<u64>, again: Again) {
        let row = u64::from(rows.columns) << rows.block_bits;
        let fit = ((self.longest - ALIGNED) / row).max(1);
        // The row in which the cloud wraps around.
        let turning = (rows.points - rows.first) / row;
        let mut next = 0;
        while next < rows.count {
            let last = match next.cmp(&turning) {
                Ordering::Less => turning,
                Ordering::Equal => turning + 1,
                Ordering::Greater => rows.count,
            };
            let last = last.min(next + fit).min(rows.count);
            let within = |row: u64| (slots.start + (row << rows.block_bits)).min(slots.end);
            let here = within(next)..within(last);
            if next == turning {
                // Adds the chosen blocks one by one, in two parts if a block wraps around.
                let (mut from, start) = (here.start, slots.start);
                while from < here.end {
                    let point = rows.point(hand, from - start);
                    let end = here.end.min(from + (rows.points - point));
                    self.add_in_order(from..end, point);
                    from = end;
                }
            } else {
                let behind = if next > turning { rows.points } else { 0 };
                let points = rows.first + next * row - behind..rows.first + last * row - behind;
                // Counted from where the first row would be, had the cloud no end: perhaps before its beginning.
                let from = rows.first.wrapping_sub(behind);
                self.add_bound(here, from, points, again);
            }
            next = last;
        }
    }

    /// Adds slots of rows whose points lie within some of the cloud, counted from `from`.
    fn add_bound(&mut self, slots: Range<u64>, from: u64, points: Range<u64>, again: Again) {
        let bound = bound_of(self.first_point + points.start..self.first_point + points.end);
        let base = self.first_point.wrapping_add(from).wrapping_sub(bound.start) as u32;
        for slots in parts(slots, self.most) {
            self.add(slots, bound.clone(), base, Some(again));
        }
    }

    fn add(&mut self, slots: Range<u64>, bound: Range<u64>, base: u32, rows: Option<Again>) {
        let slots = slots.start - self.first..slots.end - self.first;
        self.found.push(Piece { slots, bound, base, rows });
    }
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

/// Returns the number of bits of a key that are left for epochs beside the index of one of `points`, at most 31.
pub fn epoch_bits(points: u64) -> u32 {
    points.saturating_sub(1).leading_zeros().saturating_sub(32).min(31)
}

/// Numbers of epochs, newest last: each larger than the one before, and none is 0, which marks an empty pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Epochs {
    bits: u32,
    next: u32,
}

impl Epochs {
    /// Starts the epochs of planes that were just cleared. Without bits there is one epoch.
    pub fn new(bits: u32) -> Self {
        Self { bits, next: 1 }
    }

    /// Returns the number of epochs.
    pub fn most(bits: u32) -> u32 {
        ((1u32 << bits) - 1).max(1)
    }

    /// Returns the next epoch in the uppermost bits of a word; `None` when the planes must be cleared again.
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
                    Some(Again { rows, ensemble: from, start, around }) => {
                        let n = first + n - deal.slots(ensemble).start;
                        let straight = PassRows { first: 0, points: u64::MAX, ..rows };
                        let along = start + straight.point(ensemble - from, n) as u32;
                        piece.base.wrapping_add(along - if along < around { 0 } else { around })
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
            (5, 300_000, 8_900_000, 30, 40_000, 7_000),
            (9, 70_000, 690_000, 100, 33_000, u64::MAX),
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
