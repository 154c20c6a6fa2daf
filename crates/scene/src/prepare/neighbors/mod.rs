//! The nearest neighbors of every point, independent of the order of the points.
//!
//! The K nearest other points, without the point itself, are those of least distance, computed in float64 from the
//! original positions; of equal distances those of smaller x, then y, then z; of equal positions by normal (up to its
//! sign). They are listed by rank, so that shuffled points have the same neighbors, in the same sequence, to the bit.

mod region;
mod search;
mod tree;

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use pellucid_core::progress::Progress;
use rayon::prelude::*;

use self::search::{Columns, NearestPlaces, Search, WIDER};
use self::tree::{Cuboid, LEAF, PlaceTree};
use super::keyed::Keyed;
use super::morton;
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;

/// Places between two steps of the progress bar.
const BLOCK: usize = 1 << 12;

/// The distinct positions of a cloud and the points at each.
///
/// Points have ranks: place by place in Morton order, so that consecutive queries touch the same memory, and by normal
/// within a place.
///
/// Lists that would hold each number at its own place take no memory: a hundred million points need each byte.
pub(super) struct Places {
    /// The index in the cloud, by rank; `None` if ranks are the order of the cloud.
    order: Option<Vec<u32>>,
    /// The number of points.
    points: usize,
    /// The rank of each point of the cloud, once it is asked for where that isn't the order of the cloud.
    ranks: OnceLock<Vec<u32>>,
    /// First rank of each place, with their number as the last entry; empty if each place has one point.
    starts: Vec<u32>,
    /// Places by rank; empty if each place has one point.
    places: Vec<u32>,
    /// Finds places.
    tree: PlaceTree,
    columns: Columns,
    /// World units in which distances are given; a power of two.
    pub unit: f64,
}

/// A power of two, of 2⁻⁴⁰⁰ times the size of a cloud or more: it keeps squared distances from overflow, and those of
/// down to 10⁻²⁷⁰ of that size from underflow, which one outlier at 10¹⁷⁰ would cause otherwise. Scaling by it rounds
/// nothing else.
fn unit(bounds: &Bounds) -> f64 {
    let half_side = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
    if half_side > 0.0 { (half_side.log2().floor() - 400.0).clamp(-1022.0, 1023.0).exp2() } else { 1.0 }
}

