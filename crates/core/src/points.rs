//! The points of a whole scene, ready for the device: merged, with every setting applied, in canonical order.

mod columns;
#[doc(hidden)]
pub mod packed;
mod sample;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cloud::Bounds;
use crate::cloud::gaussians::{Gaussians, MAX_DEGREE};
use crate::cloud::sampling::{Sampling, mix};
use crate::cloud::sensor::Sensor;
use crate::parallel;
pub use packed::Unreadable;
pub use sample::Known;

/// All points of a scene in one list. All columns have the same length.
///
/// The order is canonical: it follows from the points' values (position, color, opacity, radius, normal) and not from
/// the order in the files. The index in this list decides every tie between fragments of equal depth, so that shuffled
/// input gives the same bytes, and neighbors in space are neighbors in memory (Morton order).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points {
    /// World positions, all finite.
    pub positions: Vec<DVec3>,
    /// Linear RGB.
    pub colors: Vec<Vec3>,
    /// Opacity of a point's splat in [0, 1].
    pub opacities: Vec<f32>,
    /// World radii, finite and at least 0. All zero if the method does not ask for radii. Of a Gaussian how far it
    /// reaches at most.
    pub radii: Vec<f32>,
    /// Unit normals, `Vec3::ZERO` for points without one; absent if no cloud has any. Those that are estimated have
    /// length 2: they shade, but tilt no disc and hide no point ([`Points::own_normal`]).
    pub normals: Option<Vec<Vec3>>,
    /// The place of each point before it came into canonical order: file after file, point after point. Empty if
    /// unchanged. Only `unsorted` needs it.
    pub file_order: Vec<u32>,
    /// The id of each point of a list in another order ([`Points::ids`]); empty of one in canonical order, from which
    /// ids follow.
    pub dealt_ids: Vec<u32>,
    /// The scalar field F of each point in [0, 1], which separates solid points from soft ones. Empty means 0 for all;
    /// only the soft methods need it.
    pub fields: Vec<f32>,
    /// Shape and color of the points that are Gaussians, in world units; absent if none is.
    pub gaussians: Option<Gaussians>,
    /// Points that are not drawn but belong to the scene, for its bounds and its camera.
    pub unseen: Arc<Unseen>,
    /// The sensor that saw all of these points from one place, in world coordinates.
    pub sensor: Option<Sensor>,
    /// Facts about the scene, if these points only stand for more of them.
    pub whole: Option<Arc<WholeScene>>,
}

/// Facts about all points of a scene that are not in one list.
#[derive(Debug, Clone)]
pub struct WholeScene {
    /// Number of points, with those that are not drawn.
    pub count: u64,
    /// The box around all of them, in world coordinates.
    pub bounds: Bounds,
    /// The largest radius, in world units.
    pub largest_radius: f32,
    /// The largest component that a color may have, linear.
    pub brightest: f32,
    /// `true` if some of them may be transparent.
    pub is_transparent: bool,
    /// Identity of the points: the same text for the same points.
    pub identity: String,
    /// Count and bounds of those that are Gaussians; `None` if none is.
    pub splats: Option<WholeSplats>,
    /// Source of all spheres.
    pub spheres: Arc<dyn Spheres>,
}

/// Count and bounds of all Gaussians of a scene that are not in one list.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WholeSplats {
    /// Number of spheres.
    pub count: u64,
    /// The highest degree of their harmonics, 0 to 4.
    pub degree: u32,
    /// A bound on their display values, from whatever direction.
    pub brightest: f32,
}

impl WholeSplats {
    /// Returns the count and bounds of two parts together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            degree: self.degree.max(other.degree),
            brightest: self.brightest.max(other.brightest),
        }
    }
}

impl PartialEq for WholeScene {
    fn eq(&self, other: &Self) -> bool {
        self.identity == other.identity
    }
}

/// Points with their radii in groups that are read one by one.
pub trait Spheres: std::fmt::Debug + Send + Sync {
    /// Returns, for each group, a box around its positions and the largest radius, in world units.
    fn groups(&self) -> Vec<(Bounds, f64)>;

    /// Positions and radii of a group's points, also of those that are not drawn unless only `drawn` ones are asked
    /// for; nothing if they can't be read, which whoever reads them again is told.
    fn of_group(&self, group: usize, drawn: bool) -> Vec<(DVec3, f64)>;
}

/// Origin that the points of a scene are relative to on a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// The origin of positions: about the median of each coordinate.
    pub origin: DVec3,
    /// The binary exponent of the scene's size.
    exponent: i32,
}

