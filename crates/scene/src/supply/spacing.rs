//! Distance between the points of a cloud without levels.

use glam::DVec3;
use rayon::prelude::*;

use pellucid_core::cloud::Bounds;
use pellucid_core::morton::{BITS, spread};
use pellucid_core::parallel;

/// Points in a cell on average, at most: few cells of a surface are without any then.
const IN_CELL: usize = 16;

/// Returns the typical distance of points on surfaces, in world units: that of `count` points of which some that stand
/// for all are given, in any order; 0 if they are in one place. The area of the surfaces is that of the cells with
/// points, whose side is the first half of a half and so on of the longest side that leaves them so few points on
/// average.
pub fn spacing(sampled: &[DVec3], count: u64) -> f64 {
    let Some(bounds) = Bounds::of(sampled) else { return 0.0 };
    let half_side = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
    if !(half_side > 0.0 && half_side.is_finite()) {
        return 0.0;
    }
    let code = |position: &DVec3| {
        let cell = (0.5 * *position - 0.5 * bounds.min) / half_side * f64::from(1u32 << BITS);
        // The last cell holds its far end.
        let [x, y, z] = cell.to_array().map(|x| spread((x as u64).min((1 << BITS) - 1)));
        x | y << 1 | z << 2
    };
    let mut codes = parallel::map_each(sampled, code);
    codes.par_sort_unstable();
    let cells_at = |level: u32| {
        let shift = 3 * (BITS - level);
        1 + codes.par_windows(2).filter(|pair| pair[0] >> shift != pair[1] >> shift).count()
    };
    let (mut level, mut cells) = (1, cells_at(1));
    while level < BITS && sampled.len() > IN_CELL * cells {
        level += 1;
        cells = cells_at(level);
    }
    let side = half_side * (1.0 - f64::from(level)).exp2();
    side * (cells as f64 / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_plane_are_as_far_apart_as_its_grid_has_them() {
        let grid = |side: usize, step: f64| -> Vec<DVec3> {
            (0..side * side).map(|i| step * DVec3::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5, 7.0)).collect()
        };
        // 256² points fill 64² cells of 16 points but for half a step at the border, by which the cells are smaller.
        let points = grid(256, 0.25);
        let expected = 0.25 * 255.0 / 256.0;
        assert!((spacing(&points, 1 << 16) - expected).abs() < 1e-9, "{}", spacing(&points, 1 << 16));
        // Four times as many in the same place are half as far apart.
        assert!((spacing(&points, 1 << 18) - 0.5 * expected).abs() < 1e-9);
        // A point far off takes a cell of its own.
        let mut with_stray = points.clone();
        with_stray.push(DVec3::splat(100.0));
        let found = spacing(&with_stray, 1 << 16);
        assert!((0.5 * expected..2.0 * expected).contains(&found), "{found}");
        let mut turned = points;
        turned.reverse();
        assert_eq!(spacing(&turned, 1 << 16), spacing(&grid(256, 0.25), 1 << 16));
        for few in [vec![], vec![DVec3::ONE], vec![DVec3::ONE; 9], vec![DVec3::splat(-1.7e308), DVec3::splat(1.7e308)]]
        {
            let found = spacing(&few, few.len() as u64);
            assert!(found >= 0.0 && found.is_finite(), "{few:?}: {found}");
        }
        assert_eq!(spacing(&[DVec3::ONE; 9], 9), 0.0);
    }
}
