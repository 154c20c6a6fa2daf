//! Orders of points along the axes of the world, by which `soft-express` blends (Seemann et al. 2018, Section 3.3).

use glam::DVec3;
use rayon::prelude::*;

use pellucid_core::parallel;

/// The axis along which a view goes.
///
/// The paper keeps six orders, two for each axis. The second is the first read backward, so three do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// 0 for x, 1 for y, 2 for z.
    pub index: usize,
    /// `true` if the view goes toward smaller coordinates.
    pub backward: bool,
}

impl Axis {
    /// Returns the one nearest to a direction; of several the first.
    pub fn nearest(direction: DVec3) -> Self {
        let along = direction.abs().to_array();
        let index = if along[0] >= along[1].max(along[2]) {
            0
        } else if along[1] >= along[2] {
            1
        } else {
            2
        };
        Self { index, backward: direction[index] < 0.0 }
    }
}

/// Returns the indices of all points by one of their coordinates, smallest first, equal ones by index. At most 2³²
/// points.
pub fn order(positions: &[DVec3], axis: usize) -> Vec<u32> {
    let mut order: Vec<(u64, u32)> = parallel::map(positions.len(), |i| (ordered_bits(positions[i][axis]), i as u32));
    order.par_sort_unstable();
    parallel::map_each(&order, |(_, i)| *i)
}

/// Maps numbers to integers of the same order; both zeros to one.
fn ordered_bits(v: f64) -> u64 {
    let bits = (v + 0.0).to_bits();
    if bits >> 63 != 0 { !bits } else { bits | 1 << 63 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_nearest_to_a_direction() {
        let axis = |x, y, z| Axis::nearest(DVec3::new(x, y, z));
        let axis_with = |index, backward| Axis { index, backward };
        assert_eq!([axis(1.0, 0.5, -0.9), axis(-1.0, 0.5, 0.9)], [axis_with(0, false), axis_with(0, true)]);
        assert_eq!([axis(0.5, 1.0, -0.9), axis(0.5, -1.0, 0.9)], [axis_with(1, false), axis_with(1, true)]);
        assert_eq!([axis(0.5, 0.9, 1.0), axis(-0.5, 0.9, -1.0)], [axis_with(2, false), axis_with(2, true)]);
        // Diagonals.
        assert_eq!([axis(-1.0, 1.0, 1.0), axis(0.0, 1.0, -1.0)], [axis_with(0, true), axis_with(1, false)]);
    }

    #[test]
    fn orders_by_hand() {
        let positions = [[1.0, -0.0, 5.0], [-2.0, 0.0, 5.0 + 1e-15], [1e-300, -1.0, -5.0], [1.0, -1.0 - 1e-15, 5.0]]
            .map(DVec3::from);
        assert_eq!(order(&positions, 0), [1, 2, 0, 3]);
        // Both zeros are equal, so that the index decides.
        assert_eq!(order(&positions, 1), [3, 2, 0, 1]);
        assert_eq!(order(&positions, 2), [2, 0, 3, 1]);
        assert!(order(&[], 0).is_empty());
    }
}
