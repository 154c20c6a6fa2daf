//! The integer grid that positions of a store lie on, as those of a LAS file do.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use pellucid_core::cloud::Bounds;

/// Bits of the coordinates of a grid that is made for a cloud: one less than an `i32` has above zero, for what is
/// rounded.
const BITS: i32 = 30;

/// Bits of a float64.
const MANTISSA: i32 = 52;

/// Largest difference of offsets from whole steps of a grid that they share, in steps: texts of offsets have few
/// digits.
const COMMENSURABLE: f64 = 1e-4;

/// Positions scale·i + offset of integers i, axis by axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[[f64; 3]; 2]", into = "[[f64; 3]; 2]")]
pub struct Grid {
    /// The distance of neighbors along each axis, in the file's units; above 0.
    pub scale: DVec3,
    /// The position of the integers 0.
    pub offset: DVec3,
}

impl From<[[f64; 3]; 2]> for Grid {
    fn from([scale, offset]: [[f64; 3]; 2]) -> Self {
        Self { scale: scale.into(), offset: offset.into() }
    }
}

impl From<Grid> for [[f64; 3]; 2] {
    fn from(grid: Grid) -> Self {
        [grid.scale.to_array(), grid.offset.to_array()]
    }
}

impl Grid {
    /// Returns the position of three integers, rounded as that of a LAS point is: product and sum by themselves.
    pub fn position(&self, at: [i32; 3]) -> DVec3 {
        self.scale * DVec3::from(at.map(f64::from)) + self.offset
    }

    /// Returns the integers whose position is nearest; `None` if they have more than 32 bits.
    pub fn nearest(&self, position: DVec3) -> Option<[i32; 3]> {
        let steps = ((position - self.offset) / self.scale).round().to_array();
        let fits = |step: &f64| (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(step);
        steps.iter().all(fits).then(|| steps.map(|step| step as i32))
    }

    /// Returns `true` if scales are above 0, and the positions of all integers finite.
    pub fn is_valid(&self) -> bool {
        let ends = [i32::MIN, i32::MAX].map(|end| self.position([end; 3]));
        self.scale.min_element() > 0.0 && ends.iter().all(|end| end.is_finite())
    }

    /// Returns a grid of steps of a power of two, the finest that 30 bits span; `None` if the box is too large for
    /// float64. Positions that are multiples of a step, as small float32 numbers often are, keep every bit.
    pub fn around(bounds: &Bounds) -> Option<Self> {
        let extent = (bounds.max - bounds.min).max_element();
        let far = bounds.min.abs().max(bounds.max.abs()).max_element();
        if !extent.is_finite() || !far.is_finite() {
            return None;
        }
        // Of 0 the least exponent.
        let above = |value: f64| if value > 0.0 { value.log2().floor() as i32 + 1 } else { -1000 };
        let exponent = (above(extent) - BITS).max(above(far) - MANTISSA).max(-1000);
        let step = f64::from(exponent).exp2();
        Some(Self { scale: DVec3::splat(step), offset: (bounds.min / step).floor() * step })
    }

    /// Returns the first of some grids if all others have its steps and lie on it, and if it spans a box.
    pub fn shared(grids: &[Option<Self>], bounds: &Bounds) -> Option<Self> {
        let first = grids.first().copied().flatten().filter(Self::is_valid)?;
        let lies_on = |grid: &Option<Self>| {
            grid.is_some_and(|grid| {
                let steps = (grid.offset - first.offset) / first.scale;
                grid.scale == first.scale && (steps - steps.round()).abs().max_element() < COMMENSURABLE
            })
        };
        let spans = [bounds.min, bounds.max].into_iter().all(|corner| first.nearest(corner).is_some());
        (spans && grids.iter().all(lies_on)).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_of_a_grid_come_back_to_the_bit() {
        let las = Grid { scale: DVec3::new(0.01, 0.001, 1e-7), offset: DVec3::new(5e5, -4.5e6, 0.1) };
        for at in [[0, 1, -1], [i32::MAX, i32::MIN, 7], [123_456_789, -987_654_321, 2]] {
            assert_eq!(las.nearest(las.position(at)), Some(at));
        }
        assert_eq!(las.nearest(DVec3::new(5e5, -4.5e6, 300.0)), None);
        assert_eq!(las.nearest(DVec3::splat(f64::NAN)), None);
    }

    #[test]
    fn a_grid_of_powers_of_two_keeps_floats() {
        let corners = [DVec3::new(-3.25, 0.0, 100.0), DVec3::new(4.5, 1.0, 100.5)];
        let grid = Grid::around(&Bounds { min: corners[0], max: corners[1] }).unwrap();
        // 2³ is above 7.75.
        assert_eq!(grid.scale, DVec3::splat((-27_f64).exp2()));
        for p in corners.into_iter().chain([DVec3::new(0.1_f32.into(), 0.7_f32.into(), 100.3_f32.into())]) {
            let error = (grid.position(grid.nearest(p).unwrap()) - p).abs().max_element();
            assert!(error <= 0.5 * grid.scale.x, "{error}");
        }
        assert_eq!(grid.position(grid.nearest(corners[0]).unwrap()), corners[0]);
        let one = Bounds { min: corners[0], max: corners[0] };
        let grid = Grid::around(&one).unwrap();
        assert_eq!(grid.position(grid.nearest(corners[0]).unwrap()), corners[0]);
        let zero = Grid::around(&Bounds { min: DVec3::ZERO, max: DVec3::ZERO }).unwrap();
        assert!(zero.is_valid() && zero.nearest(DVec3::ZERO) == Some([0; 3]));
        assert_eq!(Grid::around(&Bounds { min: DVec3::splat(-1e308), max: DVec3::splat(1e308) }), None);
    }

    #[test]
    fn grids_are_shared_if_their_offsets_are_whole_steps_apart() {
        let grid = |offset: f64| Some(Grid { scale: DVec3::splat(0.01), offset: DVec3::splat(offset) });
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::splat(2000.0) };
        assert_eq!(Grid::shared(&[grid(0.0), grid(1000.07)], &bounds), grid(0.0));
        assert_eq!(Grid::shared(&[grid(0.0), grid(1000.075)], &bounds), None);
        assert_eq!(Grid::shared(&[grid(0.0), None], &bounds), None);
        let far = Bounds { max: DVec3::splat(1e9), ..bounds };
        assert_eq!(Grid::shared(&[grid(0.0)], &far), None);
    }
}
