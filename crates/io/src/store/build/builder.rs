//! Clouds of any size as a store: three passes, of which each can be taken up again.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::super::{Grid, Piece, Store};
use super::assembler::{Assembler, NODE_POINTS, Told};
use super::cube::{Cell, Cube};
use super::encode::encode;
use super::feeder::{Feeder, remove};
use super::input::Input;
use super::plan::ChunkPlan;
use super::scatter::{self, Scatter};
use super::state::{self, Assembled, Scattered, State};
use super::survey::{BuildSurvey, Counts, Memory, survey};
use super::target;
use super::types::Types;
use crate::Error;
use crate::store::octree::attributes::AttributeLayout;
use pellucid_core::cloud::Bounds;
use pellucid_core::progress::Progress;

/// Share of the smallest radius that a position may move by.
const FINE: f64 = 1e-3;

/// Settings of building a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Points of a node at most; more only if they are all in one place. At least 1.
    pub node_points: usize,
    /// Memory budget in bytes, in addition to one input node. A smaller budget only creates more temporary files; the
    /// store is the same.
    pub host_memory: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { node_points: NODE_POINTS, host_memory: 2 << 30 }
    }
}

/// Result of building a store.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Built {
    /// Points of the store.
    pub points: u64,
    /// The largest distance of a position from where it was in its input, in the file's units.
    pub rounding: f64,
    /// Notes on what could not be kept, one sentence each.
    pub notes: Vec<String>,
}

/// Writes some clouds as one octree of Potree 2.0 in a folder, which is made; an octree that is there is replaced.
///
/// The bytes depend on the points, their places in the inputs, and the points of a node, not on memory, threads or the
/// order in which nodes are read. Positions stay on the grid of the inputs if they share one, else they are put on one
/// of powers of two, as fine as 30 bits allow; Gaussians have exact ones in addition. Until it is done everything is in
/// a folder beside, `.NAME.pellucid-unfinished`; if the work ends early, the same call goes on after the last pass or
/// chunk that was done.
///
/// # Errors
/// An input can't be read, or has points outside of the box that it announced; some inputs are Gaussians and others are
/// not; the folder holds something else, or can't be written; `progress` was cancelled; there are no points.
pub fn build(
    inputs: &[Box<dyn Store>],
    folder: &Path,
    settings: &Settings,
    progress: &Progress,
) -> Result<Built, Error> {
    let none = || Error::NoPoints { path: folder.to_path_buf(), non_finite: 0 };
    check_kind(inputs)?;
    let input = Input::new(inputs).ok_or_else(none)?;
    // Records in files by chunk and in nodes.
    let stride = Types::default().layout(&input.like, input.points).stride as u64;
    let bytes = input.points.saturating_mul(2 * stride);
    let Bounds { min, max } = input.bounds;
    let cause = || format!("no grid of 32-bit integers covers the box from {min} to {max}");
    let too_large = || Error::malformed(folder, "bounds", cause());
    target::make(folder, &state::key(inputs, settings), bytes, |work, state| {
        let grid = input.shared_grid().or_else(|| Grid::around(&input.bounds)).ok_or_else(too_large)?;
        let cube = Cube::around(grid, &input.bounds).ok_or_else(too_large)?;
        let notes = input.notes.clone();
        Build { input: &input, work, target: folder, settings, progress, cube, state, notes }.run()
    })
}

/// Refuses Gaussians together with points that are none: a store has the same columns for all, and radii mean nothing
/// to Gaussians.
fn check_kind(inputs: &[Box<dyn Store>]) -> Result<(), Error> {
    let find = |are_splats: bool| {
        let summaries = inputs.iter().map(|input| input.summary());
        summaries.into_iter().find(|summary| summary.like.gaussians.is_some() == are_splats)
    };
    match (find(true), find(false)) {
        (Some(splats), Some(points)) => Err(Error::Mixed { splats: splats.path.clone(), points: points.path.clone() }),
        _ => Ok(()),
    }
}

/// A build.
struct Build<'a> {
    input: &'a Input<'a>,
    work: &'a Path,
    target: &'a Path,
    settings: &'a Settings,
    progress: &'a Progress,
    cube: Cube,
    state: State,
    notes: Vec<String>,
}

