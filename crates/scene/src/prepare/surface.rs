//! The surface around each point: its normal, and the uncertainty of the point lying on it (Seemann et al., Eq. 21),
//! with the radii of Eq. 20.

use glam::{DVec3, Vec3};
use pellucid_core::progress::Progress;

use super::neighbors::{Lists, Places};
use super::normal::{Moments, SmallestAxis, smallest_axes};
use super::radius;
use pellucid_core::cloud::field;
use pellucid_core::parallel;

/// Neighbors are kept up to this for F, and found again beyond it.
const MAX_LIST_BYTES: usize = 2 << 30;

/// The result of one pass over every point's neighbors, in the order of the cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceEstimates {
    /// Eq. 20 with its cap, as [`radius::estimate`] finds them, to the bit.
    pub radii: Vec<f32>,
    /// Radii of Eq. 20 without its cap.
    pub uncapped: Vec<f32>,
    /// The given normals, with estimated ones in place of missing ones; zero where both are missing.
    pub normals: Vec<Vec3>,
    /// `true` for normals that were estimated from points about a surface, `false` for other estimated ones.
    pub planar: Vec<bool>,
    /// F of Eq. 21, in [0, 1]; empty unless asked for.
    pub fields: Vec<f32>,
}

/// F = r·Σ(2−|nᵢ·nⱼ|)² / K over the K nearest other points of each finite position, scaled so that the smallest of the
/// cloud is 0 and the largest 1; 0 for all if they differ only by rounding. r has the `cap` of [`radius::estimate`].
///
/// `normals` are unit vectors, or zero for points without one. A missing normal is estimated as the smallest principal
/// axis of the point and its K neighbors. If that is not a single direction (all at one position, on a line, equal
/// spread), the point stays without normal, which counts as perpendicular to every other: such places are no surface.
/// With fewer than K other points K is their number. Sums follow the Morton order of the neighbors, so that neither the
/// order of the points nor the sign of a normal changes a bit.
///
/// Takes about 4·K + 170 bytes per point, of which the 4·K are 2 GiB at most: where they would be more, neighbors are
/// found twice.
pub fn estimate(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    around: (usize, f32),
    progress: &Progress,
) -> SurfaceEstimates {
    look(positions, normals, around, true, progress)
}

/// Returns the same without F.
pub fn shape(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    around: (usize, f32),
    progress: &Progress,
) -> SurfaceEstimates {
    look(positions, normals, around, false, progress)
}

fn look(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    (neighbors, cap): (usize, f32),
    wants_fields: bool,
    progress: &Progress,
) -> SurfaceEstimates {
    let count = positions.len();
    let k = neighbors.min(count.saturating_sub(1));
    let Some(places) = Places::group(positions, normals).filter(|_| k > 0) else {
        let zeros = || vec![0.0; count];
        return SurfaceEstimates {
            radii: zeros(),
            uncapped: zeros(),
            normals: normals.map_or_else(|| vec![Vec3::ZERO; count], <[Vec3]>::to_vec),
            planar: vec![false; count],
            fields: if wants_fields { zeros() } else { Vec::new() },
        };
    };
    let seen = see(&places, normals, (k, cap), Wants { normals: true, fields: wants_fields }, progress);
    SurfaceEstimates { fields: field::scaled(&seen.spreads), ..seen.surface }
}

/// View of points before F is scaled, in their order.
#[derive(Debug, Default)]
pub(super) struct UnscaledEstimates {
    /// Surface without F.
    pub surface: SurfaceEstimates,
    /// F before it is scaled; empty unless asked for.
    pub spreads: Vec<f64>,
    /// The distance of the last of K neighbors.
    pub last: Vec<f64>,
}

/// Data that is wanted in addition to radii.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wants {
    /// Normals in place of missing ones; F needs them, too.
    pub normals: bool,
    /// F.
    pub fields: bool,
}