impl Anchor {
    /// Creates the anchor of a scene from its bounds and points that stand for all of its points.
    #[doc(hidden)]
    pub fn new(sampled: &[DVec3], bounds: Option<Bounds>) -> Self {
        let side = bounds.map_or(0.0, |bounds| (0.5 * bounds.max - 0.5 * bounds.min).max_element());
        // Of 0 and of denormal sides any will do.
        let exponent = if side.is_normal() { side.log2().floor() as i32 } else { 0 };
        Self { origin: middle(sampled), exponent }
    }

    /// Bits of a length in units of about the scene's size.
    fn relative_length(&self, length: f32) -> u64 {
        let [half, rest] = [self.exponent / 2, self.exponent - self.exponent / 2].map(|part| 2f64.powi(-part));
        (f64::from(length) * half * rest).to_bits()
    }

    /// Bits of a position relative to the origin, in units of about the scene's size.
    fn relative(&self, position: DVec3) -> [u64; 3] {
        // In two steps, since 2^1074 is no float64.
        let [half, rest] = [self.exponent / 2, self.exponent - self.exponent / 2].map(|part| 2f64.powi(-part));
        (((position - self.origin) * half * rest) + DVec3::ZERO).to_array().map(f64::to_bits)
    }

    /// Returns the id of the `nth` point in a place, counted from 0 in canonical order ([`Points::ids`]).
    #[doc(hidden)]
    pub fn id(&self, position: DVec3, nth: u64) -> u32 {
        id(self.relative(position), nth)
    }
}

/// The median of each coordinate. Points far off, however far, take no digits from the others, as they do from the
/// middle of a box around all.
fn middle(positions: &[DVec3]) -> DVec3 {
    let median = |axis: usize| {
        let mut all: Vec<f64> = positions.iter().map(|position| position[axis]).collect();
        let half = all.len() / 2;
        if all.is_empty() { 0.0 } else { *all.select_nth_unstable_by(half, f64::total_cmp).1 }
    };
    DVec3::new(median(0), median(1), median(2))
}

/// Ids that one thread finds at a time.
const IDS_AT_ONCE: usize = 1 << 14;

/// The id of the `nth` point in a place, counted from 0: all words mixed.
fn id(place: [u64; 3], nth: u64) -> u32 {
    let mixed = mix(place.into_iter().fold(nth, mix), 0);
    (mixed ^ mixed >> 32) as u32
}

/// Returns a unit normal that is estimated, as [`Points::normals`] has it.
#[doc(hidden)]
pub fn as_estimated(normal: Vec3) -> Vec3 {
    2.0 * normal
}

fn is_estimated(normal: Vec3) -> bool {
    normal.length_squared() > 2.0
}

/// Points of a scene that are not drawn: hidden by their class, or cut off. Both columns have the same length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Unseen {
    /// World positions, all finite.
    pub positions: Vec<DVec3>,
    /// World radii.
    pub radii: Vec<f32>,
}

impl Points {
    /// Returns the number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Returns the normal of a point, unless it is none or estimated.
    pub fn own_normal(&self, index: usize) -> Option<Vec3> {
        let normal = self.normals.as_ref().map(|normals| normals[index])?;
        (normal != Vec3::ZERO && !is_estimated(normal)).then_some(normal)
    }

    /// Returns the radius of a disc; `None` for a Gaussian.
    pub fn disc_radius(&self, index: usize) -> Option<f32> {
        let is_disc = self.gaussians.as_ref().is_none_or(|gaussians| !gaussians.is_one(index));
        is_disc.then_some(self.radii[index])
    }

    /// Returns the reach of a Gaussian; `None` for a disc.
    pub fn reach(&self, index: usize) -> Option<f32> {
        let is_one = self.gaussians.as_ref().is_some_and(|gaussians| gaussians.is_one(index));
        is_one.then(|| self.radii[index])
    }

    /// Returns the count and bounds of the Gaussians among all points; `None` if none is one.
    pub fn splats(&self) -> Option<WholeSplats> {
        if let Some(whole) = &self.whole {
            return whole.splats;
        }
        let of = |all: &Gaussians| WholeSplats {
            count: all.count(),
            degree: all.degree,
            brightest: all.brightest()[MAX_DEGREE as usize],
        };
        self.gaussians.as_ref().map(of)
    }

    /// Returns the number of points, those that these stand for included.
    pub fn count(&self) -> u64 {
        self.whole.as_ref().map_or(self.len() as u64, |whole| whole.count)
    }

