//! The radius of each point from its neighbors (Seemann et al., Eq. 20, corrected).
//!
//! As printed, Eq. 20 takes the root of a length; scaling a cloud by 1000 must scale its radii by 1000, so the squared
//! distance belongs under the root: r = 2·sqrt(max|pᵢ−pⱼ|² / K) = 2·max|pᵢ−pⱼ| / sqrt(K).
//!
//! An outlier is far from everything, so that its radius by Eq. 20 is as large as it is far: one of a thousand of them
//! covers the picture. A cap keeps each radius within a multiple of the median of its neighbors' radii.

use glam::DVec3;
use pellucid_core::progress::Progress;

use super::neighbors::Places;

/// Default of the cap.
pub const DEFAULT_CAP: f32 = 4.0;

/// Returns the radius of each finite position by Eq. 20 over its `neighbors` (K) nearest other points, at most `cap`
/// times the median of the radii by Eq. 20 of these neighbors and the point itself; a cap of 0 is none.
///
/// With fewer than K other points K is their number; a single point has radius 0, and so has a point with at least K
/// others in the same place. Distances are float64 of the positions as given. Radii beyond float32 become `f32::MAX`.
/// The bar's length is set to the number of distinct places.
pub fn estimate(positions: &[DVec3], neighbors: usize, cap: f32, progress: &Progress) -> Vec<f32> {
    both(positions, neighbors, cap, progress).capped
}

/// The radii of points, with the cap and without it.
#[derive(Debug, Clone, PartialEq)]
pub struct Radii {
    /// Radii with the cap.
    pub capped: Vec<f32>,
    /// Radii of Eq. 20, without the cap.
    pub uncapped: Vec<f32>,
}

/// Estimates radii like [`estimate`], with the radii before the cap.
pub fn both(positions: &[DVec3], neighbors: usize, cap: f32, progress: &Progress) -> Radii {
    let k = neighbors.min(positions.len().saturating_sub(1));
    let Some(places) = Places::group(positions, None).filter(|_| k > 0) else {
        return Radii { capped: vec![0.0; positions.len()], uncapped: vec![0.0; positions.len()] };
    };
    let distances = places.visit(k, progress, |_, _, distance| distance);
    let uncapped = of_distances(&places, k, &distances);
    Radii { capped: of_distances(&places, k, &capped(&places, (k, cap), distances)), uncapped }
}

/// Returns the distances of the last neighbors of each place, at most `cap` times the median of those of a point's K
/// neighbors and its own. Radii are proportional to them. A point with at least K others in its place has distance 0.
pub(super) fn capped(places: &Places, (k, cap): (usize, f32), distances: Vec<f64>) -> Vec<f64> {
    if cap == 0.0 {
        return distances;
    }
    let of_rank = |rank: u32| distances[places.place_of(rank)];
    let one = |place: usize, others: &[u32]| {
        let own = distances[place];
        if others.is_empty() {
            return own;
        }
        let here = places.members(place).map(|_| own);
        let mut around: Vec<f64> = here.chain(others.iter().map(|&rank| of_rank(rank))).collect();
        debug_assert_eq!(around.len(), k + 1);
        own.min(f64::from(cap) * median(&mut around))
    };
    // Where no distance around is so much smaller, neither is their median: nearly everywhere.
    let changed = places.revisit_uneven(k, f64::from(cap), &distances, one);
    let mut distances = distances;
    changed.into_iter().for_each(|(place, distance)| distances[place] = distance);
    distances
}

/// Returns the middle one of some values, of an even number the mean of the two middle ones; 0 for none.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    let half = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let odd = values.len() % 2 == 1;
    let (below, middle, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    if odd { *middle } else { 0.5 * (*middle + below.iter().copied().fold(0.0, f64::max)) }
}

/// Eq. 20 for every point of a cloud, in the cloud's order, from the distance of the last neighbor of each place.
pub(super) fn of_distances(places: &Places, k: usize, distances: &[f64]) -> Vec<f32> {
    places.in_order_of_cloud(|rank| of_distance(distances[places.place_of(rank)] * places.unit, k))
}

/// Eq. 20: the radius of a point whose last of K neighbors is so far away.
pub(super) fn of_distance(distance: f64, k: usize) -> f32 {
    ((2.0 / (k as f64).sqrt() * distance) as f32).min(f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::super::neighbors::tests::cloud;
    use super::*;

    #[test]
    fn a_cap_holds_by_the_median_of_each_neighborhood() {
        let places = Places::group(&cloud(4000, 7), None).unwrap();
        for k in [1, 2, 3, 8, 24] {
            let distances = places.visit(k, &Progress::hidden(), |_, _, distance| distance);
            let around = |place: usize| -> Vec<f64> {
                let (others, _) = places.others(place, k);
                let others = others.into_iter().map(|rank| distances[places.place_of(rank)]);
                std::iter::repeat_n(distances[place], k + 1 - others.len()).chain(others).collect()
            };
            for cap in [0.5, 1.0, 1.2, 2.0, 4.0, 100.0] {
                let capped = capped(&places, (k, cap), distances.clone());
                for (place, found) in capped.into_iter().enumerate() {
                    let expected = distances[place].min(f64::from(cap) * median(&mut around(place)));
                    assert_eq!(found, expected, "K = {k}, at most {cap}, place {place}");
                }
            }
        }
    }

    #[test]
    fn medians_by_hand() {
        assert_eq!(median(&mut []), 0.0);
        assert_eq!(median(&mut [3.0]), 3.0);
        assert_eq!(median(&mut [4.0, 1.0]), 2.5);
        assert_eq!(median(&mut [9.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [5.0, 0.0, 7.0, 1.0]), 3.0);
    }
}
