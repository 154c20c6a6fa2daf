//! The nearest places of a place.
//!
//! Places are looked for leaf by leaf: those of a leaf have nearly the same neighbors, so that the places around it are
//! gathered once, as far as the neighbors of the leaf before were. Where that would be too many, as around an outlier,
//! each place goes through the tree by itself, nearest box first.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use bytemuck::allocation::zeroed_vec;
use glam::DVec3;
use pulp::Arch;

use super::region::{LANES, Region, larger};
use super::tree::{Cuboid, LEAF, Node, PlaceTree};
use pellucid_core::parallel;

/// Places whose positions one thread copies at a time.
const COPIED: usize = 1 << 14;

/// Numbers that are tried before distances are selected by moving them.
const CUTS: usize = 8;

/// Widens a bound by the roundings of a distance and of a sum.
pub(super) const WIDER: f64 = 1.0 + 1e-14;

/// Squared distance from a leaf that is gathered for each of that to the farthest neighbor of a place before.
const AHEAD: f64 = 1.5;

/// Positions by place, a coordinate at a time, in the unit of distances.
#[derive(Debug, Default)]
pub(super) struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    /// The number of places, behind which infinity fills some lanes.
    len: usize,
}

impl Columns {
    /// Builds the search over so many places, given the position of each.
    pub fn new(len: usize, position: impl Fn(usize) -> DVec3 + Sync, unit: f64) -> Self {
        let per_unit = 1.0 / unit;
        let [mut x, mut y, mut z]: [Vec<f64>; 3] = std::array::from_fn(|_| zeroed_vec(len + LANES));
        let each = x.chunks_mut(COPIED).zip(y.chunks_mut(COPIED)).zip(z.chunks_mut(COPIED));
        let mut parts: Vec<_> = each.map(|((x, y), z)| [x, y, z]).collect();
        parallel::for_each_mut(&mut parts, |part, [x, y, z]| {
            for i in 0..x.len() {
                let place = part * COPIED + i;
                let position = if place < len { position(place) * per_unit } else { DVec3::INFINITY };
                [x[i], y[i], z[i]] = position.to_array();
            }
        });
        drop(parts);
        Self { x, y, z, len }
    }

    /// Returns the number of places.
    pub fn len(&self) -> usize {
        self.len
    }

    #[inline(always)]
    pub fn position(&self, place: usize) -> DVec3 {
        DVec3::new(self.x[place], self.y[place], self.z[place])
    }

    /// Returns the squared distance of two places.
    pub fn squared_between(&self, a: usize, b: usize) -> f64 {
        (self.position(b) - self.position(a)).length_squared()
    }

    /// Returns all coordinates, each axis by itself.
    #[inline(always)]
    pub fn all(&self) -> [&[f64]; 3] {
        // As long as the first, so that one test of an index serves all of them.
        let count = self.x.len();
        [&self.x, &self.y[..count], &self.z[..count]]
    }

    /// Returns the coordinates of some places from one on, each by itself; infinity behind the last.
    #[inline(always)]
    pub fn lanes(&self, first: usize) -> [&[f64]; 3] {
        let lanes = first..first + LANES;
        [&self.x[lanes.clone()], &self.y[lanes.clone()], &self.z[lanes]]
    }

    /// The squared distances of the places of a leaf, the rest of the list being of no meaning.
    #[inline]
    fn squared_of_leaf(&self, here: DVec3, first: usize, len: usize) -> [f64; LEAF] {
        let (x, y, z) = (&self.x[first..first + len], &self.y[first..first + len], &self.z[first..first + len]);
        let mut squared = [0.0; LEAF];
        for (i, squared) in squared.iter_mut().enumerate().take(len) {
            let (x, y, z) = (x[i] - here.x, y[i] - here.y, z[i] - here.z);
            *squared = x * x + y * y + z * z;
        }
        squared
    }
}

/// Places that were found, and their squared distances: the first `count` of each.
#[derive(Default)]
pub(super) struct Found {
    pub places: Vec<u32>,
    pub squared: Vec<f64>,
    pub count: usize,
}