/// Returns the same without scaling, of the points of some places, of which there are more than K.
pub(super) fn see(
    places: &Places,
    given: Option<&[Vec3]>,
    (k, cap): (usize, f32),
    wants: Wants,
    progress: &Progress,
) -> UnscaledEstimates {
    let lacks = wants.normals || wants.fields;
    let missing = lacks && given.is_none_or(|normals| normals.contains(&Vec3::ZERO));
    let see = |place: usize, others: &[u32], distance: f64| {
        let moments = if missing { moments(places, place, others) } else { Moments::default() };
        (distance, moments)
    };
    let axes_of = |seen: Vec<(f64, Moments)>| {
        let (distances, moments): (Vec<f64>, Vec<Moments>) = seen.into_iter().unzip();
        let axes = if missing { smallest_axes(&moments) } else { vec![SmallestAxis::default(); moments.len()] };
        distances.into_iter().zip(axes).collect()
    };
    let (seen, lists): (Vec<(f64, SmallestAxis)>, Lists) =
        places.visit_blocks(k, if wants.fields { MAX_LIST_BYTES } else { 0 }, progress, see, axes_of);
    let distances = parallel::map_each(&seen, |(distance, _)| *distance);
    let axes = parallel::map_each(&seen, |(_, axis)| *axis);
    drop(seen);
    let ranks = places.ranks();
    let last = parallel::map_each(&ranks, |&rank| distances[places.place_of(rank)] * places.unit);
    let uncapped = radius::of_distances(places, &ranks, k, &distances);
    let distances = radius::capped(places, (k, cap), distances);

    let shape = |rank: usize| match given.map_or(Vec3::ZERO, |normals| normals[places.order[rank]]) {
        Vec3::ZERO if lacks => {
            let estimated = axes[places.place_of(rank as u32)];
            (estimated.direction, estimated.planar)
        }
        own => (own, false),
    };
    let ranked: Vec<(Vec3, bool)> = parallel::map(ranks.len(), shape);
    let spreads = if wants.fields {
        let spreads = spreads(places, &lists, k, &distances, &ranked);
        parallel::map_each(&ranks, |&rank| spreads[rank as usize])
    } else {
        Vec::new()
    };
    let radii = radius::of_distances(places, &ranks, k, &distances);
    let normals = parallel::map_each(&ranks, |&rank| ranked[rank as usize].0);
    let planar = parallel::map_each(&ranks, |&rank| ranked[rank as usize].1);
    UnscaledEstimates {
        surface: SurfaceEstimates { radii, uncapped, normals, planar, fields: Vec::new() },
        spreads,
        last,
    }
}

/// Eq. 21 of all points by rank, without a factor common to all.
fn spreads(places: &Places, lists: &Lists, k: usize, distances: &[f64], ranked: &[(Vec3, bool)]) -> Vec<f64> {
    let of = |place: usize, others: &[u32]| spread(places, place, others, k, distances[place], ranked);
    lists.visit(places, of).into_iter().flatten().collect()
}

/// The moments of the points at a place and their neighbors elsewhere, in units of distance.
fn moments(places: &Places, place: usize, others: &[u32]) -> Moments {
    let (here, per_unit) = (places.positions[places.members(place).start], 1.0 / places.unit);
    let offsets = others.iter().map(|&rank| (places.positions[rank as usize] - here) * per_unit);
    Moments::around(places.members(place).len(), offsets)
}

/// Eq. 21 of each point at a place, without a factor common to all.
fn spread(places: &Places, place: usize, others: &[u32], k: usize, distance: f64, ranked: &[(Vec3, bool)]) -> Vec<f64> {
    let here = places.members(place);
    // At least K others in the same place: the radius is 0.
    if others.is_empty() {
        return vec![0.0; here.len()];
    }
    let term = |own: DVec3, other: usize| (2.0 - own.dot(ranked[other].0.as_dvec3()).abs()).powi(2);
    let sum = |point: usize| {
        let own = ranked[point].0.as_dvec3();
        let beside: f64 = here.clone().filter(|&rank| rank != point).map(|rank| term(own, rank)).sum();
        others.iter().fold(beside, |sum, &rank| sum + term(own, rank as usize))
    };
    here.clone().map(|point| distance * sum(point) / k as f64).collect()
}
