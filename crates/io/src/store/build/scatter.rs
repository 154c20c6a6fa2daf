//! The second pass: records to files by chunk.

use std::fs::{self, File, OpenOptions};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::super::octree::integers;
use super::cube::{Cell, Cube};
use super::plan::ChunkPlan;
use crate::Error;
use pellucid_core::morton::spread;
use pellucid_core::parallel;
use pellucid_fault as fault;

/// The files of the chunks of a plan.
#[derive(Debug)]
pub(super) struct Scatter<'a> {
    plan: &'a ChunkPlan,
    /// Files are named after it.
    stem: PathBuf,
    waiting: Vec<Vec<u8>>,
    bytes: u64,
    most_bytes: u64,
}

/// Records by chunk.
pub(super) type Parts = Vec<(usize, Vec<u8>)>;

/// Returns the file of a chunk.
pub(super) fn file_of(stem: &Path, chunk: usize) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(format!(".{chunk}"));
    name.into()
}

/// Records by chunk.
pub(super) fn parts(plan: &ChunkPlan, cube: &Cube, stride: usize, records: &[u8]) -> Parts {
    let mut parts: Vec<Vec<u8>> = vec![Vec::new(); plan.chunks.len()];
    for record in records.chunks_exact(stride) {
        parts[plan.chunk_of(cube, cube.steps_of(integers(record)))].extend_from_slice(record);
    }
    parts.into_iter().enumerate().filter(|(_, part)| !part.is_empty()).collect()
}

impl<'a> Scatter<'a> {
    /// Begins empty files. So many bytes wait in memory at most.
    pub fn new(stem: &Path, plan: &'a ChunkPlan, most_bytes: u64) -> Result<Self, Error> {
        for chunk in 0..plan.chunks.len() {
            let path = file_of(stem, chunk);
            fault::file("output/create")
                .and_then(|()| File::create(&path))
                .map_err(|source| Error::Write { path, source })?;
        }
        let waiting = vec![Vec::new(); plan.chunks.len()];
        Ok(Self { plan, stem: stem.to_path_buf(), waiting, bytes: 0, most_bytes })
    }

    /// Adds records.
    pub fn add(&mut self, parts: Parts) -> Result<(), Error> {
        for (chunk, records) in parts {
            self.bytes += records.len() as u64;
            self.waiting[chunk].extend(records);
        }
        if self.bytes > self.most_bytes { self.flush() } else { Ok(()) }
    }

    /// Writes what waits. Files are open one at a time, since there may be more than a process may have open.
    pub fn flush(&mut self) -> Result<(), Error> {
        for (chunk, waiting) in self.waiting.iter_mut().enumerate().filter(|(_, waiting)| !waiting.is_empty()) {
            let path = file_of(&self.stem, chunk);
            append(&path, waiting).map_err(|source| Error::Write { path, source })?;
            *waiting = Vec::new();
        }
        self.bytes = 0;
        Ok(())
    }

    /// Writes the rest, and compares the files with the plan.
    pub fn finish(mut self, stride: usize) -> Result<(), Error> {
        self.flush()?;
        let mut chunks = self.plan.chunks.iter().enumerate();
        chunks.try_for_each(|(chunk, planned)| check(&file_of(&self.stem, chunk), planned.points, stride))
    }
}

/// Compares the size of a chunk's file with its points.
pub(super) fn check(path: &Path, points: u64, stride: usize) -> Result<(), Error> {
    let bytes = fs::metadata(path).map_err(|source| Error::Read { path: path.to_path_buf(), source })?.len();
    if points.checked_mul(stride as u64) == Some(bytes) {
        return Ok(());
    }
    let what = format!("{bytes} bytes for {points} points; an input changed while it was read, or this file after it");
    Err(Error::Truncated { path: path.to_path_buf(), what })
}

fn append(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    fault::write_all(&mut OpenOptions::new().append(true).open(path)?, bytes)
}

/// Reads a file of records a block at a time.
pub(super) fn each_block(
    path: &Path,
    block_bytes: usize,
    mut see: impl FnMut(&[u8]) -> Result<(), Error>,
) -> Result<(), Error> {
    let failed = |source| Error::Read { path: path.to_path_buf(), source };
    let mut file = File::open(path).map_err(failed)?;
    let mut block = Vec::with_capacity(block_bytes);
    while file.by_ref().take(block_bytes as u64).read_to_end(&mut block).map_err(failed)? > 0 {
        see(&block)?;
        block.clear();
    }
    Ok(())
}

/// Records by cells of a chunk below `base`, along the Morton curve.
pub(super) fn by_cell(base: Cell, cells: &[Cell], cube: &Cube, stride: usize, records: Vec<u8>) -> Vec<Vec<u8>> {
    if cells.len() == 1 {
        return vec![records];
    }
    let levels = cells.iter().map(|cell| cell.level - base.level).max().unwrap_or(0);
    let first = |cell: &Cell| {
        let down = cell.level - base.level;
        let [x, y, z] = cell.at.map(|at| spread(u64::from(at) & ((1 << down) - 1)));
        (x | y << 1 | z << 2) << (3 * (levels - down))
    };
    let starts: Vec<u64> = cells.iter().map(first).collect();
    let cell_of = |record: &[u8]| {
        let code = cube.code(cube.steps_of(integers(record)), base.level, levels);
        starts.partition_point(|start| *start <= code).saturating_sub(1) as u32
    };
    let places = parallel::map(records.len() / stride, |i| cell_of(&records[i * stride..][..stride]));
    let mut parts = vec![Vec::new(); cells.len()];
    for (record, place) in records.chunks_exact(stride).zip(places) {
        parts[place as usize].extend_from_slice(record);
    }
    parts
}