/// The bits of a position, the two zeros being one.
fn position_key(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Integers in the order of a normal's coordinates, the same for both of its directions.
fn normal_key(normal: Vec3) -> [i32; 3] {
    let first = normal.to_array().into_iter().find(|x| *x != 0.0).unwrap_or_default();
    let normal = if first < 0.0 { -normal } else { normal };
    // In the order of `f32::total_cmp`.
    (normal + Vec3::ZERO).to_array().map(|x| {
        let bits = x.to_bits() as i32;
        bits ^ (((bits >> 31) as u32) >> 1) as i32
    })
}

/// The place of each number in a list of all numbers below its length.
fn inverse(order: &[u32]) -> Vec<u32> {
    let places: Vec<AtomicU32> = order.iter().map(|_| AtomicU32::new(0)).collect();
    order.par_iter().enumerate().for_each(|(place, &number)| places[number as usize].store(place as u32, Relaxed));
    places.into_iter().map(AtomicU32::into_inner).collect()
}

/// Puts many points of one Morton code into the order of codes within their own bounds, and so on: an outlier a
/// thousand kilometers away has all others in a few cells.
fn refine(cell: &mut [Keyed], positions: &[DVec3], by_content: &(impl Fn(u32, u32) -> Ordering + Sync)) {
    if cell.len() <= LEAF {
        return;
    }
    let members: Vec<DVec3> = cell.iter().map(|keyed| positions[keyed.index as usize]).collect();
    let Some(bounds) = Bounds::of(&members).filter(|bounds| bounds.min != bounds.max) else { return };
    let indices: Vec<u32> = cell.iter().map(|keyed| keyed.index).collect();
    let content = |a: u32, b: u32| by_content(indices[a as usize], indices[b as usize]);
    let mut order = morton::sorted(&members, &bounds, content);
    if order[0].code() == order[order.len() - 1].code() {
        // Too small for halves of it.
        return;
    }
    order.iter_mut().for_each(|keyed| keyed.index = indices[keyed.index as usize]);
    order.par_chunk_by_mut(|a, b| a.code() == b.code()).for_each(|cell| refine(cell, positions, by_content));
    cell.iter_mut().zip(order).for_each(|(keyed, sorted)| keyed.index = sorted.index);
}

impl Places {
    /// Groups points by place, from finite positions; `None` if there are none, or 2³² and more, of which no renderer
    /// takes as many, either.
    pub fn group(positions: &[DVec3], normals: Option<&[Vec3]>) -> Option<Self> {
        Self::group_within(positions, normals, &Bounds::of(positions)?)
    }

    /// Returns the same of some points of a cloud with these bounds. Their ranks are in the order of those of the whole
    /// cloud, as far as all points are there that share a cell of [`morton::cell_side`] with one of them.
    pub fn group_within(positions: &[DVec3], normals: Option<&[Vec3]>, bounds: &Bounds) -> Option<Self> {
        // Ranks have 32 bits.
        u32::try_from(positions.len()).ok().filter(|count| *count > 0)?;
        let normal = |i: usize| normals.map_or([0; 3], |normals| normal_key(normals[i]));
        let by_content = |a: u32, b: u32| {
            let [a, b] = [a as usize, b as usize];
            let by_position = position_key(positions[a]).cmp(&position_key(positions[b]));
            by_position.then_with(|| normal(a).cmp(&normal(b)))
        };
        let mut keyed = morton::sorted(positions, bounds, by_content);
        keyed.par_chunk_by_mut(|a, b| a.code() == b.code()).for_each(|cell| refine(cell, positions, &by_content));
        let stay = keyed.par_iter().enumerate().all(|(rank, keyed)| keyed.index as usize == rank);
        let order = (!stay).then(|| parallel::map_each(&keyed, |keyed| keyed.index));
        let points = positions.len();
        let at = |rank: usize| positions[order.as_ref().map_or(rank, |order| order[rank] as usize)];
        let is_first = |rank: &u32| *rank == 0 || at(*rank as usize) != at(*rank as usize - 1);
        let ranks = || (0..points as u32).into_par_iter().with_min_len(BLOCK);
        let are_alone = ranks().all(|rank| is_first(&rank));
        let mut starts: Vec<u32> = if are_alone { Vec::new() } else { ranks().filter(is_first).collect() };
        let len = if are_alone { points } else { starts.len() };
        let first = |place: usize| if are_alone { place } else { starts[place] as usize };
        let codes: Vec<u64> = parallel::map(len, |place| keyed[first(place)].code());
        drop(keyed);
        let unit = unit(bounds);
        let columns = Columns::new(len, |place| at(first(place)), unit);
        let tree = PlaceTree::new(&columns, &codes);
        let mut places = Vec::new();
        if !are_alone {
            starts.push(points as u32);
            places.reserve_exact(points);
            for (place, ends) in starts.windows(2).enumerate() {
                places.resize(ends[1] as usize, place as u32);
            }
        }
        Some(Self { order, points, ranks: OnceLock::new(), starts, places, tree, columns, unit })
    }

    /// Returns the number of distinct positions.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Returns the number of points.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Returns the index in the cloud of the point of a rank.
    #[inline]
    pub fn index(&self, rank: usize) -> usize {
        self.order.as_ref().map_or(rank, |order| order[rank] as usize)
    }

    /// Returns the ranks of the points at a place.
    #[inline]
    pub fn members(&self, place: usize) -> Range<usize> {
        if self.are_alone() { place..place + 1 } else { self.starts[place] as usize..self.starts[place + 1] as usize }
    }

    /// Returns the place of the point of a rank.
    #[inline]
    pub fn place_of(&self, rank: u32) -> usize {
        if self.are_alone() { rank as usize } else { self.places[rank as usize] as usize }
    }

    /// Returns the position of a place in [`Places::unit`]s.
    #[inline]
    pub fn position(&self, place: usize) -> DVec3 {
        self.columns.position(place)
    }

    /// Returns `true` if each place has one point: ranks are numbers of places then.
    pub fn are_alone(&self) -> bool {
        self.starts.is_empty()
    }

    /// Returns `of` the rank of each point, in the order of the cloud.
    pub fn in_order_of_cloud<T: Zeroable + Send>(&self, of: impl Fn(u32) -> T + Sync) -> Vec<T> {
        match &self.order {
            None => parallel::map(self.points, |rank| of(rank as u32)),
            Some(order) => parallel::map_each(self.ranks.get_or_init(|| inverse(order)), |rank| of(*rank)),
        }
    }

    /// Returns values by rank in the order of the cloud.
    pub fn of_cloud<T: Pod + Send + Sync>(&self, by_rank: Vec<T>) -> Vec<T> {
        if self.order.is_none() { by_rank } else { self.in_order_of_cloud(|rank| by_rank[rank as usize]) }
    }

    /// The number of the `k` nearest others of a point at `place` that have another position: 0 if `k` others share
    /// this one.
    fn elsewhere(&self, place: usize, k: usize) -> usize {
        (k + 1).saturating_sub(self.members(place).len())
    }

    /// Returns the ranks of those of the `k` nearest others of a point at `place` that have another position, in
    /// ascending order, and the distance of the last in [`Places::unit`]s.
    pub fn others(&self, place: usize, k: usize) -> (Vec<u32>, f64) {
        let mut ranks = Vec::new();
        let distance = self.take(place, k, self.new_search(k).one(place), &mut ranks);
        (ranks, distance)
    }

    /// Takes the ranks of [`Places::others`] out of the places that were found, those as near as the k-th other one;
    /// the distance of the last in units.
    fn take(&self, place: usize, k: usize, found: NearestPlaces<'_>, ranks: &mut Vec<u32>) -> f64 {
        let NearestPlaces { places: found, last, .. } = found;
        ranks.clear();
        let wanted = self.elsewhere(place, k);
        if wanted == 0 {
            return 0.0;
        }
        let is_single = |place: u32| self.starts[place as usize + 1] - self.starts[place as usize] == 1;
        let are_alone = self.are_alone();
        if found.len() == k + 1 && (are_alone || found.iter().all(|&place| is_single(place))) {
            // Written whether it is another or not: no branch to mispredict.
            let mut count = 0;
            ranks.resize(found.len(), 0);
            for &other in found {
                ranks[count] = if are_alone { other } else { self.starts[other as usize] };
                count += usize::from(other as usize != place);
            }
            ranks.truncate(count);
            return last.sqrt();
        }
        let places = self.sorted(place, found);
        let all =
            places.iter().flat_map(|&(squared, place)| self.members(place).map(move |rank| (squared, rank as u32)));
        let mut distance = 0.0;
        ranks.extend(all.take(wanted).map(|(squared, rank)| {
            distance = squared;
            rank
        }));
        ranks.sort_unstable();
        distance.sqrt()
    }

    /// Places with their squared distances from `place`, itself left out, in the order of neighbors.
    fn sorted(&self, place: usize, found: &[u32]) -> Vec<(f64, usize)> {
        let others = found.iter().map(|&there| there as usize).filter(|&there| there != place);
        let mut places: Vec<(f64, usize)> =
            others.map(|there| (self.columns.squared_between(place, there), there)).collect();
        places.sort_unstable_by(|a, b| {
            let coordinates = |place: usize| (self.columns.position(place) + DVec3::ZERO).to_array();
            let by_position = || {
                let [a, b] = [coordinates(a.1), coordinates(b.1)];
                a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
            };
            // Positions that differ by less than a float64 can say in this unit have places in the same order always.
            a.0.total_cmp(&b.0).then_with(by_position).then(a.1.cmp(&b.1))
        });
        places
    }

    /// Calls `see` for each place with [`Places::others`], on all cores, and returns what it returns.
    pub fn visit<T: Send>(
        &self,
        k: usize,
        progress: &Progress,
        see: impl Fn(usize, &[u32], f64) -> T + Sync,
    ) -> Vec<T> {
        let mut blocks: Vec<Vec<T>> = Vec::new();
        blocks.resize_with(self.len().div_ceil(BLOCK), Vec::new);
        self.visit_blocks(k, 0, progress, see, blocks.iter_mut().collect(), |seen, block: &mut &mut Vec<T>| {
            **block = seen;
        });
        let mut all = Vec::with_capacity(self.len());
        blocks.into_iter().for_each(|block| all.extend(block));
        all
    }

    /// Returns a column with an element for each place in blocks as [`Places::visit_blocks`] has them; of an empty
    /// column as many empty ones.
    pub fn blocks<'a, T>(&self, column: &'a mut [T]) -> impl Iterator<Item = &'a mut [T]> + use<'a, T> {
        column.chunks_mut(BLOCK).chain(std::iter::repeat_with(Default::default)).take(self.len().div_ceil(BLOCK))
    }

    /// Visits places like [`Places::visit`], some thousand at a time: `finish` has what `see` returned of a block of
    /// places, and that block's slot to put it in. Up to `room` bytes of neighbors are kept.
    pub fn visit_blocks<T, S: Send>(
        &self,
        k: usize,
        room: usize,
        progress: &Progress,
        see: impl Fn(usize, &[u32], f64) -> T + Sync,
        slots: Vec<S>,
        finish: impl Fn(Vec<T>, &mut S) + Sync,
    ) -> Lists {
        progress.set_length(self.len() as u64);
        let blocks_kept = room / (4 * k * BLOCK);
        let mut blocks: Vec<(S, Option<Kept>)> = slots.into_iter().map(|slot| (slot, None)).collect();
        parallel::for_each_mut(&mut blocks, |block, (slot, kept)| {
            let places = self.block(block);
            *kept = (block < blocks_kept).then(Kept::default);
            let mut seen = Vec::with_capacity(places.len());
            self.search(places.clone(), k, |place, ranks, distance| {
                seen.push(see(place, ranks, distance));
                kept.iter_mut().for_each(|kept| kept.add(ranks));
            });
            progress.inc(places.len() as u64);
            finish(seen, slot);
        });
        Lists { k, kept: blocks.into_iter().map(|(_, kept)| kept).collect() }
    }

    /// Calls `see` with the neighbors of each place whose value exceeds `times` the least one around it, on all cores;
    /// returns these places with what it returns, in the order of places.
    ///
    /// `distances` are those of the last neighbors, and the values. Around a place are all that are as near as its last
    /// neighbor, and some more.
    pub fn revisit_uneven(
        &self,
        k: usize,
        times: f64,
        distances: &[f64],
        see: impl Fn(usize, &[u32]) -> f64 + Sync,
    ) -> Vec<(usize, f64)> {
        let least = self.tree.least(distances);
        let around = |cuboid: &Cuboid, distance: f64| {
            times * self.tree.least_around(&least, cuboid, distance * distance * WIDER)
        };
        let look = |leaves: &[u32]| {
            let (mut search, mut ranks, mut changed) = (self.new_search(k), Vec::new(), Vec::new());
            for &leaf in leaves {
                let leaf = self.tree.nodes[leaf as usize];
                let places = leaf.first as usize..(leaf.first + leaf.leaf_len) as usize;
                // Most leaves are even as a whole.
                let farthest = distances[places.clone()].iter().copied().fold(0.0, f64::max);
                let least = around(&leaf.cuboid, farthest);
                let is_uneven = |place: &usize| {
                    let distance = distances[*place];
                    distance > least && distance > around(&Cuboid::at(self.columns.position(*place)), distance)
                };
                search.leaf(leaf, places.filter(is_uneven), |place, found| {
                    self.take(place, k, found, &mut ranks);
                    changed.push((place, see(place, &ranks)));
                });
            }
            changed
        };
        let changed: Vec<Vec<(usize, f64)>> = self.tree.leaves.par_chunks(BLOCK / LEAF).map(look).collect();
        changed.concat()
    }

    /// The places of a block.
    fn block(&self, block: usize) -> Range<usize> {
        block * BLOCK..((block + 1) * BLOCK).min(self.len())
    }

    fn new_search(&self, k: usize) -> Search<'_> {
        Search::new(&self.tree, &self.columns, k)
    }

    /// Calls `see` for each of some places with [`Places::others`].
    fn search(&self, places: Range<usize>, k: usize, mut see: impl FnMut(usize, &[u32], f64)) {
        let (mut search, mut ranks) = (self.new_search(k), Vec::with_capacity(k));
        for &leaf in &self.tree.leaves[self.tree.leaf_of(places.start)..] {
            let leaf = self.tree.nodes[leaf as usize];
            let (from, to) = (leaf.first as usize, (leaf.first + leaf.leaf_len) as usize);
            if from >= places.end {
                break;
            }
            search.leaf(leaf, from.max(places.start)..to.min(places.end), |place, found| {
                let distance = self.take(place, k, found, &mut ranks);
                see(place, &ranks, distance);
            });
        }
    }
}

