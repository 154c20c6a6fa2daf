//! The points of a cell as a tree of nodes.
//!
//! What a node holds follows from the points in its cell alone: neither from their order nor from how they came in
//! parts. A cell with at most as many points as a node may have is a leaf. Any other one takes, for each part of its
//! grid, one of the points that the cells below it hold: the one with the least hash. Its grid is coarsened until these
//! are few enough for a node.

use std::cmp::Ordering;
use std::ops::Range;

use rayon::prelude::*;

use super::super::octree::attributes::{AttributeLayout, Role};
use super::super::octree::integers;
use super::cube::{CODE_LEVELS, Cell, Cube};
use pellucid_core::parallel;

/// Points below which a cell isn't divided among threads.
const ALONE: usize = 1 << 13;

/// Parts of a node's grid along an axis at most, as a binary logarithm.
const MAX_GRID_BITS: u32 = 7;

/// Rules that the nodes of a store have in common.
#[derive(Debug, Clone)]
pub(super) struct Rules {
    pub cube: Cube,
    pub stride: usize,
    pub node_points: usize,
    /// Binary logarithm of the parts of a node's grid along an axis.
    pub grid_bits: u32,
    /// The bytes of a record that are the point's place, which decides between equal points alone.
    place: Range<usize>,
}

/// A node whose points may still be taken by the one above.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Open {
    pub cell: Cell,
    /// Points in the cell.
    pub total: u64,
    /// `true` if there are nodes below.
    pub is_inner: bool,
    /// Records of the node's points, along the Morton curve.
    pub records: Vec<u8>,
}

/// A node as it is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Done {
    pub cell: Cell,
    pub records: Vec<u8>,
}

/// The order of a point: its code and its place among the records.
type Key = (u64, u32);

impl Rules {
    pub fn new(layout: &AttributeLayout, cube: Cube, node_points: usize) -> Self {
        let place =
            layout.find(&Role::Place).map_or(layout.stride..layout.stride, |place| place.at..place.at + place.bytes);
        // A surface through a node meets about three times the square of the parts along an axis.
        let grid_bits = (node_points / 3).max(4).ilog2() / 2;
        Self { cube, stride: layout.stride, node_points, grid_bits: grid_bits.min(MAX_GRID_BITS), place }
    }

    fn steps(&self, record: &[u8]) -> [u32; 3] {
        // The position is the first attribute.
        self.cube.steps_of(integers(record))
    }

    /// Returns the nodes of a cell from the records of its points: its own, which is open, and those below, along the
    /// Morton curve. There are fewer than 2³² points.
    pub fn grow(&self, cell: Cell, records: &[u8]) -> (Open, Vec<Done>) {
        let levels = CODE_LEVELS.min(self.cube.levels() - cell.level);
        let at = |index: usize| &records[index * self.stride..][..self.stride];
        let key = |index: usize| (self.cube.code(self.steps(at(index)), cell.level, levels), index as u32);
        let mut keys: Vec<Key> = parallel::map(records.len() / self.stride, key);
        keys.par_sort_unstable();
        let record = |key: &Key| at(key.1 as usize);
        let mut equal: Vec<_> = keys.chunk_by_mut(|a, b| a.0 == b.0).filter(|equal| equal.len() > 1).collect();
        let below = cell.level + levels;
        parallel::for_each_mut(&mut equal, |_, equal| {
            equal.par_sort_unstable_by(|a, b| self.compare(record(a), record(b), below));
        });
        Growth { rules: self, records, top: cell.level, levels }.cell(cell, &keys)
    }

    /// The order of points whose codes are the same down to a level.
    fn compare(&self, a: &[u8], b: &[u8], level: u32) -> Ordering {
        let rest = |record: &[u8]| self.cube.code(self.steps(record), level, self.cube.levels() - level);
        rest(a).cmp(&rest(b)).then_with(|| self.by_content(a, b))
    }

    /// Any fixed order of records; only equal ones are equal.
    fn by_content(&self, a: &[u8], b: &[u8]) -> Ordering {
        let without_place =
            |record: &[u8]| -> [usize; 2] { [self.place.start.min(record.len()), self.place.end.min(record.len())] };
        let ([start, end], [..]) = (without_place(a), without_place(b));
        (&a[..start], &a[end..]).cmp(&(&b[..start], &b[end..])).then_with(|| a.cmp(b))
    }

