//! The side of a scene with the most to see: the automatic camera turns to it by quarters.
//!
//! A thing shows most where it is broadest. Of two opposite sides, which are equally broad, the richer one has more jumps of depth
//! from one cell of a coarse picture to the next: a facade, a relief, the inside of a bowl. A wall from behind, or the smooth back
//! of a statue, has few.

use glam::DVec3;
use rayon::prelude::*;

use super::settings::CameraSettings;
use super::view::{Vertical, View};
use crate::cloud::Bounds;
use crate::points::Points;

/// Points below which nothing is told.
const FEWEST: usize = 1000;
/// Points for each cell of the coarse picture, if they covered it evenly: enough to cover what lies behind.
const POINTS_A_CELL: f64 = 12.0;
/// Cells along a side of it, at least and at most.
const CELLS: [usize; 2] = [16, 128];
/// A jump of depth, in cells: more than a surface seen at a slant.
const DEPTH_JUMP: f32 = 4.0;
/// How many times as broad, or as rich, another side must be as the usual one.
const MORE: f64 = 1.25;
/// Jumps below which a side has nothing to offer.
const FEWEST_JUMPS: usize = 64;

/// The settings of a camera that looks at the side with the most structure, from where the usual one looks or a quarter, a half
/// or three quarters farther around. `None` if that is the usual one, where the settings say anything of eye, target or view,
/// and of few points. Points that are clipped or hidden count as others do, so that slices of a scene have one camera, and the
/// order of points doesn't matter.
pub(super) fn richest_side(settings: &CameraSettings, points: &Points, vertical: Vertical) -> Option<CameraSettings> {
    let CameraSettings { eye, target, view, .. } = settings;
    if eye.is_some() || target.is_some() || view.is_given() || points.len() + points.unseen.positions.len() < FEWEST {
        return None;
    }
    let usual = View::default().azimuth_of(vertical);
    let bounds = points.bounds()?;
    let azimuth = |quarter: usize| View { azimuth: Some((usual + 90.0 * quarter as f64) % 360.0), ..View::default() };
    let sides: Vec<Coarse> =
        (0..4).into_par_iter().map(|quarter| Coarse::of(points, &bounds, azimuth(quarter).axes(vertical))).collect();
    let breadth = |quarter: usize| (sides[quarter].covered() + sides[quarter + 2].covered()) as f64;
    let near = usize::from(breadth(1) > MORE * breadth(0));
    let jumps = |quarter: usize| sides[quarter].jumps();
    let far_is_richer = jumps(near + 2) >= FEWEST_JUMPS && jumps(near + 2) as f64 > MORE * jumps(near) as f64;
    let quarter = if far_is_richer { near + 2 } else { near };
    (quarter != 0).then(|| CameraSettings { view: azimuth(quarter), ..*settings })
}

/// The depth of the nearest point of each cell of a coarse picture, in cells; infinite where there is none.
struct Coarse {
    side: usize,
    cells: Vec<f32>,
}

impl Coarse {
    fn of(points: &Points, bounds: &Bounds, (forward, up): (DVec3, DVec3)) -> Self {
        let all = || points.positions.iter().chain(&points.unseen.positions);
        let ideal = (all().count() as f64 / POINTS_A_CELL).sqrt() as usize;
        let side = ideal.clamp(CELLS[0], CELLS[1]);
        let (center, axes) = (bounds.center(), [forward.cross(up), up, forward]);
        let half = bounds.corners().iter().map(|corner| (*corner - center).length()).fold(0.0, f64::max);
        let cell = 2.0 * half / side as f64;
        let mut cells = vec![f32::INFINITY; side * side];
        for position in all() {
            let [x, y, depth] = axes.map(|axis| (*position - center).dot(axis));
            let column = |along: f64| ((along + half) / cell) as usize;
            let nearest = &mut cells[column(y).min(side - 1) * side + column(x).min(side - 1)];
            *nearest = nearest.min((depth / cell) as f32);
        }
        Self { side, cells }
    }

    /// Cells with points.
    fn covered(&self) -> usize {
        self.cells.iter().filter(|depth| depth.is_finite()).count()
    }

