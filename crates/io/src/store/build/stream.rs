//! Clouds whose points can be made anew as a store: one region after the other, without files of points in between.

use std::path::Path;

use super::super::octree::integers;
use super::super::{Piece, Store};
use super::assembler::{Assembler, Told};
use super::cube::{Cell, Cube};
use super::encode::encode;
use super::state::{Assembled, State};
use super::survey::Memory;
use super::{AttributeLayout, Built, Settings, target};
use crate::Error;
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// Most points that are put into nodes together: more would take memory, not less time.
const CHUNK_POINTS: u64 = 1 << 22;

/// Chunks after which it is written down how far the work is.
const CHUNKS_OF_CHECKPOINT: usize = 4;

/// A cloud to be written, whose nodes may be read again and again.
#[derive(Debug, Clone, Copy)]
pub struct Streamed<'a> {
    /// The cloud. Its nodes are columns: boxes that are apart seen along one of the axes.
    pub store: &'a dyn Store,
    /// The root of the octree. All positions are on its grid and in it.
    pub cube: Cube,
    /// Values that are kept of a point, in types that hold all of them.
    pub layout: &'a AttributeLayout,
    /// Key of what the points follow from: clouds with the same key are the same.
    pub key: &'a str,
}

/// Writes a cloud as one octree of Potree 2.0 in a folder, which is made; an octree that is there is replaced.
///
/// The bytes depend on the points and the points of a node, not on memory or threads. A node is read as often as memory
/// makes cells of the octree smaller than its box, mostly once. Until it is done everything is in a folder beside,
/// `.NAME.pellucid-unfinished`, and takes no more room than the store; if the work ends early, the same call goes on
/// there.
///
/// # Errors
/// The cloud can't be read, or has points that are not on the grid or not in the boxes of their nodes; the folder holds
/// something else, or can't be written; `progress` was cancelled; there are no points.
pub fn stream(streamed: &Streamed, folder: &Path, settings: &Settings, progress: &Progress) -> Result<Built, Error> {
    let stride = streamed.layout.stride;
    let most = Memory::new(settings.host_memory, stride).chunk_points.min(CHUNK_POINTS);
    let key = format!("{} {} {most} {}", env!("CARGO_PKG_VERSION"), settings.node_points, streamed.key);
    let bytes = streamed.store.summary().points.saturating_mul(stride as u64);
    target::make(folder, &key, bytes, |work, state| {
        let chunks = chunks(streamed, most)?;
        Run { streamed, chunks, work, node_points: settings.node_points, progress }.run(folder, state)
    })
}

/// A cell whose points are put into nodes together, and the nodes of the cloud that meet it.
#[derive(Debug, Clone, PartialEq)]
struct Chunk {
    cell: Cell,
    nodes: Vec<usize>,
}

/// Nodes with points: their number, how many points, and the steps of their corners.
type Boxed = (usize, u64, [[u32; 3]; 2]);

/// The cells, along the Morton curve.
fn chunks(streamed: &Streamed, most: u64) -> Result<Vec<Chunk>, Error> {
    let cube = &streamed.cube;
    let mut nodes: Vec<Boxed> = Vec::new();
    for (number, node) in streamed.store.nodes().iter().enumerate().filter(|(_, node)| node.points > 0) {
        let steps = |corner| cube.grid.nearest(corner).and_then(|at| cube.steps(at));
        let (Some(low), Some(high)) = (steps(node.bounds.min), steps(node.bounds.max)) else {
            let cause = format!("a node from {} to {} lies outside the octree", node.bounds.min, node.bounds.max);
            return Err(malformed(streamed, "bounds", cause));
        };
        nodes.push((number, node.points, [low, high]));
    }
    let mut chunks = Vec::new();
    divide(cube, Cell::ROOT, nodes, most, &mut chunks);
    Ok(chunks)
}

