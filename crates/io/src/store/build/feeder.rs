//! The third pass: chunks to an assembler.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use super::super::octree::integers;
use super::assembler::Assembler;
use super::cube::{Cell, Cube};
use super::plan::ChunkPlan;
use super::scatter::{self, Scatter};
use super::survey::{Counts, Memory};
use crate::Error;

/// Bytes of a file that are read at once.
const BLOCK_BYTES: usize = 4 << 20;

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::Write { path: path.to_path_buf(), source }),
        _ => Ok(()),
    }
}

/// Hands chunks to an assembler.
pub(super) struct Feeder<'a> {
    pub assembler: &'a mut Assembler,
    pub cube: Cube,
    pub stride: usize,
    pub memory: Memory,
}

impl Feeder<'_> {
    /// Adds the points of a chunk's file. One with too many is divided once more, unless all are in one place.
    pub fn chunk(&mut self, plan: &ChunkPlan, index: usize, stem: &Path) -> Result<(), Error> {
        let chunk = &plan.chunks[index];
        let path = scatter::file_of(stem, index);
        scatter::check(&path, chunk.points, self.stride)?;
        match chunk.cells.as_slice() {
            [(cell, _)] if chunk.points > self.memory.chunk_points && cell.level < self.cube.levels() => {
                self.divide(*cell, &path)
            }
            cells => {
                let records = fs::read(&path).map_err(|source| Error::Read { path, source })?;
                let cells: Vec<Cell> = cells.iter().map(|(cell, _)| *cell).collect();
                let parts = scatter::by_cell(plan.base, &cells, &self.cube, self.stride, records);
                cells.iter().zip(parts).try_for_each(|(cell, records)| self.assembler.add(*cell, &records))
            }
        }
    }

    /// Distributes the points of a file to further files.
    fn divide(&mut self, cell: Cell, path: &Path) -> Result<(), Error> {
        let (cube, stride) = (self.cube, self.stride);
        let block_bytes = (BLOCK_BYTES / stride).max(1) * stride;
        let mut counts = Counts::new(&cube, cell.level);
        let levels = counts.levels;
        scatter::each_block(path, block_bytes, |records| {
            let code = |record| cube.code(cube.steps_of(integers(record)), cell.level, levels);
            counts.add(records.chunks_exact(stride).map(code).collect(), levels, self.memory.bytes / 8);
            Ok(())
        })?;
        let plan = ChunkPlan::new(cell, &counts, self.memory.chunk_points);
        let mut scatter = Scatter::new(path, &plan, self.memory.bytes / 8)?;
        scatter::each_block(path, block_bytes, |records| scatter.add(scatter::parts(&plan, &cube, stride, records)))?;
        scatter.finish(stride)?;
        for index in 0..plan.chunks.len() {
            self.chunk(&plan, index, path)?;
            remove(&scatter::file_of(path, index))?;
        }
        Ok(())
    }
}