    /// Returns the scene's box, around points that are not drawn, too; `None` without points.
    pub fn bounds(&self) -> Option<Bounds> {
        if let Some(whole) = &self.whole {
            return Some(whole.bounds);
        }
        [&self.positions, &self.unseen.positions].into_iter().filter_map(|some| Bounds::of(some)).reduce(Bounds::union)
    }

    /// Returns the origin that these points are relative to on a device. It follows from all points of the scene, also
    /// from those that are not drawn.
    pub fn anchor(&self) -> Anchor {
        let sampled: Vec<DVec3> = self.sampled().copied().collect();
        // Points that stand for all may be none where nearly all are in one place.
        let sampled = if sampled.is_empty() { &self.positions } else { &sampled };
        Anchor::new(sampled, self.bounds())
    }

    /// Returns positions of points that stand for all, also for those that are not drawn, in any order.
    pub fn sampled(&self) -> impl ParallelIterator<Item = &DVec3> {
        let sampling = Sampling::of((self.len() + self.unseen.positions.len()) as u64);
        let all = self.positions.par_iter().chain(&self.unseen.positions).with_min_len(1 << 14);
        all.filter(move |position| sampling.takes(**position))
    }

    /// Returns those of [`Self::sampled`] that are drawn.
    pub fn sampled_drawn(&self) -> impl ParallelIterator<Item = &DVec3> {
        let sampling = Sampling::of((self.len() + self.unseen.positions.len()) as u64);
        self.positions.par_iter().with_min_len(1 << 14).filter(move |position| sampling.takes(**position))
    }

    /// Returns the colors of [`Self::sampled_drawn`].
    pub fn sampled_colors(&self) -> impl ParallelIterator<Item = &Vec3> {
        let sampling = Sampling::of((self.len() + self.unseen.positions.len()) as u64);
        let all = self.positions.par_iter().zip(&self.colors).with_min_len(1 << 14);
        all.filter(move |(position, _)| sampling.takes(**position)).map(|(_, color)| color)
    }

    /// Returns the ids of some points of the list: numbers that random words are made from. An id follows from a
    /// point's place and, of points in one place, from their canonical order; not from what else there is, so that any
    /// part of a scene has the ids of the whole. A scene of up to 2¹⁸ points that is moved, or scaled by a power of
    /// two, without a rounding keeps its ids. Two of 2³² points in different places share an id by chance.
    ///
    /// Gaussians in one place are told apart by how far they reach before they are counted: a part of a scene may hold
    /// the large ones alone.
    pub fn ids(&self, anchor: &Anchor, range: Range<usize>) -> Vec<u32> {
        if !self.dealt_ids.is_empty() {
            return self.dealt_ids[range].to_vec();
        }
        let bits = |i: usize| self.positions[i].to_array().map(f64::to_bits);
        let first_there = |i: usize| (0..i).rev().take_while(|before| bits(*before) == bits(i)).last().unwrap_or(i);
        let part = |part: Range<usize>| {
            let mut first = first_there(part.start);
            if self.gaussians.is_some() {
                return self.mixed_ids(anchor, first, part);
            }
            let mut found = Vec::with_capacity(part.len());
            for i in part {
                if bits(i) != bits(first) {
                    first = i;
                }
                found.push(anchor.id(self.positions[i], (i - first) as u64));
            }
            found
        };
        let part = |i: usize| part(range.start + i * IDS_AT_ONCE..range.end.min(range.start + (i + 1) * IDS_AT_ONCE));
        parallel::gather(range.len().div_ceil(IDS_AT_ONCE), part).concat()
    }

    /// Ids of a part of a list with Gaussians. `first`: the first point in the place where the part begins.
    fn mixed_ids(&self, anchor: &Anchor, first: usize, part: Range<usize>) -> Vec<u32> {
        let is_there = |i: usize, other: Option<&DVec3>| {
            other.is_some_and(|other| {
                other.to_array().map(f64::to_bits) == self.positions[i].to_array().map(f64::to_bits)
            })
        };
        let mut counted: HashMap<u64, u64> = HashMap::new();
        let mut found = Vec::with_capacity(part.len());
        for i in first..part.end {
            // Discs are of one kind.
            let kind = self.reach(i).map_or(0, |reach| anchor.relative_length(reach));
            let follows = i > first && is_there(i, self.positions.get(i - 1));
            if !follows {
                counted.clear();
            }
            let mut nth = 0;
            // Most are alone in their place.
            if follows || is_there(i, self.positions.get(i + 1)) {
                let count = counted.entry(kind).or_default();
                nth = *count;
                *count += 1;
            }
            if i >= part.start {
                // The last bits of the kind are 0: it was a float32.
                found.push(anchor.id(self.positions[i], kind.wrapping_add(nth)));
            }
        }
        found
    }

