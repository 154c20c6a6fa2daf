//! The surface around each point: its normal, and the uncertainty of the point lying on it (Seemann et al., Eq. 21),
//! with the radii of Eq. 20.

use bytemuck::allocation::zeroed_vec;
use glam::{DVec3, Vec3};
use pellucid_core::progress::Progress;

use super::neighbors::{Lists, Places};
use super::normal::{Moments, smallest_axes};
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
/// Takes about 4·K + 110 bytes per point, of which the 4·K are 2 GiB at most: where they would be more, neighbors are
/// found twice.
pub fn estimate(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    around: (usize, f32),
    progress: &Progress,
) -> SurfaceEstimates {
    let wants = Wants { radii: true, uncapped: true, normals: true, fields: true, last: false };
    look(positions, normals, around, wants, progress)
}

/// Returns what is wanted of [`estimate`]; the rest may be empty.
pub(super) fn look(
    positions: &[DVec3],
    normals: Option<&[Vec3]>,
    (neighbors, cap): (usize, f32),
    wants: Wants,
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
            fields: if wants.fields { zeros() } else { Vec::new() },
        };
    };
    let seen = see(&places, normals, (k, cap), wants, progress);
    drop(places);
    SurfaceEstimates { fields: field::scaled(&seen.spreads), ..seen.surface }
}

/// View of points before F is scaled, in their order.
#[derive(Debug, Default)]
pub(super) struct UnscaledEstimates {
    /// Surface without F.
    pub surface: SurfaceEstimates,
    /// F before it is scaled; empty unless asked for.
    pub spreads: Vec<f64>,
    /// The distance of the last of K neighbors; empty unless asked for.
    pub last: Vec<f64>,
}

/// Data that is wanted. The rest takes no memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Wants {
    /// Radii with their cap.
    pub radii: bool,
    /// Radii without it.
    pub uncapped: bool,
    /// Normals in place of missing ones; F needs them, too.
    pub normals: bool,
    /// F.
    pub fields: bool,
    /// Distances of the last neighbors.
    pub last: bool,
}

/// Columns that a search writes, a block of places at a time.
struct Slot<'a> {
    distances: &'a mut [f64],
    directions: &'a mut [Vec3],
    planar: &'a mut [bool],
}

/// Returns what is wanted, without scaling, of the points of some places, of which there are more than K.
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
    let mut distances: Vec<f64> = zeroed_vec(places.len());
    let estimated = if missing { places.len() } else { 0 };
    let (mut directions, mut planar): (Vec<Vec3>, Vec<bool>) = (zeroed_vec(estimated), zeroed_vec(estimated));
    let columns = places.blocks(&mut distances).zip(places.blocks(&mut directions)).zip(places.blocks(&mut planar));
    let slots = columns.map(|((distances, directions), planar)| Slot { distances, directions, planar }).collect();
    let room = if wants.fields { MAX_LIST_BYTES } else { 0 };
    let lists = places.visit_blocks(k, room, progress, see, slots, |seen: Vec<(f64, Moments)>, slot: &mut Slot<'_>| {
        slot.distances.iter_mut().zip(&seen).for_each(|(distance, seen)| *distance = seen.0);
        if missing {
            let moments: Vec<Moments> = seen.into_iter().map(|(_, moments)| moments).collect();
            for (i, axis) in smallest_axes(&moments).into_iter().enumerate() {
                (slot.directions[i], slot.planar[i]) = (axis.direction, axis.planar);
            }
        }
    });
    let last = |rank: u32| distances[places.place_of(rank)] * places.unit;
    let last = if wants.last { places.in_order_of_cloud(last) } else { Vec::new() };
    let uncapped = if wants.uncapped { radius::of_distances(places, k, &distances) } else { Vec::new() };
    if wants.radii || wants.fields {
        distances = radius::capped(places, (k, cap), distances);
    }
    let own = |rank: u32| given.map_or(Vec3::ZERO, |normals| normals[places.index(rank as usize)]);
    let of_place = |rank: u32| (missing && own(rank) == Vec3::ZERO).then(|| places.place_of(rank));
    let planar = places.in_order_of_cloud(|rank| of_place(rank).is_some_and(|place| planar[place]));
    let normals = if given.is_none() && missing && places.are_alone() {
        directions
    } else {
        parallel::map(places.points(), |rank| {
            of_place(rank as u32).map_or_else(|| own(rank as u32), |place| directions[place])
        })
    };
    let spreads =
        if wants.fields { places.of_cloud(spreads(places, &lists, k, &distances, &normals)) } else { Vec::new() };
    let radii = if wants.radii { radius::of_distances(places, k, &distances) } else { Vec::new() };
    let normals = places.of_cloud(normals);
    UnscaledEstimates {
        surface: SurfaceEstimates { radii, uncapped, normals, planar, fields: Vec::new() },
        spreads,
        last,
    }
}

/// Eq. 21 of all points by rank, without a factor common to all.
fn spreads(places: &Places, lists: &Lists, k: usize, distances: &[f64], ranked: &[Vec3]) -> Vec<f64> {
    let of = |place: usize, others: &[u32]| spread(places, place, others, k, distances[place], ranked);
    lists.visit(places, of).into_iter().flatten().collect()
}

/// The moments of the points at a place and their neighbors elsewhere, in units of distance.
fn moments(places: &Places, place: usize, others: &[u32]) -> Moments {
    let here = places.position(place);
    let offsets = others.iter().map(|&rank| places.position(places.place_of(rank)) - here);
    Moments::around(places.members(place).len(), offsets)
}

/// Eq. 21 of each point at a place, without a factor common to all.
fn spread(places: &Places, place: usize, others: &[u32], k: usize, distance: f64, ranked: &[Vec3]) -> Vec<f64> {
    let here = places.members(place);
    // At least K others in the same place: the radius is 0.
    if others.is_empty() {
        return vec![0.0; here.len()];
    }
    let term = |own: DVec3, other: usize| (2.0 - own.dot(ranked[other].as_dvec3()).abs()).powi(2);
    let sum = |point: usize| {
        let own = ranked[point].as_dvec3();
        let beside: f64 = here.clone().filter(|&rank| rank != point).map(|rank| term(own, rank)).sum();
        others.iter().fold(beside, |sum, &rank| sum + term(own, rank as usize))
    };
    here.clone().map(|point| distance * sum(point) / k as f64).collect()
}
