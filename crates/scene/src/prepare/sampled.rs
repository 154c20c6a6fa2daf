//! Spacing and radii of a cloud from the neighbors of some of its points: fast on clouds whose neighbors would take
//! long to find, and exact on small ones.
//!
//! Points are looked at in equal steps along the Morton curve, so that all regions count by their points, and the same
//! points give the same numbers whatever their order in the file. A point in between has the radius of the nearest one
//! before it that was looked at: the density of a scan changes little over so short a way.

use glam::DVec3;

use super::neighbors::Places;
use super::radius;
use pellucid_core::parallel;

/// Places whose neighbors are found, at most.
const SAMPLES: usize = 2048;

/// Facts about a cloud that the neighbors of some points tell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sampled {
    /// The median distance to the nearest point at another place, in the cloud's units; `None` of fewer than two
    /// places.
    pub spacing: Option<f64>,
    /// All positions, along the Morton curve.
    pub positions: Vec<DVec3>,
    /// Radius of each of these positions: the given one, else that of Eq. 20, in the cloud's units.
    pub radii: Vec<f32>,
}

/// Looks at the neighbors of at most 2048 of these finite positions. `own` are their radii if they are known; others
/// are those of [`radius::estimate`] over K neighbors with this cap.
pub fn sample(positions: &[DVec3], own: Option<&[f32]>, (neighbors, cap): (usize, f32)) -> Sampled {
    sample_by(positions, own, (neighbors, cap), SAMPLES)
}

fn sample_by(positions: &[DVec3], own: Option<&[f32]>, (neighbors, cap): (usize, f32), samples: usize) -> Sampled {
    let Some(places) = Places::group(positions, None) else { return Sampled::default() };
    let step = places.len().div_ceil(samples);
    let spacing = spacing(&places, step);
    let radii = match own {
        Some(own) => (0..positions.len()).map(|rank| own[places.index(rank)]).collect(),
        None => radii(&places, step, neighbors.min(positions.len() - 1), cap),
    };
    Sampled { spacing, positions: parallel::map(positions.len(), |rank| positions[places.index(rank)]), radii }
}

fn spacing(places: &Places, step: usize) -> Option<f64> {
    // As many neighbors as there are points here: the last of them is the first one elsewhere.
    let nearest = |place: usize| places.others(place, places.members(place).len()).1 * places.unit;
    let mut all: Vec<f64> = parallel::map(places.len().div_ceil(step), |i| nearest(i * step));
    (places.len() > 1).then(|| radius::median(&mut all))
}

/// The radius of each point by its rank.
fn radii(places: &Places, step: usize, k: usize, cap: f32) -> Vec<f32> {
    if k == 0 {
        return vec![0.0; places.points()];
    }
    let looked_at: Vec<f64> = parallel::map(places.len().div_ceil(step), |i| distance(places, i * step, k, cap));
    let of_place = |place: usize| radius::of_distance(looked_at[place / step] * places.unit, k);
    (0..places.len()).flat_map(|place| std::iter::repeat_n(of_place(place), places.members(place).len())).collect()
}

/// The distance of the last of K neighbors, at most `cap` times the median of those of the point and its neighbors.
fn distance(places: &Places, place: usize, k: usize, cap: f32) -> f64 {
    let (others, own) = places.others(place, k);
    if others.is_empty() || cap == 0.0 {
        return own;
    }
    let here = places.members(place).map(|_| own);
    let there = others.iter().map(|&rank| places.others(places.place_of(rank), k).1);
    let mut around: Vec<f64> = here.chain(there).collect();
    own.min(f64::from(cap) * radius::median(&mut around))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::super::{DEFAULT_NEIGHBORS, order};
    use super::*;
    use pellucid_core::points::Points;
    use pellucid_core::progress::Progress;

    const RULE: (usize, f32) = (DEFAULT_NEIGHBORS, radius::DEFAULT_CAP);

    /// Random points on a unit square, some of them twice, and an outlier.
    fn square(count: usize) -> Vec<DVec3> {
        let mut random = Pcg64::seed_from_u64(3);
        let mut points: Vec<DVec3> = (0..count).map(|_| DVec3::new(random.random(), random.random(), 0.5)).collect();
        points.extend_from_within(..count / 10);
        points.push(DVec3::new(0.5, 0.5, 30.0));
        points
    }

    #[test]
    fn small_clouds_have_the_radii_of_all_neighbors() {
        let positions = square(500);
        let radii = radius::estimate(&positions, RULE.0, RULE.1, &Progress::hidden());
        let white = pellucid_testing_host::white(positions.clone(), 1.0);
        let wanted = order::canonical(Points { radii: radii.clone(), ..white });
        let found = sample(&positions, None, RULE);
        assert_eq!((&found.positions, &found.radii), (&wanted.positions, &wanted.radii));
        let given = sample(&positions, Some(&radii), RULE);
        assert_eq!(given, found);
    }

    #[test]
    fn some_points_tell_about_all() {
        let positions = square(20_000);
        let all = radius::estimate(&positions, RULE.0, RULE.1, &Progress::hidden());
        let mean = |radii: &[f32]| radii.iter().map(|r| f64::from(r * r)).sum::<f64>() / radii.len() as f64;
        let found = sample_by(&positions, None, RULE, 1000);
        // The squares of these radii spread by a third; of a thousand of them the mean is good to a hundredth.
        assert!((mean(&found.radii) / mean(&all) - 1.0).abs() < 0.05, "{} {}", mean(&found.radii), mean(&all));
        // Of random points of density n a circle with πr²n = ln 2 is empty in half of the cases.
        let wanted = (2.0f64.ln() / (std::f64::consts::PI * 20_000.0)).sqrt();
        assert!((found.spacing.unwrap() / wanted - 1.0).abs() < 0.1, "{:?} {wanted}", found.spacing);
    }

    #[test]
    fn spacings_by_hand() {
        let on_line = |xs: &[f64]| xs.iter().map(|x| DVec3::new(*x, 0.0, 0.0)).collect::<Vec<_>>();
        // Nearest others: 1, 1, 2, 4; the copies of 3 are one place.
        assert_eq!(sample(&on_line(&[0.0, 1.0, 3.0, 3.0, 3.0, 7.0]), None, RULE).spacing, Some(1.5));
        assert_eq!(
            sample(&on_line(&[5.0; 4]), None, RULE),
            Sampled { spacing: None, positions: on_line(&[5.0; 4]), radii: vec![0.0; 4] }
        );
        assert_eq!(sample(&[], None, RULE), Sampled::default());
        assert_eq!(sample(&on_line(&[2.0]), None, RULE).spacing, None);
    }
}