    /// Returns the box of the points that are drawn; `None` without any.
    pub fn drawn_bounds(&self) -> Option<Bounds> {
        Bounds::of(&self.positions)
    }

    /// Returns the positions and radii of all points, those that are not drawn behind the others.
    pub fn spheres(&self) -> impl IndexedParallelIterator<Item = (DVec3, f64)> {
        let unseen = self.unseen.positions.par_iter().zip(&self.unseen.radii);
        let all = self.positions.par_iter().zip(&self.radii).chain(unseen).with_min_len(1 << 12);
        all.map(|(position, radius)| (*position, f64::from(*radius)))
    }

    /// Returns the largest radius of all points, also of those that are not drawn; 0 without points.
    pub fn largest_radius(&self) -> f64 {
        if let Some(whole) = &self.whole {
            return whole.largest_radius.into();
        }
        self.spheres().map(|(_, radius)| radius).reduce(|| 0.0, f64::max)
    }
}

/// Marks the columns of a list of points that changed; positions never do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Changes {
    /// Colors.
    pub colors: bool,
    /// Opacities.
    pub opacities: bool,
    /// Radii.
    pub radii: bool,
    /// The scalar field, or its presence.
    pub fields: bool,
    /// Points of equal position traded places: normals and `file_order` may be others, too.
    pub order: bool,
    /// Radii of points that are not drawn.
    pub unseen: bool,
    /// Shape or color of Gaussians.
    pub gaussians: bool,
}

impl Changes {
    /// All of them.
    pub const ALL: Self =
        Self { colors: true, opacities: true, radii: true, fields: true, order: true, unseen: true, gaussians: true };

