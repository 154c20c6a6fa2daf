//! The smallest depth between two layers, d̃ of Dobrev, Rosenthal, Linsen (2010), as the points themselves suggest it.
//!
//! The filter of occluded pixels compares the depth of a pixel with those of the eight around it, and peeling compares
//! the depths of points on one pixel. Both treat depths that differ by less than d̃ as one surface. So d̃ must exceed
//! the depth differences of one sampled surface over such a stencil, but only just, since layers closer than d̃ can't
//! be separated.
//!
//! Let a surface have one point for each square of side s, the spacing. In an image whose pixels are as wide as s every
//! pixel just has its point; with narrower pixels, filling repeats points over about the same area. The points of a
//! pixel and of one that it touches at a corner are at most two diagonals of a pixel apart, 2√2·s across the view, and
//! on a surface that is tilted by θ their depths differ by 2√2·s·tan θ at most. Up to θ = 60° that is 2√6·s = 4.9·s.
//! Steeper parts are narrow in the image: for a sphere they are the outer quarter of the disc. Pixels wider than s need
//! a d̃ that is larger by the same factor.
//!
//! s follows from the distance r of a point's 8th neighbor: a disc of that radius holds 8 others, so that πr² = 8s².
//! This holds for any arrangement of the points on a surface (a square grid has 0.886 instead of 1, random points 1 on
//! average), as long as other surfaces are farther away than r = 1.6·s. The median over the points is used, so that
//! neither rims nor outliers matter.

use std::f64::consts::PI;

use glam::DVec3;

use super::neighbors::Places;
use pellucid_core::parallel;
use pellucid_core::points::Points;

/// Spacings to d̃: two diagonals of a pixel at 60°.
pub const SPACINGS: f64 = 2.0 * std::f64::consts::SQRT_2 * 1.732_050_807_568_877_2;

/// Neighbors that a spacing is made of.
const NEIGHBORS: usize = 8;
/// Points of a run that is looked at by itself.
const RUN: usize = 1 << 12;
/// Runs at most: a cloud of more points is looked at in places.
const RUNS: usize = 64;
/// The fraction of points whose neighbors are searched, 1/`STRIDE`, where the cloud has several runs.
const STRIDE: usize = 8;

/// d̃ in world units, finite and above 0; `None` if fewer than nine points differ, which leaves the spacing undefined.
///
/// `points` are in canonical order, so that a run of them is a patch of the surface. The same points give the same
/// value; it takes some hundredths of a second for any number of points.
pub fn suggest(points: &Points) -> Option<f64> {
    let spacing = spacing(&points.positions)?;
    let distance = SPACINGS * spacing;
    (distance.is_finite() && distance > 0.0).then_some(distance)
}

/// The median spacing of positions whose neighbors in space are neighbors in the list.
fn spacing(positions: &[DVec3]) -> Option<f64> {
    let mut spacings = if positions.len() <= RUN * RUNS {
        of_run(positions, if positions.len() > RUN { STRIDE } else { 1 })
    } else {
        let start = |run: usize| (positions.len() - RUN) / (RUNS - 1) * run;
        parallel::gather(RUNS, |run| of_run(&positions[start(run)..][..RUN], STRIDE)).concat()
    };
    let middle = spacings.len() / 2;
    (!spacings.is_empty()).then(|| *spacings.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The spacing around every `stride`th place of a run; nothing if it has too few.
fn of_run(positions: &[DVec3], stride: usize) -> Vec<f64> {
    // Points at the same position are one sample of the surface; in canonical order they are adjacent.
    let mut distinct = positions.to_vec();
    distinct.dedup();
    let Some(places) = Places::group(&distinct, None).filter(|places| places.len() > NEIGHBORS) else {
        return Vec::new();
    };
    let around = |place: usize| places.others(place, NEIGHBORS).1 * places.unit * (PI / NEIGHBORS as f64).sqrt();
    parallel::map(places.len().div_ceil(stride), |i| around(i * stride))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::order;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn points(positions: Vec<DVec3>) -> Points {
        order::canonical(pellucid_testing_host::white(positions, 1.0))
    }

    /// Random points on a unit square.
    fn square(count: usize) -> Vec<DVec3> {
        let mut random = Pcg64::seed_from_u64(count as u64);
        (0..count).map(|_| DVec3::new(random.random(), random.random(), 0.25)).collect()
    }

    fn spacings(positions: Vec<DVec3>) -> f64 {
        suggest(&points(positions)).unwrap() / SPACINGS
    }

    #[test]
    fn a_square_has_its_spacing_whatever_the_number_of_points() {
        for count in [1000, 50_000, 400_000] {
            let found = spacings(square(count)) * (count as f64).sqrt();
            // Rims make it larger: of 1000 points an eighth is near one. The median of r² is 4% below its mean.
            assert!((0.97..1.03).contains(&found), "{count}: {found}");
        }
        let grid = (0..200).flat_map(|x| (0..200).map(move |y| 0.5 * DVec3::new(f64::from(x), f64::from(y), 0.0)));
        let found = spacings(grid.collect());
        assert!((found - 0.5 * (2.0 * PI / 8.0).sqrt()).abs() < 1e-9, "{found}");
    }

    #[test]
    fn a_sphere_has_that_of_its_area() {
        let mut random = Pcg64::seed_from_u64(7);
        let mut sphere = || {
            let z: f64 = random.random_range(-1.0..1.0);
            let angle = random.random_range(0.0..std::f64::consts::TAU);
            1000.0 * (glam::DVec2::from_angle(angle) * (1.0 - z * z).sqrt()).extend(z)
        };
        let count = 30_000;
        let found = spacings((0..count).map(|_| sphere()).collect());
        let wanted = 1000.0 * (4.0 * PI / f64::from(count)).sqrt();
        assert!((found / wanted - 1.0).abs() < 0.03, "{found} {wanted}");
    }

    #[test]
    fn copies_outliers_and_order_do_not_matter() {
        let once = square(20_000);
        let wanted = spacings(once.clone());
        let mut more = [once.clone(), once.clone(), once].concat();
        more.reverse();
        assert_eq!(spacings(more.clone()), wanted);
        more.extend((0..200).map(|i| DVec3::new(1e6, 1e5 * f64::from(i), 0.0)));
        assert!((spacings(more) / wanted - 1.0).abs() < 0.02);
    }

    #[test]
    fn too_few_or_equal_points_suggest_nothing() {
        assert_eq!(suggest(&Points::default()), None);
        assert_eq!(suggest(&points(square(8))), None);
        assert_eq!(suggest(&points(vec![DVec3::ONE; 5000])), None);
        assert!(suggest(&points(square(9))).is_some());
        let huge: Vec<DVec3> = square(100).into_iter().map(|p| 1.7e308 * (p - 0.5)).collect();
        assert!(suggest(&points(huge)).is_none_or(|d| d.is_finite()));
    }
}
