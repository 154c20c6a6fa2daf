//! The radius of each point from its neighbors (Seemann et al., Eq. 20, corrected).
//!
//! As printed, Eq. 20 takes the root of a length; scaling a cloud by 1000 must scale its radii by 1000, so the squared
//! distance belongs under the root: r = 2·sqrt(max|pᵢ−pⱼ|² / K) = 2·max|pᵢ−pⱼ| / sqrt(K).

use std::num::NonZero;

use glam::{DMat3, DQuat, DVec3};
use indicatif::ProgressBar;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::morton;
use crate::cloud::Bounds;

/// Queries between two steps of the progress bar.
const BLOCK: usize = 1 << 12;

/// The radius of each finite position by Eq. 20 over its `neighbors` (K) nearest other points.
///
/// With fewer than K other points K is their number; a single point has radius 0, and so has a point with at least K
/// others in the same place. Distances are float64 of the positions as given. Radii beyond float32 become `f32::MAX`. The bar's length is set to the number of distinct places.
pub fn estimate(positions: &[DVec3], neighbors: usize, progress: &ProgressBar) -> Vec<f32> {
    let others = positions.len().saturating_sub(1);
    let k = neighbors.min(others);
    let Some(bounds) = Bounds::of(positions.iter().copied()).filter(|_| k > 0) else {
        return vec![0.0; positions.len()];
    };
    let frame = Frame::of(&bounds);
    let places = Places::of(positions, &bounds, &frame);
    progress.set_length(places.points.len() as u64);
    let farthest = places.farthest_neighbor(k, progress);
    let factor = 2.0 / (k as f64).sqrt();
    let mut radii = vec![0.0; positions.len()];
    for (members, far) in places.members.iter().zip(farthest) {
        let (here, there) = (positions[places.order[members.start]], positions[places.order[far]]);
        // From the positions as given: next to a far outlier the tree's own coordinates have lost some digits.
        let distance = ((there - here) / frame.unit).length() * frame.unit;
        let radius = ((factor * distance) as f32).min(f32::MAX);
        for &index in &places.order[members.clone()] {
            radii[index] = radius;
        }
    }
    radii
}

/// Where the tree's coordinates lie: around the cloud's centre, turned, and of about unit size.
struct Frame {
    center: DVec3,
    /// World units per unit of the tree; a power of two, so that scaling rounds nothing.
    unit: f64,
    /// Turns lines and planes along the axes, where all points share a coordinate and a k-d tree has nothing to split.
    turn: DMat3,
}

impl Frame {
    fn of(bounds: &Bounds) -> Self {
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

/// The distinct positions of a cloud and who stands there: a k-d tree doesn't like a thousand equal points.
struct Places {
    /// One point per place, in Morton order, so that consecutive queries touch the same leaves.
    points: Vec<[f64; 3]>,
    /// For each place its range of `order`.
    members: Vec<std::ops::Range<usize>>,
    /// Indices into the cloud, place by place.
    order: Vec<usize>,
}

impl Places {
    fn of(positions: &[DVec3], bounds: &Bounds, frame: &Frame) -> Self {
        let codes = morton::codes(positions, bounds);
        // Adding 0 makes the two zeros one.
        let key = |i: usize| (positions[i] + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut keyed: Vec<(u64, usize)> = codes.into_par_iter().zip(0..positions.len()).collect();
        keyed.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| key(a.1).cmp(&key(b.1))));
        let order: Vec<usize> = keyed.into_iter().map(|(_, index)| index).collect();

        let mut points = Vec::new();
        let mut members = Vec::new();
        let mut start = 0;
        for run in order.chunk_by(|&a, &b| positions[a] == positions[b]) {
            points.push(frame.local(positions[run[0]]));
            members.push(start..start + run.len());
            start += run.len();
        }
        Self { points, members, order }
    }

    /// For each place, where in `order` the k-th nearest other point of one of its points stands.
    fn farthest_neighbor(&self, k: usize, progress: &ProgressBar) -> Vec<usize> {
        // Fails only for more than 2³² points, which no cloud in memory has.
        let Ok(tree) = ImmutableKdTree::<f64, 3>::new_from_slice(&self.points) else {
            unreachable!("the k-d tree's 32-bit indices hold every cloud");
        };
        // The time left is that of the queries, not of building the tree.
        progress.reset_eta();
        let search = |place: usize| {
            let here = self.members[place].clone();
            if here.len() > k {
                return here.start;
            }
            // Each place found stands for at least one point, the first for all that are here.
            let wanted = NonZero::<usize>::MIN.saturating_add(k + 1 - here.len());
            let mut found = 0;
            tree.query(&self.points[place])
                .nearest_n::<SquaredEuclidean<f64>>(wanted)
                .execute()
                .into_iter()
                .map(|near| self.members[near.item as usize].clone())
                .find(|there| {
                    found += there.len();
                    found > k
                })
                .map_or(here.start, |there| there.start)
        };
        let places: Vec<usize> = (0..self.points.len()).collect();
        places
            .par_chunks(BLOCK)
            .flat_map_iter(|block| {
                let farthest: Vec<usize> = block.iter().map(|&place| search(place)).collect();
                progress.inc(block.len() as u64);
                farthest
            })
            .collect()
    }
}
