//! Puts an octree together from cells that come along the Morton curve.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::octree::about::About;
use super::super::octree::attributes::{AttributeLayout, Role};
use super::super::octree::metadata::{self, Metadata};
use super::super::octree::nodes::{self, NODES, NodeExtent};
use super::super::octree::survey::{self, SURVEY, Surveyor};
use super::super::octree::{HIERARCHY, POINTS};
use super::checkpoint::{self, Checkpoint, Kept};
use super::cube::{Cell, Cube};
use super::feeder::remove;
use super::hierarchy::{self, Written};
use super::ranges::Ranges;
use super::sink::Sink;
use super::tree::{Done, Open, Rules};
use crate::Error;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::facts::Facts;
use pellucid_core::parallel;

/// The file of the points that stand for all, while there are more to come.
const SAMPLE: &str = "sample";

/// Points of a node by default.
pub const NODE_POINTS: usize = 20_000;

/// An octree in the making: a folder with files that are not yet a store. Memory holds the nodes that are open, at most
/// seven of a level, and 64 bytes for each node that is written.
#[derive(Debug)]
pub struct Assembler {
    folder: PathBuf,
    layout: AttributeLayout,
    rules: Rules,
    points: Sink,
    written: Vec<Written>,
    /// Nodes whose parents are not complete, along the Morton curve.
    open: Vec<Open>,
    ranges: Ranges,
    surveyor: Surveyor,
    facts: Facts,
    /// The records of the points that stand for all.
    sample: Sink,
    total: u64,
    /// Nodes that a checkpoint has, and their file.
    kept: Kept,
}

/// Statements of a store about its points as a whole.
#[derive(Debug, Clone, Copy)]
pub struct Told<'a> {
    /// A name for people.
    pub name: &'a str,
    /// A cloud without points, but with all that they have in common.
    pub like: &'a Cloud,
    /// The largest distance of a position from where it was in the source, in the file's units.
    pub rounding: f64,
}

impl Assembler {
    /// Begins an octree of so many points in a folder that is there; files of its own are replaced.
    ///
    /// # Errors
    /// A file can't be written.
    pub fn new(
        folder: &Path,
        layout: AttributeLayout,
        cube: Cube,
        node_points: usize,
        points: u64,
    ) -> Result<Self, Error> {
        Self::resume(folder, layout, cube, node_points, points, None)
    }

    /// Goes on after a checkpoint in the same folder, with the same layout, cube and numbers of points.
    ///
    /// # Errors
    /// A file can't be read or written, or isn't what the checkpoint says.
    pub(super) fn resume(
        folder: &Path,
        layout: AttributeLayout,
        cube: Cube,
        node_points: usize,
        points: u64,
        checkpoint: Option<&Checkpoint>,
    ) -> Result<Self, Error> {
        let none = Checkpoint::default();
        let checkpoint = checkpoint.unwrap_or(&none);
        let surveyor = Surveyor::new(layout.clone(), cube.grid, points);
        let points = Sink::keep(&folder.join(POINTS), checkpoint.bytes)?;
        let sample = Sink::keep(&folder.join(SAMPLE), checkpoint.sample)?;
        let (kept, written) = Kept::resume(folder, checkpoint)?;
        let open = checkpoint::read_open(folder, checkpoint)?;
        let rules = Rules::new(&layout, cube, node_points.max(1));
        let mut ranges = Ranges::new(&layout);
        ranges.0.iter_mut().zip(&checkpoint.ranges).for_each(|(range, bits)| *range = bits.map(f64::from_bits));
        let (folder, total, facts) = (folder.to_path_buf(), checkpoint.total, checkpoint.facts.clone());
        Ok(Self { folder, layout, rules, points, written, open, ranges, surveyor, facts, sample, total, kept })
    }

    /// Returns the number of points so far.
    pub fn points(&self) -> u64 {
        self.total
    }

    /// Writes down what is needed to go on from here, should this process end.
    ///
    /// # Errors
    /// A file can't be written.
    pub(super) fn checkpoint(&mut self) -> Result<Checkpoint, Error> {
        let nodes = self.kept.add(&self.written)?;
        let open = self.kept.write_open(&self.folder, &self.open)?;
        let ranges = self.ranges.0.iter().map(|range| range.map(f64::to_bits)).collect();
        let (bytes, sample, facts) = (self.points.len(), self.sample.len(), self.facts.clone());
        Ok(Checkpoint { bytes, nodes, open, ranges, facts, sample, total: self.total })
    }

    /// Adds all points of a cell, as [`encode`](super::encode) gives them, in any order: fewer than 2³².
    ///
    /// # Errors
    /// A file can't be written.
    ///
    /// # Panics
    /// The cell isn't behind those that came before along the Morton curve, or deeper than the cube has levels.
    pub fn add(&mut self, cell: Cell, records: &[u8]) -> Result<(), Error> {
        if records.is_empty() {
            return Ok(());
        }
        let is_behind = |last: &Open| {
            last.cell.morton_order() < cell.morton_order() && !last.cell.holds(cell) && !cell.holds(last.cell)
        };
        assert!(self.open.last().is_none_or(is_behind), "cells come along the Morton curve");
        self.total += (records.len() / self.rules.stride) as u64;
        while self.open.last().is_some_and(|last| !last.cell.parent().holds(cell)) {
            self.close_last()?;
        }
        let (open, done) = self.rules.grow(cell, records);
        self.open.push(open);
        self.write(done)
    }