impl Found {
    /// Makes room for at least so many places.
    #[inline(always)]
    pub fn make_room(&mut self, count: usize) {
        if self.places.len() < count {
            self.places.resize(count, 0);
            self.squared.resize(count, 0.0);
        }
    }
}

/// Finds the nearest places of one place after the other. It keeps what it learns from one for the next.
pub(super) struct Search<'a> {
    tree: &'a PlaceTree,
    columns: &'a Columns,
    region: Region,
    found: Found,
    /// Distances that selection may move.
    moved: Vec<f64>,
    boxes: BinaryHeap<Reverse<(u64, u32)>>,
    /// Squared distance of the last one wanted around the place before.
    last: f64,
    /// The largest of those of the leaf before.
    farthest: f64,
    wanted: usize,
    arch: Arch,
}

/// The places as near to one as the last one wanted, itself among them. All places if there are no more than wanted.
#[derive(Clone, Copy)]
pub(super) struct NearestPlaces<'a> {
    /// Places of the neighbors, in ascending order.
    pub places: &'a [u32],
    /// The largest of them.
    pub last: f64,
}

impl<'a> Search<'a> {
    /// Returns a search for `wanted` places in addition to the one that is asked for.
    pub fn new(tree: &'a PlaceTree, columns: &'a Columns, wanted: usize) -> Self {
        Self {
            tree,
            columns,
            region: Region::default(),
            found: Found::default(),
            moved: Vec::new(),
            boxes: BinaryHeap::new(),
            last: f64::INFINITY,
            farthest: f64::INFINITY,
            wanted,
            arch: Arch::new(),
        }
    }

