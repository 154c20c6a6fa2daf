//! The first pass: what is known of all points before any of them is written.

use std::collections::HashMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::super::Piece;
use super::cube::{Cell, Cube};
use super::input::Input;
use super::types::Types;
use crate::Error;
use pellucid_core::progress::Progress;

/// Levels of the cells whose points are counted.
const LEVELS: u32 = 8;

/// Bytes of a counted cell.
const BYTES_OF_CELL: u64 = 48;

/// Numbers of points in the cells of a level.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Counts {
    /// Levels below the cell that is divided.
    pub levels: u32,
    /// Number of points of each cell that has any, by the cell's code.
    cells: HashMap<u64, u64>,
}

impl Counts {
    /// Starts to count for the division of a cell of this level.
    pub fn new(cube: &Cube, level: u32) -> Self {
        Self { levels: LEVELS.min(cube.levels() - level), cells: HashMap::new() }
    }

    /// Adds the points of some codes of `levels` levels. Cells become larger where they would take more bytes.
    pub fn add(&mut self, mut codes: Vec<u64>, levels: u32, most_bytes: u64) {
        codes.sort_unstable();
        for cell in codes.chunk_by(|a, b| a == b) {
            *self.cells.entry(cell[0] >> (3 * (levels - self.levels))).or_default() += cell.len() as u64;
        }
        while self.levels > 1 && self.cells.len() as u64 * BYTES_OF_CELL > most_bytes {
            self.levels -= 1;
            let finer = std::mem::take(&mut self.cells);
            finer.into_iter().for_each(|(code, count)| *self.cells.entry(code >> 3).or_default() += count);
        }
    }

    /// Returns codes and points, along the Morton curve.
    pub fn sorted(&self) -> Vec<(u64, u64)> {
        let mut cells: Vec<(u64, u64)> = self.cells.iter().map(|(code, count)| (*code, *count)).collect();
        cells.sort_unstable();
        cells
    }
}

/// Facts about all points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct BuildSurvey {
    pub types: Types,
    pub counts: Counts,
    /// The smallest radius above 0.
    pub least_radius: Option<f32>,
}

/// Looks at all points once.
pub(super) fn survey(input: &Input, cube: &Cube, memory: Memory, progress: &Progress) -> Result<BuildSurvey, Error> {
    let mut survey =
        BuildSurvey { types: Types::default(), counts: Counts::new(cube, Cell::ROOT.level), least_radius: None };
    let levels = survey.counts.levels;
    let see = |piece: Piece| {
        let code = |position: &DVec3| {
            let steps = cube.grid.nearest(*position).and_then(|nearest| cube.steps(nearest));
            steps.map(|steps| cube.code(steps, 0, levels)).ok_or(*position)
        };
        let codes = piece.cloud.positions.iter().map(code).collect::<Result<Vec<u64>, DVec3>>()?;
        let radii = piece.cloud.radii.iter().flatten().copied().filter(|radius| *radius > 0.0);
        Ok((Types::of(&piece.cloud, &cube.grid), codes, radii.reduce(f32::min)))
    };
    input.each(memory.batch_points, progress, see, |(types, codes, radius)| {
        survey.types = std::mem::take(&mut survey.types).and(&types);
        survey.counts.add(codes, levels, memory.bytes / 8);
        survey.least_radius = [survey.least_radius, radius].into_iter().flatten().reduce(f32::min);
        Ok(())
    })?;
    Ok(survey)
}

/// The memory of a build, in points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Memory {
    /// All of it.
    pub bytes: u64,
    /// Points that are put into nodes at once.
    pub chunk_points: u64,
    /// Points that are read and encoded at once.
    pub batch_points: u64,
}

impl Memory {
    /// Returns what so many bytes are enough for, with records of `stride` bytes.
    pub fn new(bytes: u64, stride: usize) -> Self {
        let stride = stride as u64;
        // Records as they come, in open nodes, and as they are written; code and place.
        let in_tree = 3 * stride + 16;
        // Columns, mostly float64 and float32, and records in two places.
        let in_batch = 64 + 4 * stride;
        Self { bytes, chunk_points: (bytes / 2 / in_tree).max(1), batch_points: (bytes / 4 / in_batch).max(1) }
    }
}
