//! Points by words, in the pieces of a file: a bucket holds those between two words.

use std::path::Path;

use super::pile::{FileExtent, Pile};
use super::records::RecordLayout;
use pellucid_io::Error;

/// Most buckets.
const MOST: u64 = 1 << 10;
/// Fewest points of a bucket on average, if there are as many.
const LEAST_POINTS: u64 = 1 << 12;
/// Bytes of memory that the points of a bucket take for each of them while they are put into order.
const POINT_BYTES: u64 = 256;
/// Numbers of 32 bits of a piece of a bucket, at the most and at the least.
const MOST_NUMBERS: u64 = 1 << 14;
const LEAST_NUMBERS: u64 = 1 << 8;

/// Words from one on up to another, which is not among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Words {
    pub start: u128,
    pub end: u128,
}

impl Words {
    /// End of the range of words: one past the last.
    pub const END: u128 = 1 << 64;
    /// All words.
    pub const ALL: Self = Self { start: 0, end: Self::END };

    /// Returns those among points of all words that are to be expected.
    pub fn of(self, points: u64) -> u64 {
        ((u128::from(points) * (self.end - self.start)) >> 64) as u64
    }
}

/// Number of buckets, and the bytes that they may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct BucketPlan {
    words: Words,
    pub buckets: u64,
    /// Numbers of 32 bits that are added to a bucket before they are written.
    numbers_at_once: usize,
    layout: RecordLayout,
}

impl BucketPlan {
    /// Divides the range of words for about so many points of some words, within so much memory.
    pub fn new(points: u64, words: Words, layout: RecordLayout, memory: u64) -> Self {
        let fit = (memory / 2 / POINT_BYTES).max(LEAST_POINTS);
        // A hundredth more is a matter of chance.
        let buckets = (points + points / 64).div_ceil(fit).clamp(1, MOST);
        let numbers = (memory / 8 / 4 / buckets).clamp(LEAST_NUMBERS, MOST_NUMBERS) as usize;
        let numbers_at_once = numbers / layout.words() * layout.words();
        Self { words, buckets, numbers_at_once, layout }
    }

    /// Returns `true` if a word belongs to one of the buckets.
    pub fn has(&self, word: u64) -> bool {
        (self.words.start..self.words.end).contains(&u128::from(word))
    }

    /// The bucket of a word, if it is [there](Self::has).
    fn bucket(&self, word: u64) -> usize {
        let Words { start, end } = self.words;
        ((u128::from(word) - start) * u128::from(self.buckets) / (end - start)) as usize
    }

    /// Refuses to put more points of a cloud into order at a time than memory is there for.
    pub fn check(points: u64, memory: u64, path: &Path) -> Result<(), Error> {
        let needed = points * POINT_BYTES;
        if points <= LEAST_POINTS * 2 || needed <= memory {
            return Ok(());
        }
        Err(Error::Crowded { path: path.to_path_buf(), points, needed })
    }
}

/// The buckets of a cloud.
pub(super) struct Buckets<'a> {
    pub plan: BucketPlan,
    pile: &'a Pile,
    /// Flushed extents and pending words of each bucket.
    all: Vec<(Vec<FileExtent>, Vec<u32>)>,
}

impl<'a> Buckets<'a> {
    /// Empty ones.
    pub fn new(plan: BucketPlan, pile: &'a Pile) -> Self {
        Self { plan, pile, all: vec![(Vec::new(), Vec::new()); plan.buckets as usize] }
    }

    /// Adds a point to the bucket of its word, if there is one.
    pub fn add(&mut self, word: u64, record: &[u32]) -> Result<(), Error> {
        if !self.plan.has(word) {
            return Ok(());
        }
        let (written, waiting) = &mut self.all[self.plan.bucket(word)];
        waiting.extend_from_slice(record);
        if waiting.len() >= self.plan.numbers_at_once {
            written.push(self.pile.add(waiting)?);
            waiting.clear();
        }
        Ok(())
    }

    /// Adds points, each by its word.
    pub fn add_all(&mut self, words: &[u64], records: &[u32]) -> Result<(), Error> {
        let mut each = words.iter().zip(records.chunks_exact(self.plan.layout.words()));
        each.try_for_each(|(word, record)| self.add(*word, record))
    }

    /// Returns where the points of each bucket are, all written.
    pub fn finish(self) -> Result<Vec<Vec<FileExtent>>, Error> {
        let pile = self.pile;
        let written = |(mut written, waiting): (Vec<FileExtent>, Vec<u32>)| {
            if !waiting.is_empty() {
                written.push(pile.add(&waiting)?);
            }
            Ok(written)
        };
        self.all.into_iter().map(written).collect()
    }
}

/// Returns the number of points of some extents.
pub(super) fn points_of(layout: RecordLayout, extents: &[FileExtent]) -> u64 {
    extents.iter().map(|extent| extent.words).sum::<u64>() / layout.words() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_follow_the_words() {
        let layout = RecordLayout { has_normals: false };
        let plan = BucketPlan::new(1_000_000, Words::ALL, layout, 64 << 20);
        // 32 MiB hold 131,072 points.
        assert_eq!(plan.buckets, 8);
        assert_eq!([0, 1 << 61, (1 << 61) - 1, u64::MAX].map(|word| plan.bucket(word)), [0, 1, 0, 7]);
        assert!([0, u64::MAX].into_iter().all(|word| plan.has(word)));
        assert_eq!(BucketPlan::new(3, Words::ALL, layout, 0).buckets, 1);
    }

    #[test]
    fn buckets_of_some_words_hold_no_others() {
        let layout = RecordLayout { has_normals: false };
        let words = Words { start: 1 << 60, end: 1 << 62 };
        assert_eq!(words.of(1600), 300);
        let plan = BucketPlan::new(words.of(4_000_000), words, layout, 64 << 20);
        assert_eq!(plan.buckets, 6);
        let [first, last] = [1 << 60, (1 << 62) - 1];
        assert_eq!([first, last].map(|word| plan.bucket(word)), [0, 5]);
        assert_eq!([first - 1, first, last, last + 1].map(|word| plan.has(word)), [false, true, true, false]);
    }

    #[test]
    fn more_points_than_memory_holds_are_refused() {
        let path = Path::new("scan.laz");
        assert!(BucketPlan::check(262_144, 64 << 20, path).is_ok());
        let error = BucketPlan::check(262_145, 64 << 20, path).unwrap_err().to_string();
        assert!(error.starts_with("scan.laz: 262145 points") && error.contains("--host-memory"), "{error}");
    }
}
