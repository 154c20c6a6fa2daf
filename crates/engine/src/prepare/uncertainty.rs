//! The uncertainty of a point lying on a surface (Seemann et al., Eq. 21), with the radii of Eq. 20.

use crate::progress::Progress;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::neighbors::Places;
use super::normal::smallest_axis;
use super::radius;
use crate::cloud::field;

/// The result of one pass over every point's neighbors, in the order of the cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Eq. 20 with its cap, as [`radius::estimate`] finds them, to the bit.
    pub radii: Vec<f32>,
    /// The given normals, with estimated ones in place of missing ones; zero where both are missing.
    pub normals: Vec<Vec3>,
    /// F of Eq. 21, in [0, 1].
    pub fields: Vec<f32>,
}

/// F = r·Σ(2−|nᵢ·nⱼ|)² / K over the K nearest other points of each finite position, scaled so that the smallest of the
/// cloud is 0 and the largest 1; 0 for all if they differ only by rounding. r has the `cap` of [`radius::estimate`].
///
/// `normals` are unit vectors, or zero for points without one. A missing normal is estimated as the smallest principal
/// axis of the point and its K neighbors. If that is not a single direction (all at one position, on a line, equal
/// spread), the point stays without normal, which counts as perpendicular to every other: such places are no surface.
/// With fewer than K other points K is their number. Neighbors are ordered by distance, then x, y, z, then normal, and
/// sums follow that order, so that neither the order of the points nor the sign of a normal changes a bit.
///
/// Takes about 4·K + 170 bytes per point; without the 4·K, and slower, if those are more than 2 GiB.
pub fn estimate(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    (neighbors, cap): (usize, f32),
    progress: &Progress,
) -> Surface {
    let count = positions.len();
    let given = || normals.map_or_else(|| vec![Vec3::ZERO; count], <[Vec3]>::to_vec);
    let k = neighbors.min(count.saturating_sub(1));
    let Some(places) = Places::group(positions, normals).filter(|_| k > 0) else {
        return Surface { radii: vec![0.0; count], normals: given(), fields: vec![0.0; count] };
    };
    let missing = given().contains(&Vec3::ZERO);
    let (seen, lists) = places.visit(k, true, progress, |place, others, distance| {
        let normal = if missing { estimated_normal(&places, place, others) } else { Vec3::ZERO };
        (distance, normal)
    });

    let distances = radius::capped(&places, (k, cap), &lists, seen.iter().map(|(distance, _)| *distance).collect());

    // Everything so far is by rank.
    let given = given();
    let mut ranked = vec![Vec3::ZERO; count];
    for (place, (_, estimated)) in seen.iter().enumerate() {
        for rank in places.members(place) {
            let own = given[places.order[rank]];
            ranked[rank] = if own == Vec3::ZERO { *estimated } else { own };
        }
    }
    let raw: Vec<f64> = (0..places.len())
        .into_par_iter()
        .with_min_len(1 << 10)
        .flat_map_iter(|place| {
            let distance = distances[place];
            lists.others(&places, place, |others| spread(&places, place, others, k, distance, &ranked))
        })
        .collect();
    let scaled = field::scaled(&raw);

    let mut surface =
        Surface { radii: radius::of_distances(&places, k, &distances), normals: given, fields: vec![0.0; count] };
    for (rank, &index) in places.order.iter().enumerate() {
        surface.normals[index] = ranked[rank];
        surface.fields[index] = scaled[rank];
    }
    surface
}

/// The normal of the points at a place and their neighbors elsewhere.
fn estimated_normal(places: &Places, place: usize, others: &[u32]) -> Vec3 {
    let here = places.positions[places.members(place).start];
    let own = places.members(place).map(|_| DVec3::ZERO);
    smallest_axis(own.chain(others.iter().map(|&rank| places.positions[rank as usize] - here)))
}

/// Eq. 21 of each point at a place, without a factor common to all.
fn spread(places: &Places, place: usize, others: &[u32], k: usize, distance: f64, normals: &[Vec3]) -> Vec<f64> {
    let here = places.members(place);
    // At least K others in the same place: the radius is 0.
    if others.is_empty() {
        return vec![0.0; here.len()];
    }
    let term = |own: DVec3, other: usize| (2.0 - own.dot(normals[other].as_dvec3()).abs()).powi(2);
    let sum = |point: usize| {
        let own = normals[point].as_dvec3();
        let beside: f64 = here.clone().filter(|&rank| rank != point).map(|rank| term(own, rank)).sum();
        others.iter().fold(beside, |sum, &rank| sum + term(own, rank as usize))
    };
    here.clone().map(|point| distance * sum(point) / k as f64).collect()
}
