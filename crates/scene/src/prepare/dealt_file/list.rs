//! A cloud's points by the words that shuffle them: as many of the first ones as were asked for.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::buckets::{BucketPlan, Buckets, Words, points_of};
use super::pile::{FileExtent, Pile};
use super::places::{self, Places};
use super::records::RecordLayout;
use super::{CloudBlocks, DealSettings, PointSummary};
use crate::batches::batches;
use crate::prepare::ensembles::Shuffle;
use crate::prepare::morton::Cells;
use crate::prepare::{keyed, order};
use pellucid_core::parallel;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_io::Error;

/// Bytes of memory for each point of a block while it is read.
const READ_BYTES: u64 = 512;
/// The part of the memory that goes to places in which there may be several points.
const PLACES_PART: u64 = 4;
/// Bytes of memory for each point that is put into order at least, if there are as many.
const LEAST_POINT_BYTES: u64 = 256;

/// The list of a cloud.
#[derive(Debug)]
pub(super) struct List {
    source: CloudBlocks,
    layout: RecordLayout,
    memory: u64,
    shuffle: Shuffle,
    cells: Cells,
    /// Box, opacities and brightest color of all points.
    pub seen: PointSummary,
    /// Number of points.
    pub len: u64,
    /// Places that seem to have several points, with more places.
    shared: Places,
    head: Mutex<Head>,
}

/// The beginning of a list.
#[derive(Debug, Default)]
struct Head {
    /// The end of its words.
    end: u128,
    /// Pieces of the list, each with its first point.
    pieces: Vec<(u64, FileExtent)>,
    /// Number of points.
    len: u64,
    /// Points in shared places, also those that don't belong to the head, with their ids.
    sharing: Option<Vec<Vec<FileExtent>>>,
}

impl List {
    /// Returns the list of the cloud at a place among the others, none of which is in order yet. `None` without points
    /// that are drawn.
    pub fn new(
        source: CloudBlocks,
        place: u32,
        settings: &DealSettings,
        progress: &Progress,
    ) -> Result<Option<Self>, Error> {
        let all = source.blocks.iter().sum();
        let [once, shared] = [(); 2].map(|()| Places::new(all, settings.memory / PLACES_PART));
        let look = |block: usize| -> Result<_, Error> {
            let points = (source.read)(block)?;
            for position in &points.positions {
                let number = places::number(*position);
                if once.add(number) {
                    shared.add(number);
                }
            }
            progress.inc(source.blocks[block]);
            Ok((PointSummary::of(&points), points.len() as u64))
        };
        let (mut seen, mut len) = (None, 0);
        for batch in batches(source.blocks.iter().copied(), settings.memory / 4 / READ_BYTES, usize::MAX) {
            check(&source, progress)?;
            let blocks: Vec<usize> = batch.collect();
            for (own, points) in parallel::try_map_each(&blocks, |block| look(*block))? {
                seen = [seen, own].into_iter().flatten().reduce(PointSummary::and);
                len += points;
            }
        }
        Ok(seen.map(|seen| Self {
            layout: RecordLayout { has_normals: settings.has_normals },
            memory: settings.memory,
            shuffle: Shuffle::new(place, settings.seed),
            cells: Cells::of(&source.bounds),
            seen,
            len,
            shared,
            head: Mutex::default(),
            source,
        }))
    }

    fn head(&self) -> MutexGuard<'_, Head> {
        self.head.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the number of points that are in order.
    pub fn reached(&self) -> u64 {
        self.head().len
    }

    /// Puts points into order, as far as up to so many.
    pub fn reach(&self, end: u64, pile: &Pile, progress: &Progress) -> Result<(), Error> {
        let head = &mut *self.head();
        while head.len < end.min(self.len) {
            // How many there are is a matter of chance.
            let wanted = end + end / 64 + self.memory / LEAST_POINT_BYTES;
            let some = (u128::from(wanted) << 64) / u128::from(self.len);
            let to = if wanted < self.len / 2 && some > head.end { some } else { Words::END };
            self.extend(head, Words { start: head.end, end: to }, pile, progress)?;
        }
        Ok(())
    }

    /// Words of records of some points, which must have been reached.
    pub fn read(&self, range: Range<u64>, pile: &Pile, into: &mut Vec<u32>) -> Result<(), Error> {
        let (size, head) = (self.layout.words() as u64, self.head());
        let mut at = head.pieces.partition_point(|(first, _)| *first <= range.start).saturating_sub(1);
        let mut next = range.start;
        while let Some((first, extent)) = head.pieces.get(at).filter(|_| next < range.end) {
            let end = range.end.min(first + extent.words / size);
            let start = extent.start + (next - first) * size;
            pile.read(FileExtent { start, words: (end - next) * size }, into)?;
            (next, at) = (end, at + 1);
        }
        Ok(())
    }

