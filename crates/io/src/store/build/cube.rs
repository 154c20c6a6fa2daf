//! The root of an octree on a grid of integers, and its cells.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::super::Grid;
use pellucid_core::cloud::Bounds;
use pellucid_core::morton::{self, spread};

/// Levels whose digits fit a code.
pub(super) const CODE_LEVELS: u32 = morton::BITS;

/// Bits of coordinates along an axis.
const MAX_BITS: u32 = 32;

/// The box of the root: along each axis a power of two of steps of a grid, so that cells end between positions. It is a
/// cube if the steps of all axes are the same, else its sides are within a factor of 2.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Cube {
    /// The grid.
    pub grid: Grid,
    /// The integers of its least corner.
    pub least: [i32; 3],
    /// Binary logarithm of its steps, 1 to 32.
    pub bits: [u32; 3],
}

impl Cube {
    /// Returns the smallest one whose least corner is that of a box; `None` if the grid doesn't span the box.
    pub fn around(grid: Grid, bounds: &Bounds) -> Option<Self> {
        let (least, most) = (grid.nearest(bounds.min)?, grid.nearest(bounds.max)?);
        let steps: [u64; 3] = std::array::from_fn(|axis| u64::from(most[axis].abs_diff(least[axis])).saturating_add(1));
        let scale = grid.scale.to_array();
        let side = (0..3).map(|axis| steps[axis] as f64 * scale[axis]).fold(0.0, f64::max);
        let holds = |axis: usize, bits: u32| 1_u64 << bits >= steps[axis] && (bits as f64).exp2() * scale[axis] >= side;
        let bits = std::array::from_fn(|axis| (1..MAX_BITS).find(|bits| holds(axis, *bits)).unwrap_or(MAX_BITS));
        Some(Self { grid, least, bits })
    }

    /// Returns levels below the root: a cell of the last one holds a single position along at least one axis.
    pub fn levels(&self) -> u32 {
        self.bits.into_iter().min().unwrap_or(0)
    }

    /// Returns the box of a cell.
    pub fn bounds(&self, cell: Cell) -> Bounds {
        let corner = |add: u32| {
            let at = std::array::from_fn(|axis| {
                let side = (f64::from(self.bits[axis]) - f64::from(cell.level)).exp2();
                f64::from(self.least[axis]) + (f64::from(cell.at[axis]) + f64::from(add)) * side
            });
            self.grid.scale * DVec3::from_array(at) + self.grid.offset
        };
        Bounds { min: corner(0), max: corner(1) }
    }

    /// Returns steps from the least corner; `None` outside.
    pub(super) fn steps(&self, at: [i32; 3]) -> Option<[u32; 3]> {
        let steps = self.steps_of(at);
        let is_inside = |axis: usize| at[axis] >= self.least[axis] && u64::from(steps[axis]) < 1 << self.bits[axis];
        (0..3).all(is_inside).then_some(steps)
    }

    /// Returns the same of a position that is inside.
    pub(super) fn steps_of(&self, at: [i32; 3]) -> [u32; 3] {
        std::array::from_fn(|axis| at[axis].wrapping_sub(self.least[axis]) as u32)
    }

    /// Returns the digits of some levels, the first one below a cell of level `from`: a Morton code of 3 bits a level,
    /// x lowest.
    pub(super) fn code(&self, steps: [u32; 3], from: u32, levels: u32) -> u64 {
        let part = |axis: usize| {
            let below = self.bits[axis] - from - levels;
            spread(u64::from(steps[axis]) >> below & ((1 << levels) - 1))
        };
        part(0) | part(1) << 1 | part(2) << 2
    }

    /// Returns the cell of a level that holds a position.
    pub(super) fn cell(&self, steps: [u32; 3], level: u32) -> Cell {
        Cell { level, at: std::array::from_fn(|axis| (u64::from(steps[axis]) >> (self.bits[axis] - level)) as u32) }
    }
}

/// A cell of an octree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Cell {
    /// 0 for the root.
    pub level: u32,
    /// Cells of its level before it, along each axis.
    pub at: [u32; 3],
}

impl Cell {
    /// All there is.
    pub const ROOT: Self = Self { level: 0, at: [0; 3] };

    /// Returns the cell above; that of the root is itself.
    pub fn parent(self) -> Self {
        Self { level: self.level.saturating_sub(1), at: self.at.map(|at| at >> 1) }
    }

    /// Returns one of the eight below: bit 0 of the number is x.
    pub fn child(self, digit: u32) -> Self {
        let at = std::array::from_fn(|axis| self.at[axis] << 1 | digit >> axis & 1);
        Self { level: self.level + 1, at }
    }

