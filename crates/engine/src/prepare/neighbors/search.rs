//! The nearest places of a place.
//!
//! Places are looked for leaf by leaf: those of a leaf have nearly the same neighbors, so that the leaves around it are
//! gathered once, within a distance that the neighbors of a place nearby bound (the triangle inequality). Where that would be
//! too many leaves, as around a stray, each place goes through the tree by itself, nearest box first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use super::tree::{Cuboid, LEAF, Node, Tree};

/// Places in the leaves around one, above which each of its places is looked for by itself.
const MOST_AROUND: usize = 4096;

/// Places that were looked for last: their distances bound those of the next.
const RECENT: usize = 16;

/// Widens a bound by the roundings of a distance and of a sum.
const WIDER: f64 = 1.0 + 1e-14;

/// Positions by place, a coordinate at a time.
#[derive(Debug, Default)]
pub(super) struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    /// One over the unit of distances, a power of two: scaling rounds nothing.
    pub per_unit: f64,
}

impl Columns {
    pub fn new(positions: &[DVec3], unit: f64) -> Self {
        let column = |axis: usize| positions.iter().map(|p| p[axis]).collect();
        Self { x: column(0), y: column(1), z: column(2), per_unit: 1.0 / unit }
    }

    pub fn position(&self, place: usize) -> DVec3 {
        DVec3::new(self.x[place], self.y[place], self.z[place])
    }

    /// The squared distance of two places.
    pub fn squared_between(&self, a: usize, b: usize) -> f64 {
        self.squared(self.position(a), self.position(b))
    }

    /// The squared distance of two positions.
    fn squared(&self, a: DVec3, b: DVec3) -> f64 {
        ((b - a) * self.per_unit).length_squared()
    }

    /// The squared distances of the places of a leaf, the rest of the list being of no meaning.
    #[inline]
    fn squared_of_leaf(&self, here: DVec3, first: usize, len: usize) -> [f64; LEAF] {
        let (x, y, z) = (&self.x[first..first + len], &self.y[first..first + len], &self.z[first..first + len]);
        let mut squared = [0.0; LEAF];
        for (i, squared) in squared.iter_mut().enumerate().take(len) {
            let (x, y, z) = (x[i] - here.x, y[i] - here.y, z[i] - here.z);
            let (x, y, z) = (x * self.per_unit, y * self.per_unit, z * self.per_unit);
            *squared = x * x + y * y + z * z;
        }
        squared
    }
}

/// Finds the nearest places of one place after the other. It keeps what it learns from one for the next.
pub(super) struct Search<'a> {
    tree: &'a Tree,
    columns: &'a Columns,
    around: Around,
    /// Places that were found, and bits of their squared distances, which are ordered as the distances are: the first
    /// `count` of each.
    found: Vec<u32>,
    keys: Vec<u64>,
    count: usize,
    /// Keys that selection may move.
    moved: Vec<u64>,
    boxes: BinaryHeap<Reverse<(u64, u32)>>,
    /// Places that were looked for lately, each with the distance of the last one wanted around it.
    recent: [(DVec3, f64); RECENT],
    next_recent: usize,
    wanted: usize,
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
    /// The number of places in them.
    places: usize,
    /// The squared distance from the middle leaf within which there are all.
    reach: f64,
}

impl<'a> Search<'a> {
    /// A search for `wanted` places besides the one that is asked for.
    pub fn new(tree: &'a Tree, columns: &'a Columns, wanted: usize) -> Self {
        Self {
            tree,
            columns,
            around: Around::default(),
            found: Vec::new(),
            keys: Vec::new(),
            count: 0,
            moved: Vec::new(),
            boxes: BinaryHeap::new(),
            recent: [(DVec3::ZERO, f64::INFINITY); RECENT],
            next_recent: 0,
            wanted,
        }
    }