    /// Puts the points of the next words behind the head.
    fn extend(&self, head: &mut Head, words: Words, pile: &Pile, progress: &Progress) -> Result<(), Error> {
        let plan = BucketPlan::new(words.of(self.len), words, self.layout, self.memory);
        let mut buckets = Buckets::new(plan, pile);
        let sharing = match head.sharing.take() {
            Some(sharing) => self.scatter(&mut buckets, None, progress).map(|()| sharing)?,
            None => {
                let plan = BucketPlan::new(self.len, Words::ALL, self.layout, self.memory);
                let mut sharing = Buckets::new(plan, pile);
                self.scatter(&mut buckets, Some(&mut sharing), progress)?;
                let sharing = sharing.finish()?;
                sharing.iter().try_for_each(|bucket| self.tell_apart(bucket, pile, progress))?;
                sharing
            }
        };
        for extent in sharing.iter().flatten() {
            let mut some = Vec::new();
            pile.read(*extent, &mut some)?;
            for record in some.chunks_exact(self.layout.words()) {
                buckets.add(self.shuffle.word(RecordLayout::id(record)), record)?;
            }
        }
        head.sharing = Some(sharing);
        let buckets = buckets.finish()?;
        for bucket in &buckets {
            check(&self.source, progress)?;
            let points = self.points(bucket, pile)?;
            pile.overwrite(bucket, &self.records(&points, &self.order(&points)))?;
        }
        for extent in buckets.into_iter().flatten() {
            head.pieces.push((head.len, extent));
            head.len += points_of(self.layout, &[extent]);
        }
        head.end = words.end;
        Ok(())
    }

    /// Puts points that have their places to themselves into buckets by their words, and the others by their places.
    fn scatter(
        &self,
        buckets: &mut Buckets<'_>,
        mut sharing: Option<&mut Buckets<'_>>,
        progress: &Progress,
    ) -> Result<(), Error> {
        let (plan, collects, source) = (buckets.plan, sharing.is_some(), &self.source);
        let read = |block: usize| -> Result<_, Error> {
            let points = (source.read)(block)?;
            let [mut alone, mut others]: [(Vec<u64>, Vec<u32>); 2] = Default::default();
            for (at, position) in points.positions.iter().enumerate() {
                let (place, id) = (places::number(*position), source.anchor.id(*position, 0));
                let (word, wanted, (words, records)) = if self.shared.has(place) {
                    (place, collects, &mut others)
                } else {
                    let word = self.shuffle.word(id);
                    (word, plan.has(word), &mut alone)
                };
                if wanted {
                    words.push(word);
                    self.layout.put(&points, at, id, records);
                }
            }
            // Later it is a frame that is watched, of which this is no step.
            if collects {
                progress.inc(source.blocks[block]);
            }
            Ok([alone, others])
        };
        for batch in batches(source.blocks.iter().copied(), self.memory / 4 / READ_BYTES, usize::MAX) {
            check(source, progress)?;
            let blocks: Vec<usize> = batch.collect();
            for [alone, others] in parallel::try_map_each(&blocks, |block| read(*block))? {
                buckets.add_all(&alone.0, &alone.1)?;
                if let Some(sharing) = sharing.as_deref_mut() {
                    sharing.add_all(&others.0, &others.1)?;
                }
            }
        }
        Ok(())
    }

    /// Gives the points of each place, of which a bucket has all, ids of their own.
    fn tell_apart(&self, bucket: &[FileExtent], pile: &Pile, progress: &Progress) -> Result<(), Error> {
        check(&self.source, progress)?;
        let mut points = self.points(bucket, pile)?;
        // Those of a place have one word so far, and come in canonical order.
        let order = self.order(&points);
        let bits = |at: u32| points.positions[at as usize].to_array().map(f64::to_bits);
        let mut nth = 0;
        for (i, at) in order.iter().enumerate() {
            nth = if i > 0 && bits(order[i - 1]) == bits(*at) { nth + 1 } else { 0 };
            points.dealt_ids[*at as usize] = self.source.anchor.id(points.positions[*at as usize], nth);
        }
        pile.overwrite(bucket, &self.records(&points, &order))
    }

    fn points(&self, bucket: &[FileExtent], pile: &Pile) -> Result<Points, Error> {
        BucketPlan::check(points_of(self.layout, bucket), self.memory, &self.source.path)?;
        let mut words = Vec::new();
        bucket.iter().try_for_each(|extent| pile.read(*extent, &mut words))?;
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

    fn records(&self, points: &Points, order: &[u32]) -> Vec<u32> {
        let part = |order: &[u32]| {
            let mut words = Vec::with_capacity(order.len() * self.layout.words());
            for at in order {
                self.layout.put(points, *at as usize, points.dealt_ids[*at as usize], &mut words);
            }
            words
        };
        let parts: Vec<&[u32]> = order.chunks(1 << 14).collect();
        parallel::gather(parts.len(), |i| part(parts[i])).concat()
    }
}

fn check(source: &CloudBlocks, progress: &Progress) -> Result<(), Error> {
    progress.check().map_err(|_| Error::Cancelled { path: source.path.clone() })
}