/// The neighbors elsewhere of a block of places.
#[derive(Default)]
struct Kept {
    ranks: Vec<u32>,
    /// Start of each place's neighbors in `ranks`.
    starts: Vec<u32>,
}

impl Kept {
    /// Adds those of the next place.
    fn add(&mut self, ranks: &[u32]) {
        self.starts.push(self.ranks.len() as u32);
        self.ranks.extend_from_slice(ranks);
    }
}

/// The neighbors elsewhere of all places, as far as memory allows; the others are found again.
pub(super) struct Lists {
    k: usize,
    /// Retained neighbors, by block of places.
    kept: Vec<Option<Kept>>,
}

impl Lists {
    /// Calls `see` for each place with its neighbors, on all cores, and returns what it returns.
    pub fn visit<T: Send>(&self, places: &Places, see: impl Fn(usize, &[u32]) -> T + Sync) -> Vec<T> {
        let of_block = |block: usize| {
            let range = places.block(block);
            let mut seen = Vec::with_capacity(range.len());
            match &self.kept[block] {
                Some(Kept { ranks, starts }) => {
                    let list = |place: usize, start: u32| &ranks[start as usize..][..places.elsewhere(place, self.k)];
                    seen.extend(range.zip(starts).map(|(place, &start)| see(place, list(place, start))));
                }
                None => places.search(range, self.k, |place, ranks, _| seen.push(see(place, ranks))),
            }
            seen
        };
        (0..self.kept.len()).into_par_iter().flat_map_iter(of_block).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;

    /// Returns points on a plane and in a ball, copies of some, and outliers far from all.
    pub fn cloud(count: usize, seed: u64) -> Vec<DVec3> {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut number = || random.random::<f64>();
        let mut points: Vec<DVec3> = (0..count).map(|_| DVec3::new(number(), number(), 0.01 * number())).collect();
        points.extend((0..count / 4).map(|_| DVec3::new(number(), number(), number()) * 0.1));
        points.extend((0..20).map(|_| DVec3::new(number(), number(), number()) * 50.0));
        // On a grid: many at the same distance.
        points.extend((0..count / 4).map(|_| (DVec3::new(number(), number(), 0.0) * 16.0).floor() + 3.0 * DVec3::Z));
        points.extend_from_within(..count / 8);
        points
    }

    /// Finds the neighbors by all distances, in the order that the module states.
    fn brute_force(points: &[DVec3], places: &Places, place: usize, k: usize) -> (Vec<u32>, f64) {
        let at = |rank: usize| points[places.index(rank)];
        let here = at(places.members(place).start);
        let squared = |rank: usize| ((at(rank) - here) / places.unit).length_squared();
        let mut all: Vec<usize> = (0..points.len()).filter(|rank| !places.members(place).contains(rank)).collect();
        let key = |rank: usize| at(rank).to_array();
        all.sort_by(|&a, &b| {
            let by_position = || key(a).partial_cmp(&key(b)).unwrap().then(a.cmp(&b));
            squared(a).total_cmp(&squared(b)).then_with(by_position)
        });
        all.truncate((k + 1).saturating_sub(places.members(place).len()));
        let distance = all.last().map_or(0.0, |&rank| squared(rank).sqrt());
        let mut ranks: Vec<u32> = all.into_iter().map(|rank| rank as u32).collect();
        ranks.sort_unstable();
        (ranks, distance)
    }

    #[test]
    fn neighbors_are_those_of_brute_force() {
        for (count, k) in [(3, 1), (40, 7), (400, 24), (1500, 24), (1500, 90)] {
            let points = cloud(count, count as u64);
            let places = Places::group(&points, None).unwrap();
            let k = k.min(points.len() - 1);
            let see = |place: usize, others: &[u32], distance: f64| {
                assert_eq!((others.to_vec(), distance), brute_force(&points, &places, place, k), "{count} {k} {place}");
                assert_eq!(places.others(place, k), (others.to_vec(), distance), "{count} {k} {place}");
            };
            places.visit(k, &Progress::hidden(), see);
        }
    }

    #[test]
    fn distances_that_float32_cannot_tell_apart_are_told_apart() {
        let mut random = Pcg64::seed_from_u64(21);
        let mut number = || random.random::<f64>() - 0.5;
        // Shells about one point whose radii differ by some units of float64, and others far from the origin.
        let shell = |middle: DVec3, radius: f64, direction: DVec3| middle + radius * direction.normalize_or(DVec3::X);
        let mut points = vec![DVec3::ZERO, DVec3::splat(1e6)];
        for i in 0..200 {
            let (radius, direction) = (1.0 + f64::from(i) * 1e-15, DVec3::new(number(), number(), number()));
            points.extend([shell(points[0], radius, direction), shell(points[1], radius, direction)]);
        }
        let places = Places::group(&points, None).unwrap();
        for k in [1, 24, 100] {
            places.visit(k, &Progress::hidden(), |place, others, distance| {
                assert_eq!((others.to_vec(), distance), brute_force(&points, &places, place, k), "{k} {place}");
            });
        }
    }

    /// The order of ranks decides how many places a search looks at.
    #[test]
    fn a_stray_far_away_leaves_the_order_of_the_others_as_it_is() {
        let near = cloud(2000, 3);
        let extent = |points: &[DVec3], places: &Places| -> f64 {
            let all: Vec<DVec3> = (0..near.len()).map(|rank| points[places.index(rank)]).collect();
            all.chunks(LEAF).map(|some| Bounds::of(some).unwrap().diagonal()).sum()
        };
        let alone = extent(&near, &Places::group(&near, None).unwrap());
        for far in [1e4, 1e9, 1e170] {
            let with = [near.as_slice(), &[DVec3::splat(far)]].concat();
            let places = Places::group(&with, None).unwrap();
            let extent = extent(&with, &places);
            assert!(extent < 1.5 * alone, "{far}: {extent} instead of {alone}");
        }
    }

    #[test]
    fn points_in_the_order_of_ranks_have_the_neighbors_that_they_have_in_any() {
        let points = cloud(2000, 17);
        let distinct: Vec<DVec3> = {
            let places = Places::group(&points, None).unwrap();
            (0..places.len()).map(|place| points[places.index(places.members(place).start)]).collect()
        };
        for points in [points, distinct] {
            let places = Places::group(&points, None).unwrap();
            let ranked: Vec<DVec3> = (0..points.len()).map(|rank| points[places.index(rank)]).collect();
            let again = Places::group(&ranked, None).unwrap();
            assert!(again.order.is_none() && again.are_alone() == places.are_alone());
            let see = |places: &Places| places.visit(24, &Progress::hidden(), |_, others, d| (others.to_vec(), d));
            assert!(see(&again) == see(&places));
            let indices = places.in_order_of_cloud(|rank| places.index(rank as usize));
            assert!(indices.into_iter().eq(0..points.len()));
            assert_eq!(places.of_cloud(ranked.clone()), points);
            assert_eq!(again.of_cloud(ranked.clone()), ranked);
        }
    }

    #[test]
    fn a_block_that_cuts_a_leaf_changes_nothing() {
        let places = Places::group(&cloud(1000, 5), None).unwrap();
        let mut all = Vec::new();
        places.search(0..places.len(), 24, |place, ranks, last| all.push((place, ranks.to_vec(), last)));
        let mut parts = Vec::new();
        for from in (0..places.len()).step_by(7) {
            let part = from..(from + 7).min(places.len());
            places.search(part, 24, |place, ranks, last| parts.push((place, ranks.to_vec(), last)));
        }
        assert_eq!(all, parts);
        assert!(all.iter().map(|(place, ..)| *place).eq(0..places.len()));
    }

    #[test]
    fn neighbors_that_were_not_kept_are_found_again() {
        let places = Places::group(&cloud(9000, 11), None).unwrap();
        let found = places.visit(24, &Progress::hidden(), |_, others, _| others.to_vec());
        for blocks in 0..=3 {
            let (room, hidden) = (blocks * 4 * 24 * BLOCK, Progress::hidden());
            let lists = places.visit_blocks(24, room, &hidden, |_, _, _| (), vec![(); 3], |_, ()| ());
            assert_eq!(lists.kept.iter().flatten().count(), blocks);
            assert_eq!(lists.kept.len(), 3);
            assert!(lists.visit(&places, |_, others| others.to_vec()) == found, "{blocks} kept");
        }
    }

    #[test]
    fn every_uneven_place_is_visited_again_and_few_others() {
        let points = cloud(20_000, 13);
        let places = Places::group(&points, None).unwrap();
        let (k, times) = (24, 4.0);
        let distances = places.visit(k, &Progress::hidden(), |_, _, distance| distance);
        let is_uneven = |place: usize| {
            let (others, _) = places.others(place, k);
            others.iter().any(|&rank| distances[place] > times * distances[places.place_of(rank)])
        };
        let visited = places.revisit_uneven(k, times, &distances, |place, _| place as f64);
        assert!(visited.is_sorted() && visited.iter().all(|(place, value)| *value == *place as f64));
        let again = visited.len();
        for place in (0..places.len()).filter(|place| is_uneven(*place)) {
            assert!(visited.binary_search_by_key(&place, |(place, _)| *place).is_ok(), "place {place}");
        }
        // In the ball, the grid and about the outliers.
        assert!(0 < again && again < places.len() / 10, "{again} of {}", places.len());
    }

    #[test]
    fn points_too_far_or_too_near_for_squares_have_neighbors() {
        for (scale, stray) in [(1e-300, 1.0), (1e-160, 1.0), (1.0, 1.0), (1e150, 1.0), (1e307, 1.0), (1.0, 1e170)] {
            let mut points: Vec<DVec3> = cloud(300, 9).into_iter().map(|p| p * (scale * 0.01)).collect();
            points[0] *= stray;
            let places = Places::group(&points, None).unwrap();
            places.visit(24, &Progress::hidden(), |place, others, distance| {
                assert_eq!((others.to_vec(), distance), brute_force(&points, &places, place, 24), "{scale} {place}");
            });
        }
    }
}
