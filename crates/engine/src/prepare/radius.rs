//! The radius of each point from its neighbors (Seemann et al., Eq. 20, corrected).
//!
//! As printed, Eq. 20 takes the root of a length; scaling a cloud by 1000 must scale its radii by 1000, so the squared
//! distance belongs under the root: r = 2·sqrt(max|pᵢ−pⱼ|² / K) = 2·max|pᵢ−pⱼ| / sqrt(K).

use crate::progress::Progress;
use glam::DVec3;

use super::neighbors::Places;

/// The radius of each finite position by Eq. 20 over its `neighbors` (K) nearest other points.
///
/// With fewer than K other points K is their number; a single point has radius 0, and so has a point with at least K
/// others in the same place. Distances are float64 of the positions as given. Radii beyond float32 become `f32::MAX`. The
/// bar's length is set to the number of distinct places.
pub fn estimate(positions: &[DVec3], neighbors: usize, progress: &Progress) -> Vec<f32> {
    let k = neighbors.min(positions.len().saturating_sub(1));
    let Some(places) = Places::group(positions, None).filter(|_| k > 0) else {
        return vec![0.0; positions.len()];
    };
    let (distances, _) = places.visit(k, false, progress, |_, _, distance| distance);
    of_distances(&places, k, &distances)
}

/// Eq. 20 for every point of a cloud, in the cloud's order, from the distance of the last neighbor of each place.
pub(super) fn of_distances(places: &Places, k: usize, distances: &[f64]) -> Vec<f32> {
    let factor = 2.0 / (k as f64).sqrt();
    let mut radii = vec![0.0; places.order.len()];
    for (place, distance) in distances.iter().enumerate() {
        let radius = ((factor * (distance * places.unit())) as f32).min(f32::MAX);
        for &index in &places.order[places.members(place)] {
            radii[index] = radius;
        }
    }
    radii
}
