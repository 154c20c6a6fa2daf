//! hierarchy.bin: nodes of 22 bytes in chunks of a few levels, which refer to each other.

use std::collections::{HashSet, VecDeque};

use crate::number::{at, long, word};
use pellucid_core::cloud::Bounds;

/// Bytes of a node: type, mask of children, number of points, first byte, number of bytes.
pub(crate) const NODE_BYTES: usize = 22;

/// Types of nodes.
pub(crate) const INNER: u8 = 0;
/// A node without children.
pub(crate) const LEAF: u8 = 1;
/// A node that is the first one of another chunk.
pub(crate) const PROXY: u8 = 2;

/// Levels at most: float64 has no smaller boxes.
const MAX_LEVEL: u32 = 64;

/// A node as hierarchy.bin describes it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Listed {
    pub level: u32,
    pub parent: Option<u32>,
    /// The part of the root's box that is its own.
    pub bounds: Bounds,
    pub points: u64,
    /// Offset of the node's first byte in octree.bin.
    pub offset: u64,
    pub bytes: u64,
}

/// A record.
struct Record {
    kind: u8,
    children: u8,
    points: u32,
    offset: u64,
    bytes: u64,
}

impl Record {
    fn read(bytes: &[u8]) -> Self {
        let [kind, children] = at(bytes, 0);
        Self { kind, children, points: word(bytes, 2), offset: long(bytes, 6), bytes: long(bytes, 14) }
    }
}

/// A part of hierarchy.bin that is to be read.
struct HierarchyChunk {
    offset: u64,
    bytes: u64,
    /// The node that its first record is: level, parent and box.
    root: (u32, Option<u32>, Bounds),
}

/// Returns one of the eight parts of a box; Potree's numbers have x as the highest bit.
fn child_bounds(bounds: &Bounds, child: usize) -> Bounds {
    let half = 0.5 * (bounds.max - bounds.min);
    let mut part = *bounds;
    for (axis, bit) in [(0, 4), (1, 2), (2, 1)] {
        if child & bit == 0 {
            part.max[axis] -= half[axis];
        } else {
            part.min[axis] += half[axis];
        }
    }
    part
}

/// Returns all nodes, parents before their children, from the bytes of the file, the bytes of the first chunk, and the
/// box of the root. An error has place and cause. Every record is used at most once, so that no loop has no end.
pub(super) fn read(file: &[u8], first_chunk: u64, root: Bounds) -> Result<Vec<Listed>, (String, String)> {
    let mut parts = VecDeque::from([HierarchyChunk { offset: 0, bytes: first_chunk, root: (0, None, root) }]);
    let mut seen = HashSet::new();
    let mut nodes: Vec<Listed> = Vec::new();
    let most = file.len() / NODE_BYTES;
    while let Some(part) = parts.pop_front() {
        let place = || format!("hierarchy.bin: chunk at byte {}", part.offset);
        if !seen.insert(part.offset) {
            return Err((place(), "two nodes refer to it, so the hierarchy has a loop".to_owned()));
        }
        let start = usize::try_from(part.offset).ok();
        let end = part.offset.checked_add(part.bytes).and_then(|end| usize::try_from(end).ok());
        let Some(records) = start.zip(end).and_then(|(start, end)| file.get(start..end)) else {
            let cause = format!("{} bytes, but the file ends after {}", part.bytes, file.len());
            return Err((place(), cause));
        };
        if records.is_empty() || records.len() % NODE_BYTES != 0 {
            return Err((
                place(),
                format!("{} bytes are not a multiple of the {NODE_BYTES} bytes of a record", records.len()),
            ));
        }
        read_part(records, part.root, &mut nodes, &mut parts).map_err(|cause| (place(), cause))?;
        if nodes.len() > most {
            return Err((place(), "chunks overlap".to_owned()));
        }
    }
    Ok(nodes)
}

