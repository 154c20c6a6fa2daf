//! Morton codes of positions.

use std::cmp::Ordering;

use glam::DVec3;

use super::keyed::{self, Keyed};
use pellucid_core::cloud::Bounds;
use pellucid_core::morton::{BITS, spread};
use pellucid_core::parallel;

/// Returns the 63-bit Morton code of each position in its bounds.
///
/// The cells are cubes (the longest side of the box is cut into 2²¹), so a flat cloud is ordered as well as a round
/// one. An empty box gives code 0 for all.
pub(super) fn codes(positions: &[DVec3], bounds: &Bounds) -> Vec<u64> {
    let cells = Cells::of(bounds);
    parallel::map_each(positions, |p| cells.code(*p))
}

/// The cells that a box is cut into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cells {
    /// Half of the smallest corner.
    half_min: DVec3,
    half_side: f64,
}

impl Cells {
    /// Returns those of a box.
    pub fn of(bounds: &Bounds) -> Self {
        // Halved before the subtraction: the side of a box of ±1e308 would overflow.
        let half_side = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
        Self { half_min: 0.5 * bounds.min, half_side }
    }

    /// Returns the code of a position in the box.
    #[inline]
    pub fn code(self, p: DVec3) -> u64 {
        // 0 / 0 is NaN, which the conversion to integers turns into 0.
        let cell = (0.5 * p - self.half_min) / self.half_side * f64::from((1u32 << BITS) - 1);
        spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
    }
}

/// Returns the longest side of a cell whose positions have the same code in some bounds.
pub(super) fn cell_side(bounds: &Bounds) -> f64 {
    (bounds.max - bounds.min).max_element() / f64::from((1u32 << BITS) - 1)
}

/// Returns the codes of positions in their bounds in ascending order, each with the index of its position; those of
/// equal codes in the order of `by_content`, and of equal content in that of their indices. Positions whose indices
/// have more than 32 bits are left out: so many fit no device.
pub(super) fn sorted(
    positions: &[DVec3],
    bounds: &Bounds,
    by_content: impl Fn(u32, u32) -> Ordering + Sync,
) -> Vec<Keyed> {
    let cells = Cells::of(bounds);
    keyed::sorted(positions.len() as u32, |i| cells.code(positions[i as usize]), &by_content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_cube_come_in_the_order_of_their_bits() {
        let bounds = Bounds { min: DVec3::splat(-2.0), max: DVec3::splat(6.0) };
        let codes = codes(&bounds.corners(), &bounds);
        assert!(codes.is_sorted(), "{codes:x?}");
        assert_eq!(codes[0], 0);
        assert_eq!(codes[7], (1 << 63) - 1);
    }

    #[test]
    fn no_size_and_huge_size_are_fine() {
        let p = DVec3::new(5e5, 4.5e6, 100.0);
        assert_eq!(codes(&[p, p], &Bounds { min: p, max: p }), [0, 0]);
        let far = DVec3::splat(1.7e308);
        let codes = codes(&[-far, DVec3::ZERO, far], &Bounds { min: -far, max: far });
        assert!(codes[0] < codes[1] && codes[1] < codes[2], "{codes:x?}");
    }
}