    /// Returns its number among those of its parent.
    #[cfg(test)]
    pub(super) fn digit(self) -> u32 {
        (self.at[0] & 1) | (self.at[1] & 1) << 1 | (self.at[2] & 1) << 2
    }

    /// Returns `true` if another cell is this one or below it.
    pub fn holds(self, other: Self) -> bool {
        let up = other.level.checked_sub(self.level);
        up.is_some_and(|up| (0..3).all(|axis| u64::from(other.at[axis]) >> up == u64::from(self.at[axis])))
    }

    /// Returns the cell of a code of some levels below this one.
    pub(super) fn below(self, code: u64, levels: u32) -> Self {
        (0..levels).rev().fold(self, |cell, level| cell.child((code >> (3 * level) & 7) as u32))
    }

    /// Returns the number of Potree's name of it, whose digits have x highest: of one level in the order of names.
    pub(super) fn name_order(self) -> u128 {
        let [x, y, z] = self.at.map(u64::from);
        interleaved([z, y, x], self.level)
    }

    /// Key of the order along the Morton curve, for cells of which neither holds the other.
    pub(super) fn morton_order(self) -> [u128; 2] {
        let aligned = self.at.map(|at| u64::from(at) << (MAX_BITS - self.level));
        [interleaved(aligned, MAX_BITS), u128::from(self.level)]
    }
}

/// The lowest bits of three numbers, so many of each: three bits a level, the first number's lowest.
fn interleaved(at: [u64; 3], bits: u32) -> u128 {
    (0..bits).rev().fold(0, |code, bit| {
        let digit = |axis: usize| u128::from(at[axis] >> bit & 1);
        code << 3 | digit(2) << 2 | digit(1) << 1 | digit(0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_their_positions() {
        let grid = Grid { scale: DVec3::new(0.01, 0.01, 0.001), offset: DVec3::new(5e5, 0.0, -7.0) };
        let bounds = Bounds { min: DVec3::new(5e5, -3.0, 0.0), max: DVec3::new(5e5 + 20.0, 10.0, 1.0) };
        let cube = Cube::around(grid, &bounds).unwrap();
        // 2001 steps of 0.01 need 2¹¹, 20.01 in steps of 0.001 needs 2¹⁵.
        assert_eq!((cube.bits, cube.levels()), ([11, 11, 15], 11));
        for p in bounds.corners() {
            let steps = cube.steps(grid.nearest(p).unwrap()).unwrap();
            for level in 0..=cube.levels() {
                let cell = cube.cell(steps, level);
                let within = cube.bounds(cell);
                assert!((p.cmpge(within.min - 1e-9) & p.cmplt(within.max + 1e-9)).all(), "{p} {cell:?} {within:?}");
                assert_eq!(Cell::ROOT.below(cube.code(steps, 0, level), level), cell);
                assert!(cell.parent().holds(cell) && Cell::ROOT.holds(cell));
                assert!(level == 0 || (!cell.holds(cell.parent()) && cell.parent().child(cell.digit()) == cell));
            }
        }
        assert_eq!(cube.steps([cube.least[0] - 1, cube.least[1], cube.least[2]]), None);
        assert_eq!(cube.steps([cube.least[0] + 2048, cube.least[1], cube.least[2]]), None);
    }

    #[test]
    fn the_whole_range_fits() {
        let grid = Grid { scale: DVec3::ONE, offset: DVec3::ZERO };
        let [min, max] = [[i32::MIN; 3], [i32::MAX; 3]];
        let cube = Cube::around(grid, &Bounds { min: grid.position(min), max: grid.position(max) }).unwrap();
        assert_eq!((cube.bits, cube.steps(max), cube.steps(min)), ([32; 3], Some([u32::MAX; 3]), Some([0; 3])));
        assert_eq!(cube.code([u32::MAX; 3], 11, 21), (1 << 63) - 1);
        let one = Cube::around(grid, &Bounds { min: DVec3::ONE, max: DVec3::ONE }).unwrap();
        assert_eq!(one.bits, [1; 3]);
    }

    #[test]
    fn orders_of_cells() {
        let children: Vec<_> = (0..8).map(|digit| Cell::ROOT.child(digit)).collect();
        assert!(children.is_sorted_by_key(|cell| cell.morton_order()));
        assert_eq!((children[1].at, children[1].name_order(), children[4].name_order()), ([1, 0, 0], 4, 1));
        assert!(children[0].child(7).morton_order() < children[1].morton_order());
    }
}
