//! A cloud's points by the words that shuffle them.

use std::cmp::Ordering;
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use super::buckets::{Buckets, Plan, points_of};
use super::pile::{Extent, Pile};
use super::records::Layout;
use super::{Seen, Settings, Source};
use crate::io::Error;
use crate::points::{Anchor, Points};
use crate::prepare::ensembles::Shuffle;
use crate::prepare::morton::Cells;
use crate::prepare::{keyed, order};
use crate::progress::Progress;

/// Bytes of memory for each point of a block while it is read.
const READ_BYTES: u64 = 512;

/// What is known of a cloud's points, and where those of each bucket are.
pub(super) type Sorted = (Seen, Vec<Vec<Extent>>);

/// What puts a cloud's points into order.
struct Sorting<'a> {
    path: &'a Path,
    pile: &'a Pile,
    layout: Layout,
    plan: Plan,
    shuffle: Shuffle,
    anchor: Anchor,
    cells: Cells,
    progress: &'a Progress,
}

/// Puts the cloud at a place among the others into buckets, each in order. `None` without points that are drawn.
pub(super) fn sorted(
    source: &Source<'_>,
    place: u32,
    pile: &Pile,
    settings: &Settings,
    progress: &Progress,
) -> Result<Option<Sorted>, Error> {
    let layout = Layout { has_normals: settings.has_normals };
    let sorting = Sorting {
        path: source.path,
        pile,
        layout,
        plan: Plan::new(source.blocks.iter().sum(), layout, settings.memory),
        shuffle: Shuffle::new(place, settings.seed),
        anchor: source.anchor,
        cells: Cells::of(&source.bounds),
        progress,
    };
    let (seen, mut buckets) = sorting.scatter(source, settings.memory)?;
    let moved = sorting.count_places(&mut buckets)?;
    for (bucket, moved) in buckets.iter_mut().zip(moved).filter(|(_, moved)| !moved.is_empty()) {
        bucket.extend(moved);
        let points = sorting.read(bucket)?;
        let order = sorting.order(&points);
        *bucket = sorting.replace(bucket, &points, &order)?;
    }
    Ok(seen.map(|seen| (seen, buckets)))
}

impl Sorting<'_> {
    fn check(&self) -> Result<(), Error> {
        self.progress.check().map_err(|_| Error::Cancelled { path: self.path.to_path_buf() })
    }

    /// All points by the words that they have if they are the first in their places.
    fn scatter(&self, source: &Source<'_>, memory: u64) -> Result<(Option<Seen>, Vec<Vec<Extent>>), Error> {
        let (mut seen, mut buckets) = (None, Buckets::new(self.plan, self.pile));
        let read = |block: usize| -> Result<_, Error> {
            let points = (source.read)(block)?;
            let mut words = Vec::with_capacity(points.len() * self.layout.words());
            let mut places = Vec::with_capacity(points.len());
            for at in 0..points.len() {
                let id = self.anchor.id(points.positions[at], 0);
                places.push(self.plan.bucket(self.shuffle.word(id)) as u32);
                self.layout.put(&points, at, id, &mut words);
            }
            self.progress.inc(source.blocks[block]);
            Ok((Seen::of(&points), places, words))
        };
        for batch in batches(&source.blocks, memory / 2 / READ_BYTES) {
            self.check()?;
            let parts = batch.into_par_iter().map(read).collect::<Result<Vec<_>, Error>>()?;
            for (own, places, words) in parts {
                seen = [seen, own].into_iter().flatten().reduce(Seen::and);
                for (bucket, record) in places.into_iter().zip(words.chunks_exact(self.layout.words())) {
                    buckets.add(bucket as usize, record)?;
                }
            }
        }
        Ok((seen, buckets.finish()?))
    }

    /// Puts each bucket into order. Whoever is not the first in a place gets an id of its own, and goes to another bucket: returns
    /// those that each is to get.
    fn count_places(&self, buckets: &mut [Vec<Extent>]) -> Result<Vec<Vec<Extent>>, Error> {
        let mut moved = Buckets::new(self.plan, self.pile);
        for bucket in buckets {
            self.check()?;
            let points = self.read(bucket)?;
            let order = self.order(&points);
            self.progress.inc(order.len() as u64);
            let bits = |at: u32| points.positions[at as usize].to_array().map(f64::to_bits);
            let (mut firsts, mut nth) = (Vec::with_capacity(order.len()), 0);
            for (i, at) in order.iter().enumerate() {
                nth = if i > 0 && bits(order[i - 1]) == bits(*at) { nth + 1 } else { 0 };
                if nth == 0 {
                    firsts.push(*at);
                    continue;
                }
                let id = self.anchor.id(points.positions[*at as usize], nth);
                let mut record = Vec::with_capacity(self.layout.words());
                self.layout.put(&points, *at as usize, id, &mut record);
                moved.add(self.plan.bucket(self.shuffle.word(id)), &record)?;
            }
            *bucket = self.replace(bucket, &points, &firsts)?;
        }
        moved.finish()
    }

    fn read(&self, bucket: &[Extent]) -> Result<Points, Error> {
        self.plan.check(points_of(self.layout, bucket), self.path)?;
        let mut words = Vec::new();
        bucket.iter().try_for_each(|extent| self.pile.read(*extent, &mut words))?;
        Ok(self.layout.points(&words))
    }

    /// The order of the shuffle: by words, equal words in canonical order.
    fn order(&self, points: &Points) -> Vec<u32> {
        let word = |at: u32| self.shuffle.word(points.dealt_ids[at as usize]);
        let code = |at: u32| self.cells.code(points.positions[at as usize]);
        let compare = |a: u32, b: u32| -> Ordering {
            let content = || order::by_content((points, a as usize), (points, b as usize));
            word(a).cmp(&word(b)).then_with(|| code(a).cmp(&code(b))).then_with(content)
        };
        // Codes have 63 bits; the last one is left to the comparison.
        let keyed = keyed::sorted(points.len() as u32, |at| word(at) >> 1, &compare);
        keyed.into_iter().map(|keyed| keyed.index).collect()
    }

    /// Puts some points of a bucket in place of it.
    fn replace(&self, bucket: &[Extent], points: &Points, order: &[u32]) -> Result<Vec<Extent>, Error> {
        let mut words = Vec::with_capacity(order.len() * self.layout.words());
        for at in order {
            self.layout.put(points, *at as usize, points.dealt_ids[*at as usize], &mut words);
        }
        self.pile.replace(bucket, &words)
    }
}

/// Blocks that have at most so many points together, or one.
fn batches(blocks: &[u64], most: u64) -> Vec<Range<usize>> {
    let (mut found, mut first, mut points) = (Vec::new(), 0, 0);
    for (at, own) in blocks.iter().enumerate() {
        if at > first && points + own > most {
            found.push(first..at);
            (first, points) = (at, 0);
        }
        points += own;
    }
    if first < blocks.len() {
        found.push(first..blocks.len());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_all_blocks() {
        assert_eq!(batches(&[3, 3, 3, 9, 1], 6), [0..2, 2..3, 3..4, 4..5]);
        assert_eq!(batches(&[5], 1), vec![0..1]);
        assert!(batches(&[], 1).is_empty());
    }
}