    /// Calls `see` for each of some places of one leaf with what was found around it.
    pub fn leaf(&mut self, leaf: Node, places: impl Iterator<Item = usize>, see: impl FnMut(usize, NearestPlaces<'_>)) {
        self.arch.dispatch(|| self.leaf_in_vectors(leaf, places, see));
    }

    #[inline(always)]
    fn leaf_in_vectors(
        &mut self,
        leaf: Node,
        places: impl Iterator<Item = usize>,
        mut see: impl FnMut(usize, NearestPlaces<'_>),
    ) {
        let (mut farthest, mut is_first) = (0.0, true);
        let mut near = self.farthest.is_finite() && self.gather(&leaf, self.farthest * AHEAD);
        for place in places {
            let position = self.columns.position(place);
            let last = loop {
                if !near {
                    self.through_tree(position);
                    break self.keep_nearest();
                }
                let (found, wanted) = (&mut self.found, self.wanted + 1);
                let reach = if self.region.find(self.columns, position, wanted, self.last, found) {
                    let last = self.keep_nearest();
                    if last <= self.region.reach {
                        break last;
                    }
                    last
                } else {
                    4.0 * self.region.reach
                };
                near = self.gather(&leaf, reach * AHEAD);
            };
            if std::mem::take(&mut is_first) && !near {
                // How far places lie here is known now.
                near = self.gather(&leaf, last * AHEAD);
            }
            (self.last, farthest) = (last, larger(last, farthest));
            see(place, NearestPlaces { places: &self.found.places[..self.found.count], last });
        }
        if !is_first {
            self.farthest = farthest;
        }
    }

    /// Gathers the places within a squared distance of a leaf; false if that is of no use.
    #[inline(always)]
    fn gather(&mut self, leaf: &Node, reach: f64) -> bool {
        self.columns.len() > self.wanted && self.region.gather(self.tree, self.columns, &leaf.cuboid, reach)
    }

    /// Finds the neighbors of a single place, like [`Search::leaf`].
    pub fn one(&mut self, place: usize) -> NearestPlaces<'_> {
        self.through_tree(self.columns.position(place));
        let last = self.keep_nearest();
        NearestPlaces { places: &self.found.places[..self.found.count], last }
    }

    /// Finds at least the places wanted through the tree, nearest box first.
    fn through_tree(&mut self, here: DVec3) {
        let Self { tree, columns, found: all, moved, boxes, wanted, .. } = self;
        let point = Cuboid::at(here);
        let mut count = 0;
        boxes.clear();
        let (mut bound, mut most) = (f64::INFINITY, 4 * (*wanted + LEAF));
        let key = |node: u32| Reverse((tree.nodes[node as usize].cuboid.squared(&point).to_bits(), node));
        boxes.push(key(0));
        while let Some(Reverse((distance, index))) = boxes.pop() {
            if f64::from_bits(distance) > bound {
                break;
            }
            let node = tree.nodes[index as usize];
            if node.leaf_len == 0 {
                let left = index + 1;
                boxes.push(key(left));
                boxes.push(key(tree.nodes[left as usize].next));
                continue;
            }
            let (first, len) = (node.first as usize, node.leaf_len as usize);
            all.make_room(count + len);
            let (found, squared) = (&mut all.places, &mut all.squared);
            for (i, distance) in columns.squared_of_leaf(here, first, len).iter().enumerate().take(len) {
                if *distance <= bound {
                    (found[count], squared[count]) = ((first + i) as u32, *distance);
                    count += 1;
                }
            }
            // Those too far are dropped before they are many more than wanted.
            if count > most {
                (count, bound) = nearest(&mut found[..count], &mut squared[..count], moved, *wanted);
                most = most.max(2 * count);
            }
        }
        sort_together(&mut all.places[..count], &mut all.squared[..count]);
        all.count = count;
    }

    /// Drops those farther than the last one wanted; its squared distance.
    #[inline(always)]
    fn keep_nearest(&mut self) -> f64 {
        let Found { places, squared, count } = &mut self.found;
        let last;
        (*count, last) = nearest(&mut places[..*count], &mut squared[..*count], &mut self.moved, self.wanted);
        last
    }
}

/// Puts places and their distances into ascending order of places.
fn sort_together(found: &mut [u32], squared: &mut [f64]) {
    let mut both: Vec<(u32, f64)> = found.iter().copied().zip(squared.iter().copied()).collect();
    both.sort_unstable_by_key(|(place, _)| *place);
    for (i, (place, distance)) in both.into_iter().enumerate() {
        (found[i], squared[i]) = (place, distance);
    }
}

/// Moves the places as near as the one after `wanted` others to the front, in their order; their number and the squared
/// distance of that one. Of fewer places all stay.
#[inline(always)]
fn nearest(found: &mut [u32], squared: &mut [f64], moved: &mut Vec<f64>, wanted: usize) -> (usize, f64) {
    let limit = if squared.len() > wanted + 1 {
        cut(squared, wanted + 1).unwrap_or_else(|| {
            moved.clear();
            moved.extend_from_slice(squared);
            *moved.select_nth_unstable_by(wanted, f64::total_cmp).1
        })
    } else {
        f64::INFINITY
    };
    let mut kept = 0;
    for i in 0..found.len() {
        (found[kept], squared[kept]) = (found[i], squared[i]);
        kept += usize::from(squared[i] <= limit);
    }
    (kept, largest(&squared[..kept]))
}

/// A number that so many of some distances don't exceed, by counting and interpolating. `None` where it isn't soon
/// found, as where many are equal.
#[inline(always)]
fn cut(squared: &[f64], wanted: usize) -> Option<f64> {
    let (mut low, mut high) = ((0.0, 0), (largest(squared), squared.len()));
    for _ in 0..CUTS {
        let share = (wanted as f64 + 0.5 - low.1 as f64) / (high.1 - low.1) as f64;
        let middle = low.0 + (high.0 - low.0) * share;
        // As floats, which compare and add in vectors.
        let count = squared.iter().fold(0, |count, distance| count + u64::from(*distance <= middle)) as usize;
        match count.cmp(&wanted) {
            Ordering::Equal => return Some(middle),
            Ordering::Less => low = (middle, count),
            Ordering::Greater => high = (middle, count),
        }
    }
    None
}

/// The largest of some distances.
#[inline(always)]
fn largest(squared: &[f64]) -> f64 {
    // Of several lanes, which don't wait for each other.
    let (all, rest) = squared.as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for squared in all {
        for (lane, squared) in lanes.iter_mut().zip(squared) {
            *lane = larger(*lane, *squared);
        }
    }
    lanes.iter().chain(rest).copied().fold(0.0, larger)
}