    /// Completes the parent of the last open node.
    fn close_last(&mut self) -> Result<(), Error> {
        let Some(last) = self.open.last() else { return Ok(()) };
        let parent = last.cell.parent();
        let first = self.open.iter().rposition(|open| open.cell.parent() != parent || open.cell.level == 0);
        let children = self.open.split_off(first.map_or(0, |before| before + 1));
        let (open, done) = self.rules.close(parent, children);
        self.open.push(open);
        self.write(done)
    }

    /// Writes nodes in their order.
    fn write(&mut self, done: Vec<Done>) -> Result<(), Error> {
        let records = |i: usize| &done[i].records;
        let look = |i: usize| (Ranges::of(&self.layout, records(i)), self.surveyor.look(records(i)));
        let seen = parallel::gather(done.len(), look);
        for (node, ((ranges, extent), (facts, sample))) in done.into_iter().zip(seen) {
            let offset = self.points.len();
            self.points.write(&node.records)?;
            self.ranges.add(&ranges);
            self.facts = std::mem::take(&mut self.facts).and(&facts);
            if self.sample.len() <= self.surveyor.most_bytes() {
                self.sample.write(&sample)?;
            }
            let points = (node.records.len() / self.rules.stride) as u32;
            let extent = extent.map(|extent| NodeExtent { offset, ..extent });
            self.written.push(Written { cell: node.cell, offset, bytes: node.records.len() as u64, points, extent });
        }
        Ok(())
    }

    /// Writes what is left. The folder then has all files of a store; returns the text of metadata.json, which is to be
    /// written when the others are in their place.
    ///
    /// # Errors
    /// A file can't be written; there are no points.
    pub fn finish(mut self, told: &Told) -> Result<String, Error> {
        while self.open.last().is_some_and(|last| last.cell.level > 0) {
            self.close_last()?;
        }
        let Some(root) = self.open.pop() else {
            return Err(Error::NoPoints { path: self.folder.clone(), non_finite: told.like.non_finite });
        };
        self.write(vec![Done { cell: root.cell, records: root.records }])?;
        self.points.sync()?;
        self.write_survey()?;
        self.kept.remove(&self.folder);
        let extents: Vec<NodeExtent> = self.written.iter().filter_map(|node| node.extent).collect();
        Sink::put(&self.folder.join(NODES), &[&nodes::write(&extents)])?;
        let hierarchy = hierarchy::write(&mut self.written);
        Sink::put(&self.folder.join(HIERARCHY), &[&hierarchy.bytes])?;
        let metadata = self.metadata(told, &hierarchy);
        let text = serde_json::to_string_pretty(&metadata);
        text.map_err(|error| Error::Write { path: self.folder.join(metadata::METADATA), source: error.into() })
    }

    /// Writes what follows from all points.
    fn write_survey(&mut self) -> Result<(), Error> {
        let (path, sample) = (self.folder.join(SURVEY), self.folder.join(SAMPLE));
        if self.sample.len() <= self.surveyor.most_bytes() {
            let head = survey::head(&self.facts);
            let head = head.map_err(|error| Error::Write { path: path.clone(), source: error.into() })?;
            let sample = fs::read(&sample).map_err(|source| Error::Read { path: sample.clone(), source })?;
            Sink::put(&path, &[&head, &sample])?;
        }
        remove(&sample)
    }

    fn metadata(&self, told: &Told, hierarchy: &hierarchy::Bytes) -> Metadata {
        let bounds = self.rules.cube.bounds(Cell::ROOT);
        let about = About::new(told.like, &self.layout, told.rounding);
        let grid = self.rules.cube.grid;
        let described = self.layout.attributes.iter().zip(self.ranges.by_attribute(&self.layout));
        let position = |ranges: &[[f64; 2]]| -> Vec<[f64; 2]> {
            let ends = [0, 1].map(|end| grid.position([0, 1, 2].map(|axis| ranges[axis][end] as i32)));
            (0..3).map(|axis| [ends[0][axis], ends[1][axis]]).collect()
        };
        let attributes = described.map(|(attribute, ranges)| match attribute.role {
            Role::Position => metadata::describe(attribute, &position(ranges)),
            _ => metadata::describe(attribute, ranges),
        });
        Metadata {
            version: "2.0".to_owned(),
            name: told.name.to_owned(),
            description: String::new(),
            points: self.total,
            projection: String::new(),
            hierarchy: metadata::Hierarchy {
                first_chunk_size: hierarchy.first_chunk,
                step_size: hierarchy::STEP.into(),
                depth: hierarchy.depth.into(),
            },
            offset: grid.offset.to_array(),
            scale: grid.scale.to_array(),
            spacing: (bounds.max - bounds.min).max_element() * (-f64::from(self.rules.grid_bits)).exp2(),
            bounding_box: metadata::Corners { min: bounds.min.to_array(), max: bounds.max.to_array() },
            encoding: "DEFAULT".to_owned(),
            attributes: attributes.collect(),
            pellucid: serde_json::to_value(about).ok(),
        }
    }
}
