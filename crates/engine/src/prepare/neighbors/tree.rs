//! Boxes around points in Morton order: a binary tree whose leaves are cells of the curve.
//!
//! Distances to boxes are rounded as those to points are, operation by operation, and rounding keeps order: no point is
//! nearer, to the bit, than the box around it.

use glam::DVec3;

/// Places in a leaf at most.
pub(super) const LEAF: usize = 32;

/// A box along the axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cuboid {
    pub min: DVec3,
    pub max: DVec3,
}

impl Cuboid {
    fn around(positions: &[DVec3]) -> Self {
        let start = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        positions.iter().fold(start, |all, p| Self { min: all.min.min(*p), max: all.max.max(*p) })
    }

    fn and(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The squared distance of another box, zero if they touch, in units of 1 / `per_unit`.
    pub fn squared(&self, other: &Self, per_unit: f64) -> f64 {
        let apart = (self.min - other.max).max(other.min - self.max).max(DVec3::ZERO) * per_unit;
        apart.length_squared()
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
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// The nodes that are leaves.
    pub leaves: Vec<u32>,
}

impl Tree {
    /// Of distinct positions with ascending Morton codes.
    pub fn new(positions: &[DVec3], codes: &[u64]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(positions.len() / 4), leaves: Vec::new() };
        if !positions.is_empty() {
            tree.add(positions, codes, 0);
        }
        let leaves = tree.nodes.iter().enumerate().filter(|(_, node)| node.leaf_len > 0);
        tree.leaves = leaves.map(|(index, _)| index as u32).collect();
        tree
    }

    /// Adds a node over places from `first` on. Its depth is at most 63, one for each bit of a code, and 32 below.
    fn add(&mut self, positions: &[DVec3], codes: &[u64], first: usize) -> Cuboid {
        let node = self.nodes.len();
        let is_leaf = positions.len() <= LEAF;
        let leaf_len = if is_leaf { positions.len() as u32 } else { 0 };
        let nowhere = Cuboid { min: DVec3::ZERO, max: DVec3::ZERO };
        self.nodes.push(Node { cuboid: nowhere, first: first as u32, leaf_len, next: 0 });
        let cuboid = if is_leaf {
            Cuboid::around(positions)
        } else {
            let middle = middle(codes);
            let (before, after) = (positions.split_at(middle), codes.split_at(middle));
            let left = self.add(before.0, after.0, first);
            left.and(&self.add(before.1, after.1, first + middle))
        };
        let next = self.nodes.len() as u32;
        self.nodes[node] = Node { cuboid, next, ..self.nodes[node] };
        cuboid
    }

    /// The index among leaves of the one with a place.
    pub fn leaf_of(&self, place: usize) -> usize {
        self.leaves.partition_point(|&leaf| self.nodes[leaf as usize].first as usize <= place) - 1
    }
}

/// Where to cut at least two places: at the highest bit in which their codes differ, or in the middle.
fn middle(codes: &[u64]) -> usize {
    let differing = codes[0] ^ codes[codes.len() - 1];
    match differing.checked_ilog2() {
        Some(bit) => codes.partition_point(|code| code >> bit & 1 == 0),
        None => codes.len() / 2,
    }
}
