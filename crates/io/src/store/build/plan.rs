//! Choice of the points that are put into nodes together.

use serde::{Deserialize, Serialize};

use super::cube::{Cell, Cube};
use super::survey::Counts;
use pellucid_core::morton::divided;

/// Points that are put into nodes together: those of some cells in a row along the Morton curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Chunk {
    /// The cells and how many points are in each.
    pub cells: Vec<(Cell, u64)>,
    pub points: u64,
}

/// All points of a cell in chunks, along the Morton curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ChunkPlan {
    /// The cell.
    pub base: Cell,
    /// Levels of the codes below it.
    levels: u32,
    pub chunks: Vec<Chunk>,
    /// The least code of each chunk.
    starts: Vec<u64>,
}

impl ChunkPlan {
    /// Returns the largest cells with at most so many points, and as many of them in each chunk as fit. A cell that has
    /// more is a chunk of its own, if it is as small as those that were counted.
    pub fn new(base: Cell, counts: &Counts, most: u64) -> Self {
        let levels = counts.levels;
        let mut plan = Self { base, levels, chunks: Vec::new(), starts: Vec::new() };
        for (level, code, points) in divided(levels, &counts.sorted(), most) {
            let cell = base.below(code >> (3 * (levels - level)), level);
            match plan.chunks.last_mut() {
                Some(chunk) if chunk.points.saturating_add(points) <= most => {
                    chunk.cells.push((cell, points));
                    chunk.points += points;
                }
                _ => {
                    plan.chunks.push(Chunk { cells: vec![(cell, points)], points });
                    plan.starts.push(code);
                }
            }
        }
        plan
    }

    /// Returns the chunk of a point, which is in the cell.
    pub fn chunk_of(&self, cube: &Cube, steps: [u32; 3]) -> usize {
        let code = cube.code(steps, self.base.level, self.levels);
        self.starts.partition_point(|start| *start <= code).saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::super::Grid;
    use super::*;
    use pellucid_core::cloud::Bounds;

    #[test]
    fn chunks_are_cells_in_a_row() {
        let grid = Grid { scale: DVec3::ONE, offset: DVec3::ZERO };
        let cube = Cube::around(grid, &Bounds { min: DVec3::ZERO, max: DVec3::splat(15.0) }).unwrap();
        let mut counts = Counts::new(&cube, 0);
        assert_eq!(counts.levels, 4);
        // 8 points in each part of the first eighth, 3 in the last one, 100 in one place.
        let far = cube.code([9, 0, 0], 0, 4);
        let codes = (0..512).step_by(8).chain([4095; 3]).chain([far; 100]).collect();
        counts.add(codes, 4, u64::MAX);
        let plan = ChunkPlan::new(Cell::ROOT, &counts, 20);
        let shape: Vec<_> = plan.chunks.iter().map(|chunk| (chunk.points, chunk.cells.len())).collect();
        assert_eq!(shape, [(16, 2), (16, 2), (16, 2), (16, 2), (100, 1), (3, 1)]);
        assert_eq!(plan.chunks[4].cells[0].0, cube.cell([9, 0, 0], 4));
        assert_eq!(plan.chunks[5].cells[0].0, cube.cell([15; 3], 1));
        for (steps, chunk) in [([0; 3], 0), ([4, 0, 0], 0), ([0, 4, 0], 1), ([9, 0, 0], 4), ([15; 3], 5)] {
            assert_eq!(plan.chunk_of(&cube, steps), chunk, "{steps:?}");
        }
        let one = ChunkPlan::new(Cell::ROOT, &counts, 1000);
        assert_eq!(one.chunks, [Chunk { cells: vec![(Cell::ROOT, 167)], points: 167 }]);
    }

    #[test]
    fn counts_get_coarser_where_memory_is_short() {
        let grid = Grid { scale: DVec3::ONE, offset: DVec3::ZERO };
        let cube = Cube::around(grid, &Bounds { min: DVec3::ZERO, max: DVec3::splat(255.0) }).unwrap();
        let mut counts = Counts::new(&cube, 0);
        counts.add((0..4096).collect(), 8, 48 * 600);
        assert_eq!((counts.levels, counts.sorted().len()), (7, 512));
        counts.add((0..4096).collect(), 8, 48 * 600);
        assert_eq!(counts.sorted()[1], (1, 16));
    }
}
