//! Boxes around points in Morton order: a binary tree whose leaves are cells of the curve.
//!
//! Distances to boxes are rounded as those to points are, operation by operation, and rounding keeps order: no point is
//! nearer, to the bit, than the box around it.

use glam::DVec3;

use super::search::Columns;

/// Places in a leaf at most.
pub(super) const LEAF: usize = 32;

/// Places below which a branch grows on one core.
const SERIAL: usize = 1 << 15;

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cuboid {
    pub min: DVec3,
    pub max: DVec3,
}

impl Cuboid {
    /// Returns the box of one position.
    pub fn at(position: DVec3) -> Self {
        Self { min: position, max: position }
    }

    fn around(positions: impl Iterator<Item = DVec3>) -> Self {
        let start = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        positions.fold(start, |all, p| Self { min: all.min.min(p), max: all.max.max(p) })
    }

    fn and(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns the squared distance of another box, zero if they touch.
    pub fn squared(&self, other: &Self) -> f64 {
        (self.min - other.max).max(other.min - self.max).max(DVec3::ZERO).length_squared()
    }
}

/// A node of the tree and all below it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub cuboid: Cuboid,
    /// The first of its places.
    pub first: u32,
    /// The number of its places in a leaf; 0 in an inner node.
    pub leaf_len: u32,
    /// The node after all below this one.
    pub next: u32,
}

/// The nodes in depth-first order, so that leaves come in the order of places: the first child follows its parent.
#[derive(Debug, Default)]
pub(super) struct PlaceTree {
    pub nodes: Vec<Node>,
    /// The nodes that are leaves.
    pub leaves: Vec<u32>,
}

impl PlaceTree {
    /// Builds the tree of distinct places with ascending Morton codes.
    pub fn new(columns: &Columns, codes: &[u64]) -> Self {
        let nodes = if codes.is_empty() { Vec::new() } else { branch(columns, codes, 0) };
        let leaves = nodes.iter().enumerate().filter(|(_, node)| node.leaf_len > 0);
        Self { leaves: leaves.map(|(index, _)| index as u32).collect(), nodes }
    }

    /// Returns the least value of the places below each node, from a value of each place.
    pub fn least(&self, values: &[f64]) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; self.nodes.len()];
        // Children come after their parent.
        for (index, node) in self.nodes.iter().enumerate().rev() {
            least[index] = if node.leaf_len > 0 {
                let places = node.first as usize..(node.first + node.leaf_len) as usize;
                values[places].iter().copied().fold(f64::INFINITY, f64::min)
            } else {
                let second = self.nodes[index + 1].next as usize;
                least[index + 1].min(least[second])
            };
        }
        least
    }

    /// Returns the least value in the leaves within a squared distance of a box, from those of [`PlaceTree::least`].
    pub fn least_around(&self, least: &[f64], cuboid: &Cuboid, squared: f64) -> f64 {
        let (mut found, mut index) = (f64::INFINITY, 0);
        while let Some(node) = self.nodes.get(index) {
            // Values that aren't less need no distance: even around an outlier, which everything lies around, few nodes
            // are looked at.
            if least[index] >= found || node.cuboid.squared(cuboid) > squared {
                index = node.next as usize;
                continue;
            }
            if node.leaf_len > 0 {
                found = least[index];
            }
            index += 1;
        }
        found
    }

    /// Returns the index among leaves of the one with a place.
    pub fn leaf_of(&self, place: usize) -> usize {
        self.leaves.partition_point(|&leaf| self.nodes[leaf as usize].first as usize <= place) - 1
    }
}

/// The nodes over places from `first` on, as if they were a tree of their own, grown on all cores.
fn branch(columns: &Columns, codes: &[u64], first: usize) -> Vec<Node> {
    if codes.len() <= SERIAL {
        let mut nodes = Vec::with_capacity(codes.len() / 4);
        add(&mut nodes, columns, codes, first);
        return nodes;
    }
    let (before, after) = codes.split_at(middle(codes));
    let (left, right) = rayon::join(|| branch(columns, before, first), || branch(columns, after, first + before.len()));
    let cuboid = left[0].cuboid.and(&right[0].cuboid);
    let count = 1 + left.len() + right.len();
    let mut nodes = Vec::with_capacity(count);
    nodes.push(Node { cuboid, first: first as u32, leaf_len: 0, next: count as u32 });
    for part in [left, right] {
        let before = nodes.len() as u32;
        nodes.extend(part.into_iter().map(|node| Node { next: node.next + before, ..node }));
    }
    nodes
}

/// Adds a node over places from `first` on. Its depth is at most 63, one for each bit of a code, and 32 below.
fn add(nodes: &mut Vec<Node>, columns: &Columns, codes: &[u64], first: usize) -> Cuboid {
    let node = nodes.len();
    let is_leaf = codes.len() <= LEAF;
    let leaf_len = if is_leaf { codes.len() as u32 } else { 0 };
    let nowhere = Cuboid { min: DVec3::ZERO, max: DVec3::ZERO };
    nodes.push(Node { cuboid: nowhere, first: first as u32, leaf_len, next: 0 });
    let cuboid = if is_leaf {
        Cuboid::around((first..first + codes.len()).map(|place| columns.position(place)))
    } else {
        let (before, after) = codes.split_at(middle(codes));
        let left = add(nodes, columns, before, first);
        left.and(&add(nodes, columns, after, first + before.len()))
    };
    let next = nodes.len() as u32;
    nodes[node] = Node { cuboid, next, ..nodes[node] };
    cuboid
}

/// Returns where to cut at least two places: at the highest bit in which their codes differ, or in the middle.
fn middle(codes: &[u64]) -> usize {
    let differing = codes[0] ^ codes[codes.len() - 1];
    match differing.checked_ilog2() {
        Some(bit) => codes.partition_point(|code| code >> bit & 1 == 0),
        None => codes.len() / 2,
    }
}
