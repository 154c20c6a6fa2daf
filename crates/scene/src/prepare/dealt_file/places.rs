//! Search for points that may share their places with others, in little memory.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

/// Bits for each point, if memory has them.
const POINT_BITS: u64 = 16;
/// Bits of a word that a place sets.
const MARKS: u32 = 3;

/// A set of places that may seem to hold others too, but never lacks one of its own: a Bloom filter whose places set
/// bits of one word each (Putze, Sanders, Singler 2009), so that threads add to it together.
#[derive(Debug)]
pub(super) struct Places {
    words: Vec<AtomicU64>,
}

impl Places {
    /// Creates an empty table for `points` points that uses at most `memory` bytes.
    pub fn new(points: u64, memory: u64) -> Self {
        let words = (points.saturating_mul(POINT_BITS) / 64).next_power_of_two().min((memory / 8).max(1));
        Self { words: (0..words).map(|_| AtomicU64::new(0)).collect() }
    }

    /// Adds a place by its number. True if it seems to have been there before: of several threads that add one place,
    /// all but one are told.
    pub fn add(&self, place: u64) -> bool {
        let marks = marks(place);
        self.word(place).fetch_or(marks, Ordering::Relaxed) & marks == marks
    }

    /// Returns `true` if a place seems to be there.
    pub fn has(&self, place: u64) -> bool {
        let marks = marks(place);
        self.word(place).load(Ordering::Relaxed) & marks == marks
    }

    fn word(&self, place: u64) -> &AtomicU64 {
        &self.words[((u128::from(place) * self.words.len() as u128) >> 64) as usize]
    }
}

/// The bits of a place in its word: by digits that have nothing to do with which word it is.
fn marks(place: u64) -> u64 {
    (0..MARKS).fold(0, |marks, digit| marks | 1 << (place >> (6 * digit) & 63))
}

/// Returns the number of a place: equal coordinates, to the bit, have equal numbers, others hardly ever. Each
/// coordinate is multiplied by 2⁶⁴ over the golden ratio, and the halves of the product folded (Knuth, The Art of
/// Computer Programming 3, 6.4).
pub(super) fn number(position: DVec3) -> u64 {
    position.to_array().into_iter().fold(1, |all: u64, coordinate| {
        let product = u128::from(all ^ coordinate.to_bits()) * 0x9e37_79b9_7f4a_7c15;
        (product >> 64) as u64 ^ product as u64
    })
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    fn place(i: u64) -> u64 {
        number(DVec3::new(i as f64 * 0.001, -0.5, (i % 7) as f64))
    }

    #[test]
    fn no_place_is_missed_and_few_are_mistaken() {
        let count = 100_000;
        // 138 and 2894 are to be expected: of a word with k marks set a mistake has the chance (k/64)³. Six standard
        // errors more.
        for (memory, most_mistaken) in [(1 << 20, 210), (64 << 10, 3250)] {
            let places = Places::new(count, memory);
            let mistaken = (0..count).into_par_iter().filter(|i| places.add(place(*i))).count();
            assert!(mistaken <= most_mistaken, "{mistaken} of {count} in {memory} bytes");
            assert!((0..count).into_par_iter().all(|i| places.has(place(i)) && places.add(place(i))));
        }
        let few = Places::new(count, 0);
        assert!(!few.add(1) && few.add(1));
        assert!(!Places::new(count, 1 << 20).has(place(3)));
    }

    #[test]
    fn of_threads_that_add_a_place_all_but_one_are_told() {
        let places = Places::new(1 << 16, 1 << 20);
        let told = (0..1 << 12).into_par_iter().filter(|i| places.add(place(i / 64))).count();
        assert_eq!(told, (1 << 12) - 64);
    }

    #[test]
    fn numbers_tell_zeros_apart() {
        let [plus, minus] = [0.0, -0.0].map(|x| number(DVec3::new(x, 0.0, 1.0)));
        assert_ne!(plus, minus);
    }
}
