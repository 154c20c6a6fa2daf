//! The side from which a scene is broad: the automatic camera turns to it where it would see something long end-on.
//!
//! Breadth is the part of a coarse picture that points cover. Opposite sides are equally broad. Which of them has more
//! to show can't be told from points alone: jumps of depth tell relief, but also the hollow back of a statue that was
//! scanned from the front.

use glam::DVec3;
use rayon::prelude::*;

use super::framed::Framed;
use super::settings::CameraSettings;
use super::view::{Vertical, View};
use pellucid_core::cloud::Bounds;

/// Fewest points for which a decision is made.
const FEWEST: usize = 1000;
/// Points for each cell of the coarse picture, if they covered it evenly.
const POINTS_A_CELL: f64 = 12.0;
/// Cells along a side of it, at least and at most.
const CELLS: [usize; 2] = [16, 128];
/// Factor by which the other side must be broader than the usual one.
const MORE: f64 = 1.25;

/// Returns the settings of a camera that looks a quarter farther around than the usual one, if the scene is clearly
/// broader from there. `None` where the settings say anything of eye, target or view or tilt the picture, and of few
/// points. The order of points doesn't matter.
pub(super) fn broadest_side(
    settings: &CameraSettings,
    framed: &Framed<'_>,
    bounds: &Bounds,
    vertical: Vertical,
) -> Option<CameraSettings> {
    let CameraSettings { eye, target, up, view, .. } = settings;
    let places = framed.sampled();
    // A view takes the vertical for the image's top, which a tilted `up` isn't.
    let is_tilted = up.is_some_and(|up| up.cross(vertical.up()).length() > 1e-9 * up.length());
    if eye.is_some() || target.is_some() || is_tilted || view.is_given() || places.len() < FEWEST {
        return None;
    }
    let azimuth = View::default().azimuth_of(vertical);
    let sides = [0.0, 90.0].map(|more| View { azimuth: Some(azimuth + more), ..View::default() });
    let covered = sides.map(|view| covered(&places, bounds, view.axes(vertical)));
    let is_broader = covered[1] as f64 > MORE * covered[0] as f64;
    is_broader.then(|| CameraSettings { view: sides[1], ..*settings })
}

/// The cells that points cover in a coarse picture along `forward` with this `up`.
fn covered(places: &[DVec3], bounds: &Bounds, (forward, up): (DVec3, DVec3)) -> usize {
    let center = bounds.center();
    let half = bounds.corners().iter().map(|corner| (*corner - center).length()).fold(0.0, f64::max);
    let side = ((places.len() as f64 / POINTS_A_CELL).sqrt() as usize).clamp(CELLS[0], CELLS[1]);
    let [right, up] = [forward.cross(up), up].map(|axis| axis * (0.5 * side as f64 / half));
    let cell = |offset: f64| ((0.5 * side as f64 + offset) as usize).min(side - 1);
    let cover = |mut cells: Vec<bool>, position: &DVec3| {
        let p = *position - center;
        cells[cell(p.dot(up)) * side + cell(p.dot(right))] = true;
        cells
    };
    let both = |a: Vec<bool>, b: Vec<bool>| a.into_iter().zip(b).map(|(a, b)| a | b).collect();
    let nothing = || vec![false; side * side];
    places.par_iter().fold(nothing, cover).reduce(nothing, both).into_iter().filter(|covered| *covered).count()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::seq::SliceRandom;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use pellucid_core::cloud::UpAxis;
    use pellucid_core::points::{Points, Unseen};

    fn random(place: impl Fn(DVec3) -> DVec3) -> Vec<DVec3> {
        let mut random = Pcg64Mcg::seed_from_u64(4);
        (0..20_000).map(|_| place(DVec3::new(random.random(), random.random(), random.random()))).collect()
    }

    /// A hedge, 40 × 1 × 3, at an angle from the line along which the usual camera looks.
    fn hedge(degrees: f64) -> Vec<DVec3> {
        let (sin, cos) = (30.0 + degrees).to_radians().sin_cos();
        random(|p| DVec3::new(sin, -cos, 0.0) * 40.0 * p.x + DVec3::new(cos, sin, 0.0) * p.y + DVec3::Z * 3.0 * p.z)
    }

    fn points(positions: Vec<DVec3>) -> Points {
        pellucid_testing_host::white(positions, 1.0)
    }

    fn azimuth(settings: &CameraSettings, points: &Points) -> Option<f64> {
        let (framed, bounds) = (Framed::all(points), points.bounds()?);
        broadest_side(settings, &framed, &bounds, Vertical::from(UpAxis::Z)).and_then(|found| found.view.azimuth)
    }

    #[test]
    fn something_long_is_not_looked_at_end_on() {
        let free = CameraSettings::default();
        assert_eq!(azimuth(&free, &points(hedge(0.0))), Some(120.0));
        assert_eq!(azimuth(&free, &points(hedge(10.0))), Some(120.0));
        assert_eq!(azimuth(&free, &points(hedge(90.0))), None);
        let mut shuffled = hedge(0.0);
        shuffled.shuffle(&mut Pcg64Mcg::seed_from_u64(3));
        assert_eq!(azimuth(&free, &points(shuffled)), Some(120.0));
        let moved = hedge(0.0).into_iter().map(|p| p + DVec3::new(5e5, 4.5e6, 100.0)).collect();
        assert_eq!(azimuth(&free, &points(moved)), Some(120.0));
        assert!(azimuth(&CameraSettings { ortho: true, ..free }, &points(hedge(0.0))).is_some());
    }

    #[test]
    fn the_usual_side_is_kept_where_no_other_is_broader_and_where_a_view_is_asked_for() {
        let free = CameraSettings::default();
        assert_eq!(azimuth(&free, &points(random(|p| DVec3::new(p.x, p.y, 0.01 * p.z)))), None);
        assert_eq!(azimuth(&free, &points(random(|p| p))), None);
        assert_eq!(azimuth(&free, &points(hedge(0.0)[..900].to_vec())), None);
        let asked = [
            CameraSettings { eye: Some(DVec3::ONE), ..free },
            CameraSettings { view: View { elevation: Some(10.0), ..View::default() }, ..free },
            CameraSettings { up: Some(DVec3::new(0.5, 0.0, 1.0)), ..free },
        ];
        assert!(asked.iter().all(|settings| azimuth(settings, &points(hedge(0.0))).is_none()));
    }

    #[test]
    fn clipped_points_count() {
        let mut cut = points(hedge(0.0));
        let positions = cut.positions.split_off(900);
        cut.unseen = Arc::new(Unseen { radii: vec![0.0; positions.len()], positions });
        assert_eq!(azimuth(&CameraSettings::default(), &cut), Some(120.0));
    }
}
