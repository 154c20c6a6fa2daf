//! Points in the order that ensembles are dealt from (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! Each cloud's points stand in random order, one cloud behind the other. The copies of a cloud's points are the slots
//! 0, 1, 2, … of an endless list that repeats its points in this order: slot m is point m mod N. Of these the first
//! M = round(kN) are dealt: ensemble e of L takes slots ⌊eM/L⌋ to ⌊(e+1)M/L⌋. So no copy is stored, the sizes of ensembles
//! differ by at most one, for k < 1 the points left out are random, and while k ≤ L no ensemble holds a point twice, since
//! its copies are N slots apart and an ensemble has M/L ≤ N of them.
//!
//! For k > 1 the list is gone through again in the same order, so that ensembles N slots apart have much the same points, and
//! noise stays about that of L/k ensembles. Ensembles of other parts of the points would have little less of it: how many
//! points lie on a pixel is left to chance anyway. (The variance is α(1 − α)k/L against about α(1 − α)/L + (1 − α)²mk/L with
//! m = −ln(1 − α): for k = 10 no more at α = 0.2, a quarter more at 0.5, 2.8 times as much at 0.9.)

use std::ops::Range;

use glam::DVec3;
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::{density, order};
use crate::points::Points;
use crate::random::{key, threefry2x32};

/// Told apart from it, the words that shuffle have nothing to do with those that decide what is drawn.
const SHUFFLE: u32 = 0x7368_7566;

/// What is known of one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Where its points stand in the list.
    pub points: Range<u64>,
    /// Middle of the box of its points, in world coordinates: where a point is one pixel wide.
    pub center: DVec3,
    /// Points for each unit of a surface's area (world units squared), by counting spheres (Tanaka et al. 2016, Section
    /// 3.2.1, less its biases: rims, the spheres' own centres). 0 if the points are too few to tell or all in one place.
    pub density: f64,
    /// Largest opacity α of its points, in [0, 1]: that of its surface.
    pub opacity: f32,
}

/// Points in random order, cloud after cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dealt {
    /// All points.
    pub points: Points,
    /// The clouds, in the order of their points.
    pub surfaces: Vec<Surface>,
}

/// The slots of ensemble `ensemble` of `ensembles`, if `slots` are dealt in all.
pub fn slots(slots: u64, ensembles: u32, ensemble: u32) -> Range<u64> {
    let bound = |e: u64| (u128::from(slots) * u128::from(e) / u128::from(ensembles)) as u64;
    bound(u64::from(ensemble))..bound(u64::from(ensemble) + 1)
}

/// Puts each cloud into canonical order, shuffles it by the seed, finds its density, and puts one behind the other. Clouds
/// without points are left out.
///
/// The order of a cloud's points in its file has no effect; its place among the others has. Point i of the canonical order
/// goes behind all those with smaller words, the first of [`threefry2x32`] with counter \[i, place of the cloud\] and the
/// seed's key, the second word of it exclusive-or 0x73687566; equal words stay in order. So a seed gives the same shuffle on
/// every machine. `progress` counts points, each of them twice.
pub fn deal(clouds: Vec<Points>, seed: u64, progress: &ProgressBar) -> Dealt {
    progress.set_length(clouds.iter().map(|cloud| 2 * cloud.len() as u64).sum());
    let mut dealt = Dealt::default();
    for cloud in clouds {
        let Some(bounds) = cloud.bounds() else { continue };
        let place = dealt.surfaces.len() as u32;
        let cloud = shuffled(order::canonical(cloud), place, seed);
        progress.inc(cloud.len() as u64);
        let first = dealt.points.len() as u64;
        dealt.surfaces.push(Surface {
            points: first..first + cloud.len() as u64,
            center: bounds.center(),
            density: density::estimate(&cloud.positions, progress),
            opacity: cloud.opacities.iter().copied().fold(0.0, f32::max),
        });
        dealt.points.append(cloud);
    }
    dealt
}

fn shuffled(mut cloud: Points, place: u32, seed: u64) -> Points {
    // Random order knows no files.
    cloud.file_order = Vec::new();
    let order = shuffle(cloud.len(), place, seed);
    cloud.in_order(|i| order[i] as usize)
}

/// For each place of a cloud the point that comes there.
fn shuffle(count: usize, place: u32, seed: u64) -> Vec<u32> {
    let [low, high] = key(seed);
    let word = |i: u32| threefry2x32([i, place], [low, high ^ SHUFFLE])[0];
    // Points are counted in 32 bits: more of them don't fit any device.
    let mut order: Vec<(u32, u32)> = (0..count).into_par_iter().map(|i| (word(i as u32), i as u32)).collect();
    order.par_sort_unstable();
    order.into_iter().map(|(_, index)| index).collect()
}

impl Dealt {
    /// The same clouds, each shuffled once more by another seed: as good an order as this one, with other ensembles.
    pub fn again(&self, seed: u64) -> Self {
        let of = |(surface, place): (&Surface, u32)| {
            let first = surface.points.start;
            let count = (surface.points.end - first) as usize;
            shuffle(count, place, seed).into_iter().map(move |index| first as usize + index as usize)
        };
        let order: Vec<usize> = self.surfaces.iter().zip(0..).flat_map(of).collect();
        Self { points: self.points.clone().in_order(|i| order[i]), surfaces: self.surfaces.clone() }
    }
}