/// Divides a cell until at most so many points are in the nodes that meet it, or there is only one.
fn divide(cube: &Cube, cell: Cell, nodes: Vec<Boxed>, most: u64, chunks: &mut Vec<Chunk>) {
    let points: u64 = nodes.iter().map(|(_, points, _)| points).sum();
    if points <= most || nodes.len() == 1 || cell.level == cube.levels() {
        if points > 0 {
            chunks.push(Chunk { cell, nodes: nodes.into_iter().map(|(number, ..)| number).collect() });
        }
        return;
    }
    for digit in 0..8 {
        let child = cell.child(digit);
        let meets = |(.., [low, high]): &&Boxed| {
            let [low, high] = [low, high].map(|corner| cube.cell(*corner, child.level).at);
            (0..3).all(|axis| (low[axis]..=high[axis]).contains(&child.at[axis]))
        };
        divide(cube, child, nodes.iter().filter(meets).copied().collect(), most, chunks);
    }
}

fn malformed(streamed: &Streamed, place: &str, cause: String) -> Error {
    Error::malformed(&streamed.store.summary().path, place, cause)
}

/// The work.
struct Run<'a> {
    streamed: &'a Streamed<'a>,
    chunks: Vec<Chunk>,
    work: &'a Path,
    node_points: usize,
    progress: &'a Progress,
}

impl Run<'_> {
    fn run(&self, folder: &Path, mut state: State) -> Result<Built, Error> {
        let summary = self.streamed.store.summary();
        let before = state.assembled.take();
        let (cube, layout) = (self.streamed.cube, self.streamed.layout.clone());
        let checkpoint = before.as_ref().map(|before| &before.checkpoint);
        let mut assembler = Assembler::resume(self.work, layout, cube, self.node_points, summary.points, checkpoint)?;
        let first = before.map_or(0, |before| before.chunks);
        self.progress.reset();
        self.progress.set_message("writing nodes");
        self.progress.set_length(summary.points);
        self.progress.set_position(assembler.points());
        let read = |index: usize| self.chunks.get(index).map(|chunk| self.records(chunk)).transpose();
        let mut records = read(first)?;
        for index in first..self.chunks.len() {
            let cancelled = |_| Error::Cancelled { path: summary.path.clone() };
            self.progress.check().map_err(cancelled)?;
            // Those of the next cell are made while these are put into nodes.
            let own = records.take().unwrap_or_default();
            let (next, added) = rayon::join(|| read(index + 1), || assembler.add(self.chunks[index].cell, &own));
            added?;
            records = next?;
            self.progress.set_position(assembler.points());
            let done = index + 1;
            if done % CHUNKS_OF_CHECKPOINT == 0 {
                state.assembled = Some(Assembled { chunks: done, checkpoint: assembler.checkpoint()? });
                state.save(self.work)?;
            }
        }
        if assembler.points() != summary.points {
            let cause =
                format!("{} points were announced, but {} are in the nodes' boxes", summary.points, assembler.points());
            return Err(malformed(self.streamed, "points", cause));
        }
        let metadata = assembler.finish(&Told { name: &target::name(folder), like: &summary.like, rounding: 0.0 })?;
        target::publish(self.work, folder, &metadata)?;
        Ok(Built { points: summary.points, rounding: 0.0, notes: Vec::new() })
    }

    /// The records of the points of a cell, from nodes that are read side by side.
    fn records(&self, chunk: &Chunk) -> Result<Vec<u8>, Error> {
        Ok(parallel::try_map_each(&chunk.nodes, |node| self.part(chunk.cell, *node))?.concat())
    }

    /// The records of the points of a node that are in a cell.
    fn part(&self, cell: Cell, node: usize) -> Result<Vec<u8>, Error> {
        let Streamed { store, cube, layout, .. } = self.streamed;
        let Piece { cloud, places } = store.read(node)?;
        let outside = |cause: String| malformed(self.streamed, &format!("node {node}"), cause);
        let encoded = encode(layout, cube, &cloud, &places)
            .map_err(|position| outside(format!("a point at {position} lies outside the octree")))?;
        if encoded.rounding > 0.0 {
            return Err(outside(format!("a point is {:e} off the grid", encoded.rounding)));
        }
        let is_inside = |record: &&[u8]| cube.cell(cube.steps_of(integers(record)), cell.level) == cell;
        if encoded.records.chunks_exact(layout.stride).all(|record| is_inside(&record)) {
            return Ok(encoded.records);
        }
        Ok(encoded.records.chunks_exact(layout.stride).filter(is_inside).flatten().copied().collect())
    }
}
