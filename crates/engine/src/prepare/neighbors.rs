//! The nearest neighbors of every point, independent of the order of the points.
//!
//! The K nearest other points, without the point itself, are ordered by distance, computed in float64 from the original
//! positions; equal distances by x, then y, then z; equal positions by normal (up to its sign). The first K of that
//! order count, so that shuffled points have the same neighbors, in the same sequence, to the bit.

use std::num::NonZero;
use std::ops::Range;

use crate::progress::Progress;
use glam::{DMat3, DQuat, DVec3, Vec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::morton;
use crate::cloud::Bounds;

/// Places between two steps of the progress bar.
const BLOCK: usize = 1 << 12;

/// Places asked of the tree beyond those needed: mostly enough to see that no other is as near as the last one needed.
const SPARE: usize = 4;

/// Lists of neighbors above this are not kept but found again when they are needed a second time.
const MAX_LIST_BYTES: usize = 2 << 30;

/// The frame of the tree's coordinates: centred on the cloud, rotated, and of about unit size.
struct Frame {
    center: DVec3,
    /// World units per unit of the tree; a power of two, so that scaling rounds nothing.
    unit: f64,
    /// Turns lines and planes along the axes, where all points share a coordinate and a k-d tree has nothing to split.
    turn: DMat3,
}

impl Frame {
    fn around(bounds: &Bounds) -> Self {
        let half_side = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
        // Keeps squared distances of any float64 cloud away from overflow and underflow.
        let unit = if half_side > 0.0 { half_side.log2().floor().clamp(-1022.0, 1023.0).exp2() } else { 1.0 };
        // Any rotation without a simple angle to an axis does.
        let turn = DMat3::from_quat(DQuat::from_xyzw(0.31, -0.47, 0.23, 0.79).normalize());
        Self { center: bounds.center(), unit, turn }
    }

    fn local(&self, p: DVec3) -> [f64; 3] {
        (self.turn * ((p - self.center) / self.unit)).to_array()
    }
}

/// Widens a squared distance to the tree's coordinates, so that it covers everything within `squared` of the original
/// positions: rotation rounds coordinates of up to 4 by some 10⁻¹⁵.
fn widened(squared: f64) -> f64 {
    let distance = squared.sqrt() * (1.0 + 1e-12) + 1e-13;
    distance * distance
}

/// The distinct positions of a cloud and the points at each: a k-d tree handles a thousand equal points badly.
///
/// Points have ranks: place by place in Morton order, so that consecutive queries touch the same leaves, and by normal
/// within a place.
pub(super) struct Places {
    /// The index in the cloud, by rank.
    pub order: Vec<usize>,
    /// Positions by rank.
    pub positions: Vec<DVec3>,
    /// For each place its first rank, with their number as the last entry.
    starts: Vec<u32>,
    /// Finds places.
    tree: ImmutableKdTree<f64, 3>,
    frame: Frame,
}

/// The bits of a position, the two zeros being one.
fn position_key(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Integers in the order of a normal's coordinates, the same for both of its directions.
fn normal_key(normal: Vec3) -> [i32; 3] {
    let first = normal.to_array().into_iter().find(|x| *x != 0.0).unwrap_or_default();
    let normal = if first < 0.0 { -normal } else { normal };
    // In the order of `f32::total_cmp`.
    (normal + Vec3::ZERO).to_array().map(|x| {
        let bits = x.to_bits() as i32;
        bits ^ (((bits >> 31) as u32) >> 1) as i32
    })
}

impl Places {
    /// From finite positions; `None` if there are none, or 2³² and more, of which no renderer takes as many, either.
    pub fn group(positions: &[DVec3], normals: Option<&[Vec3]>) -> Option<Self> {
        // Ranks, and the places of the tree, have 32 bits.
        u32::try_from(positions.len()).ok()?;
        let bounds = Bounds::enclosing(positions.iter().copied())?;
        let frame = Frame::around(&bounds);
        let codes = morton::codes(positions, &bounds);
        let normal = |i: usize| normals.map_or([0; 3], |normals| normal_key(normals[i]));
        let mut keyed: Vec<(u64, usize)> = codes.into_par_iter().zip(0..positions.len()).collect();
        keyed.par_sort_unstable_by(|&(a_code, a), &(b_code, b)| {
            let by_position = || position_key(positions[a]).cmp(&position_key(positions[b]));
            a_code.cmp(&b_code).then_with(by_position).then_with(|| normal(a).cmp(&normal(b)))
        });
        let order: Vec<usize> = keyed.into_iter().map(|(_, index)| index).collect();
        let positions: Vec<DVec3> = order.iter().map(|&index| positions[index]).collect();

        let mut points = Vec::new();
        let mut starts = vec![0];
        for run in positions.chunk_by(|a, b| a == b) {
            points.push(frame.local(run[0]));
            starts.push(starts[points.len() - 1] + run.len() as u32);
        }
        let tree = ImmutableKdTree::<f64, 3>::new_from_slice(&points).ok()?;
        Some(Self { order, positions, starts, tree, frame })
    }

    /// Number of distinct positions.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The ranks of the points at a place.
    pub fn members(&self, place: usize) -> Range<usize> {
        self.starts[place] as usize..self.starts[place + 1] as usize
    }

    /// The place of the point of a rank.
    pub fn place_of(&self, rank: u32) -> usize {
        self.starts.partition_point(|start| *start <= rank) - 1
    }

    /// World units in which distances are given; a power of two.
    pub fn unit(&self) -> f64 {
        self.frame.unit
    }

    fn position(&self, place: usize) -> DVec3 {
        self.positions[self.starts[place] as usize]
    }

    /// The number of the `k` nearest others of a point at `place` that have another position: 0 if `k` others share
    /// this one.
    fn elsewhere(&self, place: usize, k: usize) -> usize {
        (k + 1).saturating_sub(self.members(place).len())
    }

    /// The ranks of those of the `k` nearest others of a point at `place` that have another position, in their order,
    /// and the distance of the last in [`Places::unit`]s.
    pub fn others(&self, place: usize, k: usize) -> (Vec<u32>, f64) {
        let wanted = self.elsewhere(place, k);
        if wanted == 0 {
            return (Vec::new(), 0.0);
        }
        let here = self.frame.local(self.position(place));
        // Each place found has at least one point; the first is this one.
        let asked = NonZero::<usize>::MIN.saturating_add(wanted + SPARE);
        let near = self.tree.query(&here).nearest_n::<SquaredEuclidean<f64>>(asked).execute();
        let exhausted = near.len() < asked.get();
        let seen = near.last().map_or(0.0, |last| last.distance);
        let mut places = self.sorted(place, near.into_iter().map(|near| near.item as usize));
        let reach = widened(self.distance_of_last(&places, wanted));
        if !exhausted && seen <= reach {
            let near = self.tree.query(&here).within::<SquaredEuclidean<f64>>(reach).execute();
            places = self.sorted(place, near.into_iter().map(|near| near.item as usize));
        }
        let distance = self.distance_of_last(&places, wanted).sqrt();
        let ranks = places.into_iter().flat_map(|(_, place)| self.members(place)).take(wanted);
        (ranks.map(|rank| rank as u32).collect(), distance)
    }

    /// Places with their squared distances from `place`, itself left out, in the order of neighbors.
    fn sorted(&self, place: usize, found: impl Iterator<Item = usize>) -> Vec<(f64, usize)> {
        let here = self.position(place);
        let squared = |there: usize| ((self.position(there) - here) / self.frame.unit).length_squared();
        let mut places: Vec<(f64, usize)> =
            found.filter(|&there| there != place).map(|there| (squared(there), there)).collect();
        places.sort_unstable_by(|a, b| {
            let coordinates = |place: usize| (self.position(place) + DVec3::ZERO).to_array();
            let by_position = || {
                let [a, b] = [coordinates(a.1), coordinates(b.1)];
                a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
            };
            a.0.total_cmp(&b.0).then_with(by_position)
        });
        places
    }

    /// The squared distance of the place that contains the last of `wanted` points.
    fn distance_of_last(&self, places: &[(f64, usize)], wanted: usize) -> f64 {
        let mut found = 0;
        let last = places.iter().find(|(_, place)| {
            found += self.members(*place).len();
            found >= wanted
        });
        last.map_or(0.0, |(squared, _)| *squared)
    }

    /// Calls `see` for each place with [`Places::others`], on all cores, and keeps what it returns. `again`: the lists are
    /// kept for a second visit, if memory allows.
    pub fn visit<T: Send>(
        &self,
        k: usize,
        again: bool,
        progress: &Progress,
        see: impl Fn(usize, &[u32], f64) -> T + Sync,
    ) -> (Vec<T>, Lists) {
        progress.set_length(self.len() as u64);
        let keep = again && self.len().saturating_mul(4 * k) <= MAX_LIST_BYTES;
        let blocks: Vec<(Vec<T>, Vec<u32>)> = (0..self.len().div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let places = block * BLOCK..((block + 1) * BLOCK).min(self.len());
                let mut kept = Vec::with_capacity(if keep { places.len() * k } else { 0 });
                let mut seen = Vec::with_capacity(places.len());
                for place in places.clone() {
                    let (others, distance) = self.others(place, k);
                    seen.push(see(place, &others, distance));
                    if keep {
                        kept.extend_from_slice(&others);
                        kept.resize((place + 1 - places.start) * k, 0);
                    }
                }
                progress.inc(places.len() as u64);
                (seen, kept)
            })
            .collect();
        let (seen, kept): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
        (seen.into_iter().flatten().collect(), Lists { k, kept: keep.then_some(kept) })
    }
}

/// The neighbors elsewhere of all places, if they were kept.
pub(super) struct Lists {
    k: usize,
    /// By block of places, `k` entries per place.
    kept: Option<Vec<Vec<u32>>>,
}

impl Lists {
    /// Hands those of a place to `see`.
    pub fn others<T>(&self, places: &Places, place: usize, see: impl FnOnce(&[u32]) -> T) -> T {
        match &self.kept {
            Some(kept) => {
                let from = place % BLOCK * self.k;
                see(&kept[place / BLOCK][from..from + places.elsewhere(place, self.k)])
            }
            None => see(&places.others(place, self.k).0),
        }
    }
}