    /// Returns the columns that these or others name.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        Self {
            colors: self.colors || more.colors,
            opacities: self.opacities || more.opacities,
            radii: self.radii || more.radii,
            fields: self.fields || more.fields,
            order: self.order || more.order,
            unseen: self.unseen || more.unseen,
            gaussians: self.gaussians || more.gaussians,
        }
    }

    /// Returns `true` if anything changed.
    pub fn any(self) -> bool {
        self != Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::gaussians::{coefficients, reach};

    #[test]
    fn parts_without_normals_get_none() {
        let point = |normals| Points {
            positions: vec![DVec3::ZERO],
            colors: vec![Vec3::ONE],
            opacities: vec![0.5],
            radii: vec![0.0],
            normals,
            ..Points::default()
        };
        let parts = [Arc::new(point(None)), Arc::new(point(Some(vec![Vec3::X])))];
        assert_eq!(Points::gather(&parts, &[[1, 0], [0, 0]]).normals, Some(vec![Vec3::X, Vec3::ZERO]));
    }

    /// Points with Gaussians of these extents; of 0 they are discs.
    fn splats(positions: Vec<DVec3>, extents: &[f32], degree: u32) -> Points {
        let gaussians = Gaussians {
            extents: extents.iter().map(|extent| Vec3::splat(*extent)).collect(),
            harmonics: vec![Vec3::ONE; positions.len() * coefficients(degree)],
            degree,
            ..Gaussians::none(positions.len())
        };
        let radii = gaussians.extents.iter().map(|extents| reach(*extents)).collect();
        Points { positions, radii, gaussians: Some(gaussians), ..Points::default() }
    }

    #[test]
    fn parts_of_several_degrees_and_of_discs_are_gathered() {
        let disc = Points { positions: vec![DVec3::ZERO], radii: vec![1.0], ..Points::default() };
        let parts = [
            Arc::new(splats(vec![DVec3::X; 2], &[1.0, 2.0], 1)),
            Arc::new(disc),
            Arc::new(splats(vec![DVec3::Y], &[3.0], 2)),
        ];
        let all = Points::gather(&parts, &[[2, 0], [1, 0], [0, 1]]).gaussians.unwrap();
        assert_eq!(all.extents, [3.0, 0.0, 2.0].map(Vec3::splat));
        assert_eq!((all.degree, all.harmonics_of(0)), (2, [Vec3::ONE; 8].as_slice()));
        assert_eq!(all.harmonics_of(1), [Vec3::ZERO; 8]);
        assert_eq!(all.harmonics_of(2), [[Vec3::ONE; 3].as_slice(), &[Vec3::ZERO; 5]].concat());
    }

    #[test]
    fn ids_of_gaussians_do_not_depend_on_smaller_ones_and_discs_there() {
        let mut positions: Vec<DVec3> = (0..9).map(|i| DVec3::splat(f64::from(i))).collect();
        positions[2..8].fill(DVec3::splat(2.0));
        let extents = [1.0, 0.0, 2.0, 0.5, 2.0, 0.0, 4.0, 0.0, 1.0];
        let points = splats(positions, &extents, 0);
        let anchor = points.anchor();
        let all = points.ids(&anchor, 0..9);
        let distinct: std::collections::HashSet<u32> = all.iter().copied().collect();
        assert_eq!(distinct.len(), 9);
        assert_eq!((points.ids(&anchor, 4..9), points.ids(&anchor, 5..6)), (all[4..].to_vec(), vec![all[5]]));
        let of = |kept: &[u32]| points.subset(kept, 1.0).ids(&anchor, 0..kept.len());
        assert_eq!(of(&[2, 4, 6]), [all[2], all[4], all[6]], "without small ones and discs");
        assert_eq!(of(&[5, 7, 8]), [all[5], all[7], all[8]], "discs alone");
        // Scaled without a rounding they keep them.
        let half: Vec<DVec3> = points.positions.iter().map(|p| 0.5 * *p).collect();
        let half = splats(half, &extents.map(|extent| 0.5 * extent), 0);
        assert_eq!(half.ids(&half.anchor(), 0..9), all);
    }

    #[test]
    fn another_order_moves_every_column() {
        let count = 40_000;
        let each = |i: usize| i as f32;
        let points = Points {
            positions: (0..count).map(|i| DVec3::splat(i as f64)).collect(),
            colors: (0..count).map(|i| Vec3::splat(each(i))).collect(),
            opacities: vec![0.5; count],
            // Equal as numbers, but not in their bits.
            radii: (0..count).map(|i| if i == 0 { -0.0 } else { 0.0 }).collect(),
            normals: Some(vec![Vec3::Z; count]),
            file_order: (0..count as u32).collect(),
            fields: (0..count).map(each).collect(),
            ..Points::default()
        };
        let turned = points.clone().in_order(|i| count - 1 - i);
        assert_eq!(turned.positions[1], DVec3::splat((count - 2) as f64));
        assert_eq!((turned.colors[1], turned.fields[1]), (Vec3::splat(each(count - 2)), each(count - 2)));
        assert_eq!(turned.file_order[count - 1], 0);
        assert!(turned.radii[count - 1].is_sign_negative() && turned.radii[0].is_sign_positive());
        assert_eq!((&turned.opacities, &turned.normals), (&points.opacities, &points.normals));
        assert!(turned.dealt_ids.is_empty());
    }

    #[test]
    fn ids_follow_from_places_and_tell_equal_ones_apart() {
        let mut positions: Vec<DVec3> = (0..50_000).map(|i| DVec3::new(f64::from(i), 0.5, -1.0)).collect();
        positions[20_000..40_000].fill(DVec3::splat(7.0));
        let points = Points { positions: positions.clone(), ..Points::default() };
        let anchor = points.anchor();
        let all = points.ids(&anchor, 0..50_000);
        let mut distinct = all.clone();
        distinct.sort_unstable();
        distinct.dedup();
        // 2^-32 of 50,000 squared halves: about a third of a pair by chance.
        assert!(distinct.len() >= 49_998, "{}", distinct.len());
        // Wherever a range begins, and whatever else there is.
        assert_eq!(points.ids(&anchor, 33_333..44_444), all[33_333..44_444]);
        let few = Points { positions: positions[20_000..].to_vec(), ..Points::default() };
        assert_eq!(few.ids(&anchor, 0..30_000), all[20_000..]);
        // Moved and scaled without a rounding they keep them.
        let moved = |p: &DVec3| 1024.0 * (*p + DVec3::new(4096.0, -512.0, 0.25));
        let moved = Points { positions: positions.iter().map(moved).collect(), ..Points::default() };
        assert_eq!(moved.ids(&moved.anchor(), 0..50_000), all);
        // Every bit is set in half of them.
        for bit in 0..32 {
            let set = all.iter().filter(|id| *id >> bit & 1 == 1).count();
            assert!((24_000..26_000).contains(&set), "bit {bit}: {set}");
        }
    }
}
