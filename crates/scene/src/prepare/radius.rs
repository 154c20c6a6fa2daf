//! The radius of each point from its neighbors (Seemann et al., Eq. 20, corrected).
//!
//! As printed, Eq. 20 takes the root of a length; scaling a cloud by 1000 must scale its radii by 1000, so the squared
//! distance belongs under the root: r = 2·sqrt(max|pᵢ−pⱼ|² / K) = 2·max|pᵢ−pⱼ| / sqrt(K).
//!
//! An outlier is far from everything, so that its radius by Eq. 20 is as large as it is far: one of a thousand of them
//! covers the picture. A cap keeps each radius within a multiple of the median of its neighbors' radii.

use glam::DVec3;
use pellucid_core::progress::Progress;
use rayon::prelude::*;

use super::neighbors::{Again, Lists, Places, least_of_median};
use pellucid_core::parallel;

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
    let (distances, lists) = places.visit(k, again(cap), progress, |_, _, distance| distance);
    let ranks = places.ranks();
    let uncapped = of_distances(&places, &ranks, k, &distances);
    Radii { capped: of_distances(&places, &ranks, k, &capped(&places, (k, cap), &lists, distances)), uncapped }
}

/// Returns the neighbors that [`capped`] needs.
pub(super) fn again(cap: f32) -> Again {
    if cap == 0.0 { Again::No } else { Again::Capped(cap) }
}

/// Returns the distances of the last neighbors of each place, at most `cap` times the median of those of a point's K
/// neighbors and its own. Radii are proportional to them. A point with at least K others in its place has distance 0.
pub(super) fn capped(places: &Places, (k, cap): (usize, f32), lists: &Lists, distances: Vec<f64>) -> Vec<f64> {
    if cap == 0.0 {
        return distances;
    }
    let of_rank = |rank: usize| distances[places.place_of(rank as u32)];
    let by_rank: Vec<f64> = parallel::map(places.order.len(), of_rank);
    let one = |around: &mut Vec<f64>, place: usize, others: &[u32]| {
        let own = distances[place];
        // Enough of the radii around are large enough, and so is their median: nearly all places.
        let beside = others.iter().filter(|&&rank| f64::from(cap) * by_rank[rank as usize] >= own).count();
        if others.is_empty() || beside >= least_of_median(k) {
            return own;
        }
        around.clear();
        around.extend(places.members(place).map(|_| own));
        around.extend(others.iter().map(|&rank| by_rank[rank as usize]));
        debug_assert_eq!(around.len(), k + 1);
        own.min(f64::from(cap) * median(around))
    };
    let all = (0..places.len()).into_par_iter().with_min_len(1 << 10);
    all.map_init(Vec::new, |around, place| {
        lists.others(places, place, |others| one(around, place, others)).unwrap_or(distances[place])
    })
    .collect()
}

/// Returns the middle one of some values, of an even number the mean of the two middle ones; 0 for none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    let half = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let odd = values.len() % 2 == 1;
    let (below, middle, _) = values.select_nth_unstable_by(half, f64::total_cmp);
    if odd { *middle } else { 0.5 * (*middle + below.iter().copied().fold(0.0, f64::max)) }
}

/// Eq. 20 for every point of a cloud, in the cloud's order, from the distance of the last neighbor of each place.
pub(super) fn of_distances(places: &Places, ranks: &[u32], k: usize, distances: &[f64]) -> Vec<f32> {
    let of_rank = |rank: &u32| of_distance(distances[places.place_of(*rank)] * places.unit, k);
    parallel::map_each(ranks, of_rank)
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
    fn lists_that_are_not_kept_are_not_needed() {
        let cloud = cloud(4000, 7);
        let places = Places::group(&cloud, None).unwrap();
        for k in [1, 2, 3, 8, 24] {
            for cap in [0.5, 1.0, 1.2, 2.0, 4.0, 100.0] {
                let capped_by = |again: Again| {
                    let (distances, lists) = places.visit(k, again, &Progress::hidden(), |_, _, distance| distance);
                    let kept =
                        (0..places.len()).filter(|place| lists.others(&places, *place, |_| ()).is_some()).count();
                    (capped(&places, (k, cap), &lists, distances), kept)
                };
                let ((all, every), (some, kept)) = (capped_by(Again::All), capped_by(Again::Capped(cap)));
                assert!(all == some, "K = {k}, at most {cap}");
                assert_eq!(every, places.len());
                // Nearly all neighbors are nearer than 0.99 of the last one's distance.
                assert!(cap < 100.0 || k < 8 || kept < every / 2, "K = {k}, at most {cap}: {kept} of {every}");
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
