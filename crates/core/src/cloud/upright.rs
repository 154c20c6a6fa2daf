//! Tells shapes whose vertical is Z from those whose vertical is Y, where a file can't: ground spreads along X and Y,
//! and what stands has its centroid above the places that it stands on.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use rayon::prelude::*;

use super::depth_camera::hundredths;
use super::sampling::Sampling;
use super::{Cloud, UpAxis};
use crate::parallel;

/// Fewest points for which a decision is made.
const FEWEST: usize = 1000;
/// A cloud lies if its height is less than this share of both other sides.
const FLAT: f64 = 1.0 / 3.0;
/// The part of a shape's height in which it touches the floor.
const FOOT: f64 = 0.02;
/// The largest angle around the centroid without a foot: of a shape that would fall over, and of one that stands.
const FALLS: f64 = PI + FRAC_PI_2;
/// See [`FALLS`].
const STANDS: f64 = 0.9 * PI;

/// Returns the axis along which points extend less than a third as far as along both others, with the reason to take it
/// for the vertical, as the end of a sentence. The outermost hundredths along each axis don't count. `None` of few
/// points.
#[doc(hidden)]
pub fn flattest(positions: &[DVec3]) -> Option<(UpAxis, &'static str)> {
    if positions.len() < FEWEST { None } else { flattest_of(sides(positions).map(|[low, high]| high - low)) }
}

fn flattest_of(sides: [f64; 3]) -> Option<(UpAxis, &'static str)> {
    let axis = (0..3).find(|axis| (0..3).all(|other| other == *axis || sides[*axis] < FLAT * sides[other]))?;
    let all = [
        (UpAxis::X, "since its points are flattest along x"),
        (UpAxis::Y, "since its points are flattest along y"),
        (UpAxis::Z, "since its points are flattest along z"),
    ];
    Some(all[axis])
}

/// The range along each axis but for the outermost hundredths.
fn sides(positions: &[DVec3]) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| hundredths(parallel::map_each(positions, |p| p[axis])))
}

/// Lays a flat cloud whose vertical is only a convention of its format: the axis along which it is flattest becomes the
/// vertical.
#[doc(hidden)]
pub fn lay(cloud: &mut Cloud) {
    if !std::mem::take(&mut cloud.up_is_convention) {
        return;
    }
    let sampling = Sampling::of(cloud.len() as u64);
    let sampled: Vec<DVec3> = cloud.positions.par_iter().copied().filter(|p| sampling.takes(*p)).collect();
    let Some((up, reason)) = flattest(&sampled) else { return };
    if up.direction().abs() != cloud.up.direction().abs() {
        (cloud.up, cloud.up_reason) = (up, Some(reason));
    }
}

/// Returns the reason why Z is up where Y is the convention, as the end of a sentence: a shape with Y up would fall
/// over, and would not with Z up.
#[doc(hidden)]
pub fn reason_for_z(positions: &[DVec3]) -> Option<&'static str> {
    let count = positions.len();
    if count < FEWEST {
        return None;
    }
    let ranges = sides(positions);
    let [x, y, z] = ranges.map(|[low, high]| high - low);
    // Slopes have one foot; they lie along X and Z.
    if y <= x.min(z) {
        return None;
    }
    let centroid = positions.iter().sum::<DVec3>() / count as f64;
    let unsupported = |up: usize| {
        let [low, high] = ranges[up];
        let foot = low + FOOT * (high - low);
        let [a, b] = [(up + 1) % 3, (up + 2) % 3];
        let feet = positions.par_iter().filter(|p| p[up] <= foot);
        widest_gap(feet.map(|p| (p[b] - centroid[b]).atan2(p[a] - centroid[a])).collect())
    };
    (unsupported(1) > FALLS && unsupported(2) < STANDS).then_some("since with y up it would fall over")
}