impl Build<'_> {
    fn run(mut self) -> Result<Built, Error> {
        let survey = self.survey()?;
        let layout = survey.types.layout(&self.input.like, self.input.points);
        let memory = Memory::new(self.settings.host_memory, layout.stride);
        let (assembler, rounding) = if self.input.points <= memory.chunk_points {
            self.in_memory(&layout, memory)?
        } else {
            self.through_files(&layout, memory, survey.counts.clone())?
        };
        let like = &self.input.like;
        let metadata = assembler.finish(&Told { name: &target::name(self.target), like, rounding })?;
        target::publish(self.work, self.target, &metadata)?;
        let coarse = survey.least_radius.map(f64::from).filter(|radius| rounding > FINE * radius);
        if let Some(radius) = coarse {
            let note = format!(
                "positions moved by up to {rounding:.3e}, more than a thousandth of the smallest radius ({radius:.3e}): the grid of \
                 32-bit integers is no finer"
            );
            self.notes.push(note);
        }
        Ok(Built { points: self.input.points, rounding, notes: self.notes })
    }

    /// The first pass.
    fn survey(&mut self) -> Result<BuildSurvey, Error> {
        if let Some(survey) = &self.state.survey {
            return Ok(survey.clone());
        }
        self.progress.set_message("looking at the points");
        // The record isn't known yet; columns take about as much.
        let stride = Types::default().layout(&self.input.like, self.input.points).stride;
        let memory = Memory::new(self.settings.host_memory, stride.max(64));
        let survey = survey(self.input, &self.cube, memory, self.progress)?;
        self.state.survey = Some(survey.clone());
        self.state.save(self.work)?;
        Ok(survey)
    }

    /// Everything at once.
    fn in_memory(&self, layout: &AttributeLayout, memory: Memory) -> Result<(Assembler, f64), Error> {
        self.progress.set_message("reading");
        let (node_points, points) = (self.settings.node_points, self.input.points);
        let mut assembler = Assembler::new(self.work, layout.clone(), self.cube, node_points, points)?;
        let mut records = Vec::new();
        let mut rounding = 0.0_f64;
        self.input.each(memory.batch_points, self.progress, self.encode(layout), |(encoded, moved)| {
            records.extend(encoded);
            rounding = rounding.max(moved);
            Ok(())
        })?;
        self.progress.set_message("writing nodes");
        assembler.add(Cell::ROOT, &records)?;
        Ok((assembler, rounding))
    }

    /// The records of a piece, and the largest distance by which a position moved.
    fn encode(&self, layout: &AttributeLayout) -> impl Fn(Piece) -> Result<(Vec<u8>, f64), DVec3> + Sync {
        let (layout, cube) = (layout.clone(), self.cube);
        move |Piece { cloud, places }| {
            let encoded = encode(&layout, &cube, &cloud, &places)?;
            Ok((encoded.records, encoded.rounding))
        }
    }

    /// The second pass and the third one.
    fn through_files(
        &mut self,
        layout: &AttributeLayout,
        memory: Memory,
        counts: Counts,
    ) -> Result<(Assembler, f64), Error> {
        let stem = self.work.join("chunk");
        if self.state.scattered.is_none() {
            let plan = ChunkPlan::new(Cell::ROOT, &counts, memory.chunk_points);
            let rounding = self.scatter(&stem, &plan, layout, memory)?;
            self.state.scattered = Some(Scattered { plan, rounding });
            // They are in the plan, and this is written after every chunk.
            self.state.survey.iter_mut().for_each(|survey| survey.counts = Counts::default());
            self.state.save(self.work)?;
        }
        let Some(Scattered { plan, rounding }) = self.state.scattered.clone() else {
            return Err(self.input.cancelled());
        };
        let before = self.state.assembled.take();
        let checkpoint = before.as_ref().map(|before| &before.checkpoint);
        let (node_points, points) = (self.settings.node_points, self.input.points);
        let mut assembler = Assembler::resume(self.work, layout.clone(), self.cube, node_points, points, checkpoint)?;
        let done = before.map_or(0, |before| before.chunks);
        self.progress.set_message("writing nodes");
        self.progress.set_length(self.input.points);
        self.progress.set_position(plan.chunks.iter().take(done).map(|chunk| chunk.points).sum());
        let mut feeder = Feeder { assembler: &mut assembler, cube: self.cube, stride: layout.stride, memory };
        for (index, chunk) in plan.chunks.iter().enumerate().skip(done) {
            self.progress.check().map_err(|_| self.input.cancelled())?;
            feeder.chunk(&plan, index, &stem)?;
            let checkpoint = feeder.assembler.checkpoint()?;
            self.state.assembled = Some(Assembled { chunks: index + 1, checkpoint });
            self.state.save(self.work)?;
            remove(&scatter::file_of(&stem, index))?;
            self.progress.inc(chunk.points);
        }
        Ok((assembler, rounding))
    }

    /// Distributes all points to files.
    fn scatter(&self, stem: &Path, plan: &ChunkPlan, layout: &AttributeLayout, memory: Memory) -> Result<f64, Error> {
        self.progress.set_message("dividing the points");
        let mut scatter = Scatter::new(stem, plan, memory.bytes / 8)?;
        let mut rounding = 0.0_f64;
        let (encode, cube, stride) = (self.encode(layout), self.cube, layout.stride);
        let see = |piece: Piece| {
            let (records, moved) = encode(piece)?;
            Ok((scatter::parts(plan, &cube, stride, &records), moved))
        };
        self.input.each(memory.batch_points, self.progress, see, |(parts, moved)| {
            rounding = rounding.max(moved);
            scatter.add(parts)
        })?;
        scatter.finish(stride)?;
        Ok(rounding)
    }
}
