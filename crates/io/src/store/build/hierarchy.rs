//! hierarchy.bin from the nodes of an octree, in chunks as PotreeConverter makes them.

use std::collections::{HashMap, VecDeque};

use serde::{Deserialize, Serialize};

use super::super::octree::hierarchy::{INNER, LEAF, NODE_BYTES, PROXY};
use super::super::octree::nodes::NodeExtent;
use super::cube::Cell;

/// Levels of a chunk; the nodes of the next one are roots of their own.
pub(super) const STEP: u32 = 4;

/// A node whose points are written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Written {
    pub cell: Cell,
    /// Offset of the node's first byte in octree.bin.
    pub offset: u64,
    pub bytes: u64,
    pub points: u32,
    /// Extent that has points.
    pub extent: Option<NodeExtent>,
}

/// The file.
pub(super) struct Bytes {
    pub bytes: Vec<u8>,
    /// Bytes of the chunk with the root.
    pub first_chunk: u64,
    /// The deepest level.
    pub depth: u32,
}

/// Returns the file of some nodes, which it sorts by level and name. The parents of all are among them.
pub(super) fn write(nodes: &mut [Written]) -> Bytes {
    nodes.sort_unstable_by_key(|node| (node.cell.level, node.cell.name_order()));
    let index: HashMap<Cell, usize> = nodes.iter().enumerate().map(|(index, node)| (node.cell, index)).collect();
    // By Potree's numbers, whose highest bit is x.
    let digit = |name: u32| name >> 2 & 1 | name & 2 | (name & 1) << 2;
    let children: Vec<[Option<usize>; 8]> = nodes
        .iter()
        .map(|node| std::array::from_fn(|name| index.get(&node.cell.child(digit(name as u32))).copied()))
        .collect();
    let chunks = chunks(nodes, &children);
    let mut starts = HashMap::new();
    let mut start = 0;
    for chunk in &chunks {
        starts.insert(chunk[0], (start, chunk.len() * NODE_BYTES));
        start += chunk.len() * NODE_BYTES;
    }
    let mut bytes = Vec::with_capacity(start);
    for chunk in &chunks {
        let root = nodes[chunk[0]].cell.level;
        for (place, &at) in chunk.iter().enumerate() {
            let node = &nodes[at];
            let mask = (0..8).filter(|name| children[at][*name].is_some()).fold(0_u8, |mask, name| mask | 1 << name);
            let (kind, offset, length) = if place > 0 && node.cell.level == root + STEP {
                let (start, len) = starts[&at];
                (PROXY, start as u64, len as u64)
            } else {
                (if mask == 0 { LEAF } else { INNER }, node.offset, node.bytes)
            };
            bytes.extend([kind, mask]);
            bytes.extend(node.points.to_le_bytes());
            bytes.extend(offset.to_le_bytes());
            bytes.extend(length.to_le_bytes());
        }
    }
    let first_chunk = chunks.first().map_or(0, |chunk| chunk.len() * NODE_BYTES) as u64;
    Bytes { bytes, first_chunk, depth: nodes.last().map_or(0, |node| node.cell.level) }
}

/// The nodes of each chunk, breadth first, its root first.
fn chunks(nodes: &[Written], children: &[[Option<usize>; 8]]) -> Vec<Vec<usize>> {
    let mut chunks = Vec::new();
    let mut roots = VecDeque::from_iter((!nodes.is_empty()).then_some(0));
    while let Some(root) = roots.pop_front() {
        let mut chunk = vec![root];
        let mut next = 0;
        while let Some(&at) = chunk.get(next) {
            next += 1;
            if nodes[at].cell.level == nodes[root].cell.level + STEP {
                roots.push_back(at);
            } else {
                chunk.extend(children[at].iter().flatten());
            }
        }
        chunks.push(chunk);
    }
    chunks
}