/// The widest angle in a circle between neighboring ones of some angles in radians.
fn widest_gap(mut angles: Vec<f64>) -> f64 {
    angles.par_sort_unstable_by(f64::total_cmp);
    let around = angles.first().zip(angles.last()).map_or(2.0 * PI, |(first, last)| first + 2.0 * PI - last);
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn points(count: usize, place: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        let mut random = Pcg64Mcg::seed_from_u64(8);
        (0..count).map(|_| place(DVec3::new(random.random(), random.random(), random.random()))).collect()
    }

    /// A table with its vertical along Z, 2 × 4 × 3, whose four legs take as many points as its top, and a lamp beyond
    /// its edge.
    fn table() -> Vec<DVec3> {
        let mut table = points(3000, |p| DVec3::new(2.0 * p.x, 4.0 * p.y, 3.0));
        for (x, y) in [(0.3, 0.3), (0.3, 3.7), (1.7, 0.3), (1.7, 3.7)] {
            table.extend(points(750, |p| DVec3::new(x, y, 3.0 * p.z)));
        }
        table.extend(points(300, |p| DVec3::new(1.0, -1.0 + p.y, 3.0)));
        table
    }

    /// Decides as for a format with Y up.
    fn is_z_up(positions: &[DVec3]) -> bool {
        flattest(positions).map_or(reason_for_z(positions).is_some(), |(up, _)| up == UpAxis::Z)
    }

    fn turned(positions: Vec<DVec3>) -> Vec<DVec3> {
        positions.into_iter().map(|p| DVec3::new(p.x, p.z, -p.y)).collect()
    }

    #[test]
    fn a_table_stands_on_its_legs() {
        assert!(reason_for_z(&table()).unwrap().contains("fall over"));
        assert!(!is_z_up(&turned(table())), "Y is up");
        let moved = table().into_iter().map(|p| 1e-3 * p + DVec3::splat(50.0)).collect::<Vec<_>>();
        assert!(is_z_up(&moved), "millimeters");
        assert!(!is_z_up(&table()[..900]), "too few");
    }

    #[test]
    fn ground_lies() {
        let ground = |slope: f64| points(5000, |p| DVec3::new(80.0 * p.x, 50.0 * p.y, 4.0 * p.z + slope * p.x));
        assert_eq!(flattest(&ground(2.0)), Some((UpAxis::Z, "since its points are flattest along z")));
        assert!([2.0, 20.0, 40.0].iter().all(|slope| !is_z_up(&turned(ground(*slope)))));
    }

    #[test]
    fn other_shapes_keep_y() {
        let shapes = [
            ("cube", points(5000, |p| p)),
            ("ball", points(5000, |p| (p - DVec3::splat(0.5)).normalize())),
            ("pole", points(5000, |p| p * DVec3::new(1.0, 9.0, 1.0))),
            ("leaning front", points(5000, |p| DVec3::new(9.0 * p.x, 6.0 * p.y, 2.1 * p.y))),
            ("bird in flight", points(5000, |p| DVec3::new(4.0 * (p.x - 0.5), (4.0 * (p.x - 0.5)).abs(), p.z))),
            ("one place", points(5000, |_| DVec3::ONE)),
        ];
        for (name, shape) in shapes {
            assert!(!is_z_up(&shape), "{name}");
        }
    }

    #[test]
    fn the_axis_of_a_flat_cloud_becomes_its_vertical() {
        let sides = |x: f64, y: f64, z: f64| points(3000, move |p| p * DVec3::new(x, y, z));
        let laid = |convention: UpAxis, positions: Vec<DVec3>| {
            let mut cloud = Cloud { positions, up: convention, up_is_convention: true, ..Cloud::default() };
            lay(&mut cloud);
            (cloud.up, cloud.up_reason.is_some())
        };
        assert_eq!(laid(UpAxis::Z, sides(9.0, 2.9, 9.0)), (UpAxis::Y, true));
        assert_eq!(laid(UpAxis::Z, sides(1.0, 9.0, 4.0)), (UpAxis::X, true));
        assert_eq!(laid(UpAxis::Y, sides(70.0, 90.0, 4.0)), (UpAxis::Z, true));
        // Not under a third of both others, or what is the convention anyway.
        assert_eq!(laid(UpAxis::Z, sides(9.0, 3.1, 9.0)), (UpAxis::Z, false));
        assert_eq!(laid(UpAxis::Z, sides(9.0, 2.0, 2.0)), (UpAxis::Z, false));
        assert_eq!(laid(UpAxis::Z, sides(9.0, 9.0, 0.0)), (UpAxis::Z, false));
        assert_eq!(laid(UpAxis::NegativeY, sides(9.0, 1.0, 9.0)), (UpAxis::NegativeY, false));
        assert_eq!(laid(UpAxis::Z, sides(9.0, 1.0, 9.0)[..900].to_vec()), (UpAxis::Z, false), "too few");
        // A few strays make no cloud high, and no order of its points lays it.
        let mut strays = sides(9.0, 1.0, 9.0);
        strays.extend((0..20).map(|i| DVec3::Y * f64::from(i) * 1e6));
        strays.reverse();
        assert_eq!(laid(UpAxis::Z, strays), (UpAxis::Y, true));
        let mut known = Cloud { positions: sides(9.0, 1.0, 9.0), up: UpAxis::Z, ..Cloud::default() };
        lay(&mut known);
        assert_eq!(known.up, UpAxis::Z, "the file says so");
    }

    #[test]
    fn gaps_by_hand() {
        assert!((widest_gap(vec![0.0, FRAC_PI_2, PI]) - PI).abs() < 1e-15);
        assert!((widest_gap(vec![3.0, -3.0]) - 6.0).abs() < 1e-15);
        assert!((widest_gap(vec![1.0]) - 2.0 * PI).abs() < 1e-15);
        assert!((widest_gap(Vec::new()) - 2.0 * PI).abs() < 1e-15);
    }
}
