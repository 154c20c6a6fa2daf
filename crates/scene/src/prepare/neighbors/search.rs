//! The nearest places of a place.
//!
//! Places are looked for leaf by leaf: those of a leaf have nearly the same neighbors, so that the leaves around it are
//! gathered once, within a distance that the neighbors of a place nearby bound (the triangle inequality). Where that
//! would be too many leaves, as around an outlier, each place goes through the tree by itself, nearest box first.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec3;

use super::tree::{Cuboid, LEAF, Node, PlaceTree};
use pellucid_core::parallel;

/// Places in the leaves around one, above which each of its places is looked for by itself.
const MOST_AROUND: usize = 4096;

/// Places that were looked for last: their distances bound those of the next.
const RECENT: usize = 16;

/// Numbers that are tried before distances are selected by moving them.
const CUTS: usize = 8;

/// Widens a bound by the roundings of a distance and of a sum.
pub(super) const WIDER: f64 = 1.0 + 1e-14;

/// Positions by place, a coordinate at a time, in the unit of distances.
#[derive(Debug, Default)]
pub(super) struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Columns {
    /// Builds the search from positions by rank, and the first rank of each place.
    pub fn new(positions: &[DVec3], starts: &[u32], unit: f64) -> Self {
        let per_unit = 1.0 / unit;
        let column = |axis: usize| parallel::map_each(starts, |&rank| positions[rank as usize][axis] * per_unit);
        Self { x: column(0), y: column(1), z: column(2) }
    }

    pub fn position(&self, place: usize) -> DVec3 {
        DVec3::new(self.x[place], self.y[place], self.z[place])
    }

    /// Returns the squared distance of two places.
    pub fn squared_between(&self, a: usize, b: usize) -> f64 {
        (self.position(b) - self.position(a)).length_squared()
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

/// Finds the nearest places of one place after the other. It keeps what it learns from one for the next.
pub(super) struct Search<'a> {
    tree: &'a PlaceTree,
    columns: &'a Columns,
    around: Around,
    /// Places that were found, and their squared distances: the first `count` of each.
    found: Vec<u32>,
    squared: Vec<f64>,
    count: usize,
    /// Distances that selection may move.
    moved: Vec<f64>,
    boxes: BinaryHeap<Reverse<(u64, u32)>>,
    /// Places that were looked for lately, each with the distance of the last one wanted around it.
    recent: [(DVec3, f64); RECENT],
    next_recent: usize,
    wanted: usize,
}

/// The places as near to one as the last one wanted, itself among them. All places if there are no more than wanted.
#[derive(Clone, Copy)]
pub(super) struct NearestPlaces<'a> {
    /// Places of the neighbors, in ascending order.
    pub places: &'a [u32],
    /// The largest of them.
    pub last: f64,
}

/// The leaves around one.
#[derive(Default)]
struct Around {
    leaves: Vec<Node>,
    /// Bounds of the leaves, an edge at a time.
    edges: [Vec<f64>; 6],
    /// Squared distances of the leaves from the middle one.
    from_leaf: Vec<f64>,
    /// Squared distances from a place.
    squared: Vec<f64>,
    /// Places of the leaves that are near enough to it.
    near: Vec<u32>,
    /// The number of places in them.
    places: usize,
    /// The squared distance from the middle leaf within which there are all.
    reach: f64,
}

impl<'a> Search<'a> {
    /// Returns a search for `wanted` places in addition to the one that is asked for.
    pub fn new(tree: &'a PlaceTree, columns: &'a Columns, wanted: usize) -> Self {
        Self {
            tree,
            columns,
            around: Around::default(),
            found: Vec::new(),
            squared: Vec::new(),
            count: 0,
            moved: Vec::new(),
            boxes: BinaryHeap::new(),
            recent: [(DVec3::ZERO, f64::INFINITY); RECENT],
            next_recent: 0,
            wanted,
        }
    }

    /// Calls `see` for each of some places of one leaf with what was found around it.
    pub fn leaf(&mut self, leaf: Node, places: std::ops::Range<usize>, mut see: impl FnMut(usize, NearestPlaces<'_>)) {
        let here = self.columns.position(places.start);
        let farthest = places.clone().map(|place| self.columns.squared_between(places.start, place));
        let farthest = farthest.fold(0.0, f64::max).sqrt();
        let mut near = self.gather(&leaf, self.bound(here) + farthest);
        for place in places.clone() {
            let position = self.columns.position(place);
            let bound = self.bound(position);
            if !near || !self.within(position, bound * bound) {
                self.through_tree(position);
            }
            let last = self.keep_nearest();
            self.remember(position, last.sqrt());
            if place == places.start {
                // Of this place it is known now how far the last one is, of the others how far at most.
                let reach = (last.sqrt() + farthest) * WIDER;
                if near {
                    self.around.shrink(reach * reach * WIDER);
                } else {
                    near = self.gather(&leaf, reach);
                }
            }
            see(place, NearestPlaces { places: &self.found[..self.count], last });
        }
    }

    /// Gathers the leaves within a distance of one; false if they hold too many places.
    fn gather(&mut self, leaf: &Node, reach: f64) -> bool {
        self.around.gather(self.tree, &leaf.cuboid, reach * reach * WIDER)
    }

    /// Finds the neighbors of a single place, like [`Search::leaf`].
    pub fn one(&mut self, place: usize) -> NearestPlaces<'_> {
        self.through_tree(self.columns.position(place));
        let last = self.keep_nearest();
        NearestPlaces { places: &self.found[..self.count], last }
    }