    /// Pairs of neighboring cells between which depth jumps.
    fn jumps(&self) -> usize {
        let at = |x: usize, y: usize| self.cells[y * self.side + x];
        // Beside a cell without points nothing jumps: the difference is infinite, or no number.
        let jumps = |a: f32, b: f32| usize::from((DEPTH_JUMP..f32::INFINITY).contains(&(a - b).abs()));
        let each = (0..self.side - 1).flat_map(|y| (0..self.side - 1).map(move |x| (x, y)));
        each.map(|(x, y)| jumps(at(x, y), at(x + 1, y)) + jumps(at(x, y), at(x, y + 1))).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Vec3;
    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::cloud::UpAxis;
    use crate::points::Unseen;

    /// A wall of bricks that stand out of it toward `out`, smooth behind.
    fn wall(out: DVec3) -> Vec<DVec3> {
        let mut random = Pcg64Mcg::seed_from_u64(7);
        let along = out.cross(DVec3::Z);
        (0..40_000)
            .map(|i| {
                let (x, z) = (10.0 * random.random::<f64>(), 10.0 * random.random::<f64>());
                let stands_out = (x as i32 + z as i32) % 2 == 0;
                let depth = if i % 2 == 0 || !stands_out { 0.0 } else { 2.0 };
                along * x + DVec3::Z * z + out * depth
            })
            .collect()
    }

    fn points(positions: Vec<DVec3>) -> Points {
        let count = positions.len();
        Points { positions, colors: vec![Vec3::ONE; count], radii: vec![0.0; count], ..Points::default() }
    }

    fn azimuth(settings: &CameraSettings, positions: Vec<DVec3>) -> Option<f64> {
        richest_side(settings, &points(positions), Vertical::from(UpAxis::Z)).and_then(|found| found.view.azimuth)
    }

    #[test]
    fn the_side_with_relief_is_looked_at() {
        let free = CameraSettings::default();
        // The front is −Y.
        assert_eq!(azimuth(&free, wall(-DVec3::Y)), None);
        let behind = azimuth(&free, wall(DVec3::Y));
        assert_eq!(behind, Some(210.0));
        let mut shuffled = wall(DVec3::Y);
        shuffled.shuffle(&mut Pcg64Mcg::seed_from_u64(3));
        assert_eq!(azimuth(&free, shuffled), behind);
        let moved = wall(DVec3::Y).into_iter().map(|p| p + DVec3::new(5e5, 4.5e6, 100.0)).collect();
        assert_eq!(azimuth(&free, moved), behind);
    }

    #[test]
    fn what_is_long_is_looked_at_from_where_it_is_broad() {
        // A hedge along the usual view.
        let mut random = Pcg64Mcg::seed_from_u64(4);
        let mut number = || random.random::<f64>();
        let (sin, cos) = 30.0f64.to_radians().sin_cos();
        let along = DVec3::new(sin, -cos, 0.0);
        let hedge =
            (0..20_000).map(|_| along * 40.0 * number() + DVec3::new(number(), number(), 3.0 * number())).collect();
        assert!(matches!(azimuth(&CameraSettings::default(), hedge), Some(120.0 | 300.0)));
    }

    #[test]
    fn the_usual_side_is_kept_where_others_have_no_more_and_where_a_view_is_asked_for() {
        let mut random = Pcg64Mcg::seed_from_u64(8);
        let mut number = || random.random::<f64>();
        let free = CameraSettings::default();
        let ground: Vec<DVec3> = (0..40_000)
            .map(|_| DVec3::new(number(), number(), 0.0))
            .map(|p| p + DVec3::Z * 0.05 * ((20.0 * p.x).sin() + (20.0 * p.y).cos()))
            .collect();
        assert_eq!(azimuth(&free, ground), None);
        assert_eq!(azimuth(&free, wall(DVec3::Y).into_iter().take(900).collect()), None);
        let asked = [
            CameraSettings { eye: Some(DVec3::ONE), ..free },
            CameraSettings { view: View { elevation: Some(10.0), ..View::default() }, ..free },
        ];
        assert!(asked.iter().all(|settings| azimuth(settings, wall(DVec3::Y)).is_none()));
        assert!(azimuth(&CameraSettings { ortho: true, ..free }, wall(DVec3::Y)).is_some());
    }

    #[test]
    fn clipped_points_count() {
        let free = CameraSettings::default();
        let mut cut = points(wall(DVec3::Y));
        let positions = cut.positions.split_off(10_000);
        cut.unseen = Arc::new(Unseen { radii: vec![0.0; positions.len()], positions });
        let whole = richest_side(&free, &points(wall(DVec3::Y)), Vertical::from(UpAxis::Z));
        assert_eq!(richest_side(&free, &cut, Vertical::from(UpAxis::Z)), whole);
    }
}