    /// A number that looks random and depends on all of a record but its place.
    fn hash(&self, record: &[u8]) -> u64 {
        let mix = |hash: u64, word: u64| {
            let mixed = (hash ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            (mixed ^ mixed >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93)
        };
        let parts = [&record[..self.place.start], &record[self.place.end..]];
        parts.into_iter().flat_map(|part| part.chunks(8)).fold(0x5bd1_e995, |hash, chunk| {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            let hash = mix(hash, u64::from_le_bytes(word));
            hash ^ hash >> 29
        })
    }

    /// Returns a node above its children, all there are, along the Morton curve; and the children as they are written.
    pub fn close(&self, cell: Cell, children: Vec<Open>) -> (Open, Vec<Done>) {
        let total = children.iter().map(|child| child.total).sum();
        if total <= self.node_points as u64 {
            let records = children.into_iter().flat_map(|child| child.records).collect();
            return (Open { cell, total, is_inner: false, records }, Vec::new());
        }
        let picked = self.pick(cell, &children);
        let mut records = Vec::with_capacity(picked.len() * self.stride);
        let mut picks = picked.into_iter().peekable();
        let mut done = Vec::new();
        let mut index = 0;
        for child in children {
            let mut kept = Vec::with_capacity(child.records.len());
            for record in child.records.chunks_exact(self.stride) {
                let is_picked = picks.next_if_eq(&index).is_some();
                if is_picked { &mut records } else { &mut kept }.extend_from_slice(record);
                index += 1;
            }
            if child.is_inner || !kept.is_empty() {
                done.push(Done { cell: child.cell, records: kept });
            }
        }
        let is_inner = !done.is_empty();
        (Open { cell, total, is_inner, records }, done)
    }

    /// Returns the points of the children that a node takes, counted through all of them.
    fn pick(&self, cell: Cell, children: &[Open]) -> Vec<u32> {
        let levels = self.grid_bits.min(self.cube.levels() - cell.level);
        let records = || children.iter().flat_map(|child| child.records.chunks_exact(self.stride));
        let code = |record: &[u8]| self.cube.code(self.steps(record), cell.level, levels);
        let rated: Vec<(u64, u64)> = records().map(|record| (code(record), self.hash(record))).collect();
        let parts =
            |up: u32| 1 + rated.windows(2).filter(|pair| pair[0].0 >> (3 * up) != pair[1].0 >> (3 * up)).count();
        let up = (0..levels).find(|up| parts(*up) <= self.node_points).unwrap_or(levels);
        let mut picked: Vec<u32> = Vec::new();
        let mut best: Option<(u64, u64, &[u8])> = None;
        for (index, (record, (code, hash))) in records().zip(&rated).enumerate() {
            let part = code >> (3 * up);
            match best {
                Some((same, least, _)) if same == part && *hash > least => continue,
                Some((same, least, other))
                    if same == part && *hash == least && self.by_content(record, other).is_ge() =>
                {
                    continue;
                }
                Some((same, ..)) if same == part => {
                    picked.pop();
                }
                _ => {}
            }
            picked.push(index as u32);
            best = Some((part, *hash, record));
        }
        picked
    }
}

/// The growth of the nodes of one cell.
struct Growth<'a> {
    rules: &'a Rules,
    records: &'a [u8],
    /// The level of the cell.
    top: u32,
    /// Levels of the codes.
    levels: u32,
}

impl Growth<'_> {
    /// The digit of a point below a level.
    fn digit(&self, key: &Key, level: u32) -> u32 {
        let down = level - self.top;
        if down < self.levels {
            return (key.0 >> (3 * (self.levels - 1 - down)) & 7) as u32;
        }
        let record = &self.records[key.1 as usize * self.rules.stride..];
        self.rules.cube.code(self.rules.steps(record), level, 1) as u32
    }

    fn cell(&self, cell: Cell, keys: &[Key]) -> (Open, Vec<Done>) {
        let stride = self.rules.stride;
        if keys.len() <= self.rules.node_points || cell.level == self.rules.cube.levels() {
            let mut records = Vec::with_capacity(keys.len() * stride);
            keys.iter().for_each(|key| records.extend_from_slice(&self.records[key.1 as usize * stride..][..stride]));
            return (Open { cell, total: keys.len() as u64, is_inner: false, records }, Vec::new());
        }
        let mut rest = keys;
        let mut parts = Vec::new();
        for digit in 0..8 {
            let (part, others) = rest.split_at(rest.partition_point(|key| self.digit(key, cell.level) <= digit));
            if !part.is_empty() {
                parts.push((cell.child(digit), part));
            }
            rest = others;
        }
        let grow = |(cell, keys)| self.cell(cell, keys);
        let grown: Vec<(Open, Vec<Done>)> = if keys.len() > ALONE {
            parts.into_par_iter().map(grow).collect()
        } else {
            parts.into_iter().map(grow).collect()
        };
        let (children, below): (Vec<Open>, Vec<Vec<Done>>) = grown.into_iter().unzip();
        let (open, done) = self.rules.close(cell, children);
        let mut all: Vec<Done> = below.into_iter().flatten().collect();
        all.extend(done);
        (open, all)
    }
}
