//! The side of a scene with the most to see: the automatic camera turns to it by quarters.
//!
//! A thing shows most where it is broadest. Of two opposite sides, which are equally broad, the richer one has more jumps of depth
//! or color from one cell of a coarse picture to the next: a facade, a relief, the inside of a bowl. A wall from behind, or the
//! smooth back of a statue, has few.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::settings::CameraSettings;
use super::view::{Vertical, View};
use crate::cloud::Bounds;
use crate::color::encode_srgb;
use crate::points::Points;

/// Points below which nothing is told.
const FEWEST: usize = 1000;
/// Points for each cell of the coarse picture, if they covered it evenly: enough to cover what lies behind.
const POINTS_A_CELL: f64 = 12.0;
/// Cells along a side of it, at least and at most.
const CELLS: [usize; 2] = [16, 128];
/// A jump of depth, in cells: more than a surface seen at a slant.
const DEPTH_JUMP: f32 = 4.0;
/// A jump of sRGB luma.
const LUMA_JUMP: f32 = 0.15;
/// How many times as broad, or as rich, another side must be as the usual one.
const MORE: f64 = 1.25;
/// Jumps below which a side has nothing to offer.
const FEWEST_JUMPS: usize = 64;

/// The settings of a camera that looks at the side with the most structure, from where the usual one looks or a quarter, a half
/// or three quarters farther around. `None` if that is the usual one, where the settings say anything of eye, target or view,
/// and of few points. The order of points doesn't matter.
pub(super) fn richest_side(settings: &CameraSettings, points: &Points, vertical: Vertical) -> Option<CameraSettings> {
    let CameraSettings { eye, target, view, .. } = settings;
    if eye.is_some() || target.is_some() || view.is_given() || points.len() < FEWEST {
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

/// The nearest point of each cell of a coarse picture: its depth in cells, and its luma.
struct Coarse {
    side: usize,
    cells: Vec<Option<(f32, f32)>>,
}

impl Coarse {
    fn of(points: &Points, bounds: &Bounds, (forward, up): (DVec3, DVec3)) -> Self {
        let ideal = (points.len() as f64 / POINTS_A_CELL).sqrt() as usize;
        let side = ideal.clamp(CELLS[0], CELLS[1]);
        let (center, axes) = (bounds.center(), [forward.cross(up), up, forward]);
        let half = bounds.corners().iter().map(|corner| (*corner - center).length()).fold(0.0, f64::max);
        let cell = 2.0 * half / side as f64;
        let mut cells: Vec<Option<(f32, f32)>> = vec![None; side * side];
        for (position, color) in points.positions.iter().zip(&points.colors) {
            let [x, y, depth] = axes.map(|axis| (*position - center).dot(axis));
            let column = |along: f64| ((along + half) / cell) as usize;
            let place = column(y).min(side - 1) * side + column(x).min(side - 1);
            let seen = ((depth / cell) as f32, luma(*color));
            // Of points at one depth the darkest, so that their order doesn't matter.
            if cells[place].is_none_or(|nearest| seen < nearest) {
                cells[place] = Some(seen);
            }
        }
        Self { side, cells }
    }

    /// Cells with points.
    fn covered(&self) -> usize {
        self.cells.iter().flatten().count()
    }

    /// Pairs of neighboring cells between which depth or color jumps.
    fn jumps(&self) -> usize {
        let at = |x: usize, y: usize| self.cells[y * self.side + x];
        let differ = |a: Option<(f32, f32)>, b: Option<(f32, f32)>| match (a, b) {
            (Some(a), Some(b)) => (a.0 - b.0).abs() > DEPTH_JUMP || (a.1 - b.1).abs() > LUMA_JUMP,
            _ => false,
        };
        let each = (0..self.side - 1).flat_map(|y| (0..self.side - 1).map(move |x| (x, y)));
        each.map(|(x, y)| usize::from(differ(at(x, y), at(x + 1, y))) + usize::from(differ(at(x, y), at(x, y + 1))))
            .sum()
    }
}

/// Rec. 709 luma of a linear color's sRGB values.
fn luma(color: Vec3) -> f32 {
    color.map(encode_srgb).dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::cloud::UpAxis;

    /// A wall of bricks that stand out of it toward `out`, smooth behind, and its colors.
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
    fn colors_are_structure_as_well() {
        // A smooth slab, painted in stripes behind.
        let mut random = Pcg64Mcg::seed_from_u64(9);
        let mut found =
            points((0..40_000).map(|i| DVec3::new(random.random(), f64::from(i % 2) * 0.1, random.random())).collect());
        for (color, p) in found.colors.iter_mut().zip(&found.positions) {
            *color = if p.y > 0.0 && (p.x * 20.0) as i32 % 2 == 0 { Vec3::ZERO } else { Vec3::ONE };
        }
        let settings = richest_side(&CameraSettings::default(), &found, Vertical::from(UpAxis::Z));
        let azimuth = settings.and_then(|found| found.view.azimuth);
        assert_eq!(azimuth, Some(210.0));
    }
}