    /// Calls `see` for each of some places of one leaf, with the places as near as the last one wanted, itself among them, in
    /// ascending order, and with that one's squared distance. All places if there are no more than wanted.
    pub fn leaf(&mut self, leaf: Node, places: std::ops::Range<usize>, mut see: impl FnMut(usize, &[u32], f64)) {
        let here = self.columns.position(places.start);
        let farthest = places.clone().map(|place| self.columns.squared(here, self.columns.position(place)));
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
            see(place, &self.found[..self.count], last);
        }
    }

    /// Gathers the leaves within a distance of one; false if they hold too many places.
    fn gather(&mut self, leaf: &Node, reach: f64) -> bool {
        self.around.gather(self.tree, self.columns.per_unit, &leaf.cuboid, reach * reach * WIDER)
    }

    /// Like [`Search::leaf`] of one place.
    pub fn one(&mut self, place: usize) -> (&[u32], f64) {
        self.through_tree(self.columns.position(place));
        let last = self.keep_nearest();
        (&self.found[..self.count], last)
    }

    /// A distance within which as many places lie as are wanted, and the one that is asked for.
    fn bound(&self, here: DVec3) -> f64 {
        let through = |(there, distance): &(DVec3, f64)| distance + self.columns.squared(here, *there).sqrt();
        self.recent.iter().map(through).fold(f64::INFINITY, f64::min) * WIDER
    }

    fn remember(&mut self, position: DVec3, distance: f64) {
        self.recent[self.next_recent] = (position, distance);
        self.next_recent = (self.next_recent + 1) % RECENT;
    }

    /// Finds all places within a squared distance, in the leaves around. False if there are too few.
    fn within(&mut self, here: DVec3, bound: f64) -> bool {
        let Self { around, found, keys, columns, .. } = self;
        let bound = bound.min(around.reach);
        around.measure(here, columns.per_unit);
        if found.len() < around.places {
            found.resize(around.places, 0);
            keys.resize(around.places, 0);
        }
        let (found, keys) = (found.as_mut_slice(), keys.as_mut_slice());
        let mut count = 0;
        for (leaf, _) in around.leaves.iter().zip(&around.squared).filter(|(_, squared)| **squared <= bound) {
            let (first, len) = (leaf.first as usize, (leaf.leaf_len as usize).min(LEAF));
            let squared = columns.squared_of_leaf(here, first, len);
            // Written whether it is near enough or not: no branch to mispredict.
            for (i, squared) in squared.iter().enumerate().take(len) {
                keys[count] = squared.to_bits();
                found[count] = (first + i) as u32;
                count += usize::from(*squared <= bound);
            }
        }
        self.count = count;
        count > self.wanted
    }

    /// Finds at least the places wanted through the tree, nearest box first.
    fn through_tree(&mut self, here: DVec3) {
        let Self { tree, columns, found, keys, moved, boxes, wanted, .. } = self;
        let point = Cuboid { min: here, max: here };
        let mut count = 0;
        boxes.clear();
        let (mut bound, mut most) = (f64::INFINITY, 4 * (*wanted + LEAF));
        let key =
            |node: u32| Reverse((tree.nodes[node as usize].cuboid.squared(&point, columns.per_unit).to_bits(), node));
        boxes.push(key(0));
        while let Some(Reverse((squared, index))) = boxes.pop() {
            if f64::from_bits(squared) > bound {
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
                keys.resize(count + len, 0);
            }
            for (i, squared) in columns.squared_of_leaf(here, first, len).iter().enumerate().take(len) {
                if *squared <= bound {
                    (found[count], keys[count]) = ((first + i) as u32, squared.to_bits());
                    count += 1;
                }
            }
            // Those too far are dropped before they are many more than wanted.
            if count > most {
                let last;
                (count, last) = nearest(&mut found[..count], &mut keys[..count], moved, *wanted);
                bound = f64::from_bits(last);
                most = most.max(2 * count);
            }
        }
        sort_together(&mut found[..count], &mut keys[..count]);
        self.count = count;
    }

    /// Drops those farther than the last one wanted; its squared distance.
    fn keep_nearest(&mut self) -> f64 {
        let (found, keys) = (&mut self.found[..self.count], &mut self.keys[..self.count]);
        let last;
        (self.count, last) = nearest(found, keys, &mut self.moved, self.wanted);
        f64::from_bits(last)
    }
}

/// Puts places and their keys into ascending order of places.
fn sort_together(found: &mut [u32], keys: &mut [u64]) {
    let mut both: Vec<(u32, u64)> = found.iter().copied().zip(keys.iter().copied()).collect();
    both.sort_unstable();
    for (i, (place, key)) in both.into_iter().enumerate() {
        (found[i], keys[i]) = (place, key);
    }
}

/// Moves the places as near as the one after `wanted` others to the front, in their order; their number and the key of that
/// one. Of fewer places all stay.
fn nearest(found: &mut [u32], keys: &mut [u64], moved: &mut Vec<u64>, wanted: usize) -> (usize, u64) {
    moved.clear();
    moved.extend_from_slice(keys);
    let last = match moved.len().checked_sub(wanted + 1) {
        Some(_) => *moved.select_nth_unstable(wanted).1,
        None => moved.iter().copied().max().unwrap_or_default(),
    };
    let mut kept = 0;
    for i in 0..found.len() {
        (found[kept], keys[kept]) = (found[i], keys[i]);
        kept += usize::from(keys[i] <= last);
    }
    (kept, last)
}

impl Around {
    /// Gathers the leaves within a squared distance of a leaf; false if their places are too many.
    fn gather(&mut self, tree: &Tree, per_unit: f64, leaf: &Cuboid, reach: f64) -> bool {
        self.truncate(0);
        (self.places, self.reach) = (0, reach);
        let mut index = 0;
        while let Some(node) = tree.nodes.get(index) {
            let squared = node.cuboid.squared(leaf, per_unit);
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

    /// Finds the squared distances of the leaves from a place.
    fn measure(&mut self, here: DVec3, per_unit: f64) {
        let count = self.leaves.len();
        self.squared.resize(count, 0.0);
        let [x0, y0, z0, x1, y1, z1] = &self.edges;
        let (x0, y0, z0) = (&x0[..count], &y0[..count], &z0[..count]);
        let (x1, y1, z1) = (&x1[..count], &y1[..count], &z1[..count]);
        for (i, squared) in self.squared.iter_mut().enumerate() {
            let apart = |low: f64, high: f64, here: f64| larger(larger(low - here, here - high), 0.0) * per_unit;
            let (x, y, z) = (apart(x0[i], x1[i], here.x), apart(y0[i], y1[i], here.y), apart(z0[i], z1[i], here.z));
            *squared = x * x + y * y + z * z;
        }
    }
}

/// The larger of two numbers; one instruction, which `f64::max` is not.
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
