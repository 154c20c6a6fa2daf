//! Tells clouds in the frame of a depth camera from others: the camera stands at the origin and looks along +Z, so that
//! points fill the pyramid that it sees, and −Y is up (the optical frame of the Robot Operating System's REP 103).

use glam::DVec3;

/// Fewest points for which a decision is made.
const FEWEST: usize = 1000;
/// The share of points that lie in the pyramid, at least.
const MOST: f64 = 0.995;
/// |x| / z and |y| / z of the pyramid's sides: wide lenses have a little less.
const WIDE: f64 = 1.2;
/// Largest such ratio of the pyramid's middle. A tenth of the points lies beside it, along either axis: a tower far
/// above the origin fills no pyramid.
const NARROW: f64 = 0.25;
/// The share of points in each of the four quarters of the image, at least.
const QUARTER: f64 = 0.05;
/// The last point but a hundredth is this many times as far as the first but a hundredth, and reaches at least this
/// share of the larger of width and height into the depth: ground far below or above the origin is flat.
const DEEP: (f64, f64) = (2.0, 0.5);

/// Returns `true` for clouds in the frame of a depth camera.
#[doc(hidden)]
pub fn is_depth_camera(positions: &[DVec3]) -> bool {
    let count = positions.len();
    if count < FEWEST {
        return false;
    }
    let share = |holds: &dyn Fn(&DVec3) -> bool| positions.iter().filter(|p| holds(p)).count() as f64 / count as f64;
    let is_within = |p: &DVec3| p.z > 0.0 && p.x.abs() <= WIDE * p.z && p.y.abs() <= WIDE * p.z;
    // Most other clouds are told here.
    if share(&is_within) < MOST {
        return false;
    }
    let fills = |axis: usize| share(&|p| p[axis].abs() > NARROW * p.z) >= 0.1;
    let quarters = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let has_quarters = quarters.iter().all(|[x, y]| share(&|p| p.x * x > 0.0 && p.y * y > 0.0) >= QUARTER);
    let [width, height, _] = [0, 1, 2].map(|axis| {
        let [low, high] = hundredths(positions.iter().map(|p| p[axis]).collect());
        high - low
    });
    let [near, far] = hundredths(positions.iter().map(|p| p.z).collect());
    fills(0) && fills(1) && has_quarters && far >= DEEP.0 * near && far - near >= DEEP.1 * width.max(height)
}

/// Returns the first and the last hundredth of some values.
#[doc(hidden)]
pub fn hundredths(mut values: Vec<f64>) -> [f64; 2] {
    let last = values.len() - 1;
    let mut at = |place: usize| *values.select_nth_unstable_by(place, f64::total_cmp).1;
    [at(last / 100), at(last - last / 100)]
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn points(place: impl Fn([f64; 3]) -> DVec3) -> Vec<DVec3> {
        let mut random = Pcg64Mcg::seed_from_u64(2);
        (0..5000).map(|_| place([(); 3].map(|()| random.random()))).collect()
    }

    #[test]
    fn clouds_of_depth_cameras_are_recognized() {
        let seen = |[u, v, w]: [f64; 3]| {
            let z = 0.8 + 2.4 * w;
            DVec3::new((1.2 * u - 0.6) * z, (0.9 * v - 0.45) * z, z)
        };
        assert!(is_depth_camera(&points(seen)));
        assert!(is_depth_camera(&points(|at| 1000.0 * seen(at))), "millimeters");
        assert!(!is_depth_camera(&points(|at| -seen(at))), "behind");
        assert!(!is_depth_camera(&points(seen)[..900]));
    }

    #[test]
    fn other_clouds_are_not_taken_for_it() {
        let centered = |[u, v, w]: [f64; 3]| DVec3::new(u - 0.5, v - 0.5, w - 0.5);
        let clouds = [
            ("model", points(centered)),
            ("standing on the ground", points(|at| centered(at) + DVec3::Z * 0.5)),
            ("ground at a height", points(|at| centered(at) * DVec3::new(200.0, 200.0, 20.0) + DVec3::Z * 300.0)),
            ("hills", points(|at| centered(at) * DVec3::new(400.0, 400.0, 180.0) + DVec3::Z * 180.0)),
            ("tower", points(|at| centered(at) * DVec3::new(1.0, 1.0, 30.0) + DVec3::Z * 20.0)),
            ("box before the origin", points(|at| centered(at) * 2.0 + DVec3::Z * 5.0)),
            ("survey", points(|at| centered(at) * 50.0 + DVec3::new(5e5, 4.5e6, 100.0))),
        ];
        for (name, cloud) in clouds {
            assert!(!is_depth_camera(&cloud), "{name}");
        }
    }
}
