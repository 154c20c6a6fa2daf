//! Points by the words that shuffle them, in the pieces of a file: a bucket holds those between two words.

use std::path::Path;

use super::pile::{Extent, Pile, words_of};
use super::records::Layout;
use crate::io::Error;

/// Most buckets.
const MOST: u64 = 1 << 10;
/// Fewest points of a bucket on average, if there are as many.
const LEAST_POINTS: u64 = 1 << 12;
/// Bytes of memory that the points of a bucket take for each of them while they are put into order.
const POINT_BYTES: u64 = 256;
/// Words of a piece of a bucket, at the most and at the least.
const MOST_WORDS: u64 = 1 << 14;
const LEAST_WORDS: u64 = 1 << 8;

/// How many buckets there are, and what they may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub buckets: u64,
    /// Points that are added to a bucket before they are written.
    points_at_once: u64,
    memory: u64,
    layout: Layout,
}

impl Plan {
    /// For so many points, within so much memory.
    pub fn new(points: u64, layout: Layout, memory: u64) -> Self {
        let fit = (memory / 2 / POINT_BYTES).max(LEAST_POINTS);
        // A hundredth more is a matter of chance.
        let buckets = (points + points / 64).div_ceil(fit).clamp(1, MOST);
        let words = (memory / 8 / 4 / buckets).clamp(LEAST_WORDS, MOST_WORDS);
        Self { buckets, points_at_once: (words / layout.words() as u64).max(1), memory, layout }
    }

    /// The bucket of a word.
    pub fn bucket(&self, word: u64) -> usize {
        ((u128::from(word) * u128::from(self.buckets)) >> 64) as usize
    }

    /// Refuses to put more points of a cloud into order at a time than memory is there for.
    pub fn check(&self, points: u64, path: &Path) -> Result<(), Error> {
        let needed = points * POINT_BYTES;
        if points <= LEAST_POINTS * 2 || needed <= self.memory {
            return Ok(());
        }
        Err(Error::Crowded { path: path.to_path_buf(), points, needed })
    }
}

/// The buckets of a cloud.
pub(super) struct Buckets<'a> {
    plan: Plan,
    pile: &'a Pile,
    /// Of each what is written, and what is not yet.
    all: Vec<(Vec<Extent>, Vec<u32>)>,
}

impl<'a> Buckets<'a> {
    /// Empty ones.
    pub fn new(plan: Plan, pile: &'a Pile) -> Self {
        Self { plan, pile, all: vec![(Vec::new(), Vec::new()); plan.buckets as usize] }
    }

    /// Adds a point to a bucket.
    pub fn add(&mut self, bucket: usize, record: &[u32]) -> Result<(), Error> {
        let (written, waiting) = &mut self.all[bucket];
        waiting.extend_from_slice(record);
        if waiting.len() >= self.plan.points_at_once as usize * self.plan.layout.words() {
            written.push(self.pile.add(waiting)?);
            waiting.clear();
        }
        Ok(())
    }

    /// Where the points of each are, all written.
    pub fn finish(self) -> Result<Vec<Vec<Extent>>, Error> {
        let pile = self.pile;
        let written = |(mut written, waiting): (Vec<Extent>, Vec<u32>)| {
            if !waiting.is_empty() {
                written.push(pile.add(&waiting)?);
            }
            Ok(written)
        };
        self.all.into_iter().map(written).collect()
    }
}

/// Points of some extents.
pub(super) fn points_of(layout: Layout, extents: &[Extent]) -> u64 {
    words_of(extents) / layout.words() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_follow_the_words() {
        let layout = Layout { has_normals: false };
        let plan = Plan::new(1_000_000, layout, 64 << 20);
        // 32 MiB hold 131,072 points.
        assert_eq!(plan.buckets, 8);
        assert_eq!([0, 1 << 61, (1 << 61) - 1, u64::MAX].map(|word| plan.bucket(word)), [0, 1, 0, 7]);
        assert_eq!(Plan::new(3, layout, 0).buckets, 1);
        let path = Path::new("scan.laz");
        assert!(plan.check(262_144, path).is_ok());
        let error = plan.check(262_145, path).unwrap_err().to_string();
        assert!(error.starts_with("scan.laz: 262145 points") && error.contains("--host-memory"), "{error}");
    }
}