/// Adds the nodes of a chunk, and the chunks that it refers to.
fn read_part(
    records: &[u8],
    root: (u32, Option<u32>, Bounds),
    nodes: &mut Vec<Listed>,
    parts: &mut VecDeque<HierarchyChunk>,
) -> Result<(), String> {
    let mut waiting = VecDeque::from([root]);
    for (index, bytes) in records.chunks_exact(NODE_BYTES).enumerate() {
        let record = Record::read(bytes);
        let Some((level, parent, bounds)) = waiting.pop_front() else {
            return Err(format!("record {index} belongs to no node before it"));
        };
        if record.kind > PROXY || (index == 0 && record.kind == PROXY) {
            return Err(format!("record {index} is of type {}, which can't be there", record.kind));
        }
        if record.kind == PROXY {
            parts.push_back(HierarchyChunk {
                offset: record.offset,
                bytes: record.bytes,
                root: (level, parent, bounds),
            });
            continue;
        }
        let this = u32::try_from(nodes.len()).map_err(|_| "there are 2³² nodes or more".to_owned())?;
        // PotreeConverter writes nodes that it left empty with the number of points that they had.
        let points = if record.bytes == 0 { 0 } else { u64::from(record.points) };
        nodes.push(Listed { level, parent, bounds, points, offset: record.offset, bytes: record.bytes });
        if record.children != 0 && level == MAX_LEVEL {
            return Err(format!("record {index} has children beyond level {MAX_LEVEL}"));
        }
        let children = (0..8).filter(|child| record.children >> child & 1 == 1);
        waiting.extend(children.map(|child| (level + 1, Some(this), child_bounds(&bounds, child))));
    }
    match waiting.len() {
        0 => Ok(()),
        missing => Err(format!("{missing} children have no record")),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn record(kind: u8, children: u8, offset: u64, bytes: u64) -> Vec<u8> {
        [&[kind, children][..], &3u32.to_le_bytes(), &offset.to_le_bytes(), &bytes.to_le_bytes()].concat()
    }

    fn cube() -> Bounds {
        Bounds { min: DVec3::ZERO, max: DVec3::splat(8.0) }
    }

    #[test]
    fn chunks_are_put_together() {
        // A root with children 1 (high z) and 4 (high x), of which the latter is in a chunk of its own, with child 2.
        let file = [
            record(INNER, 0b1_0010, 0, 30),
            record(LEAF, 0, 30, 30),
            record(PROXY, 0b100, 66, 44),
            record(INNER, 0b100, 60, 30),
            record(LEAF, 0, 90, 0),
        ]
        .concat();
        let nodes = read(&file, 66, cube()).unwrap();
        let at = |i: usize| (nodes[i].level, nodes[i].parent, nodes[i].points, nodes[i].bounds.min.to_array());
        assert_eq!(at(0), (0, None, 3, [0.0; 3]));
        assert_eq!(at(1), (1, Some(0), 3, [0.0, 0.0, 4.0]));
        assert_eq!(at(2), (1, Some(0), 3, [4.0, 0.0, 0.0]));
        assert_eq!(at(3), (2, Some(2), 0, [4.0, 2.0, 0.0]));
        assert_eq!((nodes.len(), nodes[3].bounds.max), (4, DVec3::new(6.0, 4.0, 2.0)));
    }

    #[test]
    fn inconsistent_hierarchies_are_refused() {
        let refused = |records: &[Vec<u8>], first: u64, says: &str| {
            let (place, cause) = read(&records.concat(), first, cube()).unwrap_err();
            assert!(format!("{place}: {cause}").contains(says), "{place}: {cause}");
        };
        refused(&[record(INNER, 1, 0, 0), record(PROXY, 0, 0, 44)], 44, "loop");
        refused(&[record(INNER, 1, 0, 0), record(PROXY, 0, 22, 22)], 44, "can't be there");
        refused(&[record(INNER, 1, 0, 0)], 22, "have no record");
        refused(&[record(LEAF, 0, 0, 0), record(LEAF, 0, 0, 0)], 44, "no node before it");
        refused(&[record(LEAF, 0, 0, 0)], 44, "ends after 22");
        refused(&[record(INNER, 1, 0, 0), record(PROXY, 0, u64::MAX, 22)], 44, "ends after");
        refused(&[record(LEAF, 0, 0, 0)], 21, "not a multiple");
        refused(&[record(LEAF, 0, 0, 0)], 0, "not a multiple");
        refused(&[record(7, 0, 0, 0)], 22, "type 7");
        // Each chunk begins in the middle of the one before it.
        let twice: Vec<_> =
            (0..8).map(|i| record(INNER, 0xff, i, 0)).chain((0..8).map(|_| record(LEAF, 0, 0, 0))).collect();
        refused(&twice, 16 * 22, "have no record");
        let deep: Vec<_> = (0..70).map(|_| record(INNER, 1, 0, 0)).collect();
        refused(&deep, 70 * 22, "beyond level 64");
    }
}