    /// A distance within which as many places lie as are wanted, and the one that is asked for.
    fn bound(&self, here: DVec3) -> f64 {
        let through = |(there, distance): &(DVec3, f64)| distance + here.distance(*there);
        self.recent.iter().map(through).fold(f64::INFINITY, f64::min) * WIDER
    }

    fn remember(&mut self, position: DVec3, distance: f64) {
        self.recent[self.next_recent] = (position, distance);
        self.next_recent = (self.next_recent + 1) % RECENT;
    }

    /// Finds all places within a squared distance, in the leaves around. False if there are too few.
    fn within(&mut self, here: DVec3, bound: f64) -> bool {
        let Self { around, found, squared, columns, .. } = self;
        let bound = bound.min(around.reach);
        around.measure(here, bound);
        if found.len() < around.places {
            found.resize(around.places, 0);
            squared.resize(around.places, 0.0);
        }
        let (found, squared) = (found.as_mut_slice(), squared.as_mut_slice());
        let mut count = 0;
        for &leaf in &around.near {
            let leaf = &around.leaves[leaf as usize];
            let (first, len) = (leaf.first as usize, (leaf.leaf_len as usize).min(LEAF));
            let distances = columns.squared_of_leaf(here, first, len);
            // Written whether it is near enough or not: no branch to mispredict.
            for (i, distance) in distances.iter().enumerate().take(len) {
                (found[count], squared[count]) = ((first + i) as u32, *distance);
                count += usize::from(*distance <= bound);
            }
        }
        self.count = count;
        count > self.wanted
    }

    /// Finds at least the places wanted through the tree, nearest box first.
    fn through_tree(&mut self, here: DVec3) {
        let Self { tree, columns, found, squared, moved, boxes, wanted, .. } = self;
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
            if found.len() < count + len {
                found.resize(count + len, 0);
                squared.resize(count + len, 0.0);
            }
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
        sort_together(&mut found[..count], &mut squared[..count]);
        self.count = count;
    }

    /// Drops those farther than the last one wanted; its squared distance.
    fn keep_nearest(&mut self) -> f64 {
        let (found, squared) = (&mut self.found[..self.count], &mut self.squared[..self.count]);
        let last;
        (self.count, last) = nearest(found, squared, &mut self.moved, self.wanted);
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
    (kept, squared[..kept].iter().copied().fold(0.0, larger))
}

/// A number that so many of some distances don't exceed, by counting and interpolating. `None` where it isn't soon
/// found, as where many are equal.
fn cut(squared: &[f64], wanted: usize) -> Option<f64> {
    let (mut low, mut high) = ((0.0, 0), (squared.iter().copied().fold(0.0, larger), squared.len()));
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

impl Around {
    /// Gathers the leaves within a squared distance of a leaf; false if their places are too many.
    fn gather(&mut self, tree: &PlaceTree, leaf: &Cuboid, reach: f64) -> bool {
        self.truncate(0);
        (self.places, self.reach) = (0, reach);
        let mut index = 0;
        while let Some(node) = tree.nodes.get(index) {
            let squared = node.cuboid.squared(leaf);
            if squared > reach {
                index = node.next as usize;
                continue;
            }
            index += 1;
            if node.leaf_len > 0 {
                self.push(*node, squared);
                if self.places > MOST_AROUND {
                    return false;
                }
            }
        }
        true
    }

    fn push(&mut self, leaf: Node, squared: f64) {
        let Cuboid { min, max } = leaf.cuboid;
        for (edges, edge) in self.edges.iter_mut().zip([min.x, min.y, min.z, max.x, max.y, max.z]) {
            edges.push(edge);
        }
        self.places += leaf.leaf_len as usize;
        self.leaves.push(leaf);
        self.from_leaf.push(squared);
    }

    /// Drops the leaves beyond a squared distance.
    fn shrink(&mut self, reach: f64) {
        let mut kept = 0;
        for i in 0..self.leaves.len() {
            if self.from_leaf[i] > reach {
                continue;
            }
            self.leaves.swap(kept, i);
            self.from_leaf.swap(kept, i);
            self.edges.iter_mut().for_each(|edges| edges.swap(kept, i));
            kept += 1;
        }
        self.truncate(kept);
        self.places = self.leaves.iter().map(|leaf| leaf.leaf_len as usize).sum();
        self.reach = self.reach.min(reach);
    }

    fn truncate(&mut self, leaves: usize) {
        self.leaves.truncate(leaves);
        self.from_leaf.truncate(leaves);
        self.edges.iter_mut().for_each(|edges| edges.truncate(leaves));
    }

    /// Finds the leaves within a squared distance from a place.
    fn measure(&mut self, here: DVec3, bound: f64) {
        let count = self.leaves.len();
        self.squared.resize(count, 0.0);
        let [x0, y0, z0, x1, y1, z1] = &self.edges;
        let (x0, y0, z0) = (&x0[..count], &y0[..count], &z0[..count]);
        let (x1, y1, z1) = (&x1[..count], &y1[..count], &z1[..count]);
        for (i, squared) in self.squared.iter_mut().enumerate() {
            let apart = |low: f64, high: f64, here: f64| larger(larger(low - here, here - high), 0.0);
            let (x, y, z) = (apart(x0[i], x1[i], here.x), apart(y0[i], y1[i], here.y), apart(z0[i], z1[i], here.z));
            *squared = x * x + y * y + z * z;
        }
        self.near.resize(count, 0);
        let mut kept = 0;
        for (leaf, squared) in self.squared.iter().enumerate() {
            self.near[kept] = leaf as u32;
            kept += usize::from(*squared <= bound);
        }
        self.near.truncate(kept);
    }
}

/// The larger of two numbers; one instruction, which `f64::max` is not.
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
