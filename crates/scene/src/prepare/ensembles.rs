//! Points in the order in which they are partitioned into ensembles (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! Each cloud's points are in random order, one cloud after the other. M = round(kN) copies of a cloud's N points are
//! dealt to L ensembles, ⌊(e+1)M/L⌋ − ⌊eM/L⌋ to ensemble e, so that sizes differ by at most one. No copy is stored.
//!
//! Ensembles of the first pass take the points one after the other; for k ≤ 1 this is the only pass, and the points
//! left out are random. Each later pass deals some of the points once more, in other hands ([`PassRows`]). In the same
//! order its ensembles would repeat those of the first pass, and the noise would remain that of L/k ensembles. No
//! ensemble holds a point twice, since M/L ≤ N.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use pellucid_core::progress::Progress;
use rayon::prelude::*;

use super::ties::Ties;
use super::{density, order};
use pellucid_core::parallel;
use pellucid_core::points::Points;
use pellucid_core::random::{key, threefry2x32};

/// Domain separator of the random words that shuffle, so that they are independent of those that decide what is drawn.
const SHUFFLE: u32 = 0x7368_7566;

/// Properties of one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudSurface {
    /// The range of its points in the list.
    pub points: Range<u64>,
    /// Middle of the box of its points, in world coordinates: where a point is one pixel wide.
    pub center: DVec3,
    /// Points for each unit of a surface's area (world units squared), by counting spheres (Tanaka et al. 2016, Section
    /// 3.2.1, less its biases: rims, the spheres' own centers). 0 if the points are too few to tell or all in one
    /// place.
    pub density: f64,
    /// Largest opacity α of its points, in [0, 1]: that of its surface.
    pub opacity: f32,
}

/// Points in random order, cloud after cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dealt {
    /// All points; shared with what renders them, which may have no room for all of them at once.
    pub points: Arc<Points>,
    /// The clouds, in the order of their points.
    pub surfaces: Vec<CloudSurface>,
}

/// Returns the copies of ensemble `ensemble` of `ensembles`, if `slots` copies are dealt in all, one ensemble behind
/// the other.
pub fn slots(slots: u64, ensembles: u32, ensemble: u32) -> Range<u64> {
    let bound = |e: u64| (u128::from(slots) * u128::from(e) / u128::from(ensembles)) as u64;
    bound(u64::from(ensemble))..bound(u64::from(ensemble) + 1)
}

/// The partition into ensembles of a cloud's points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Deal {
    /// N, at least 1.
    pub points: u64,
    /// M, at most NL.
    pub slots: u64,
    /// L, at least 1.
    pub ensembles: u32,
    /// The cloud's place among the others.
    pub place: u32,
    /// The seed of later passes.
    pub seed: u64,
}

/// Ensembles to which points are assigned but once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pass {
    /// Range of ensembles.
    pub ensembles: Range<u32>,
    /// The positions of their points; `None` for the first pass, whose n-th copy is the n-th point.
    pub rows: Option<PassRows>,
}

/// Points of a later pass: rows of blocks. Every ensemble takes one block of each row: in row i, the h-th ensemble of
/// the pass takes the block h places after a random one, cyclically. Blocks are consecutive points, for coherent memory
/// access; a hand has enough blocks to be a random part of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PassRows {
    /// The first point of the first row, at random; behind the cloud's last point comes its first.
    pub first: u64,
    /// N.
    pub points: u64,
    /// Rows.
    pub count: u64,
    /// Blocks of a row.
    pub columns: u32,
    /// Binary logarithm of the points of a block.
    pub block_bits: u32,
    /// A number that distinguishes the pass from others.
    pub word: u32,
}

/// Told apart from others, the words of later passes.
const AGAIN: u32 = 0x6167_6169;
/// Least blocks of a hand, where it has as many points, and most points of a block.
const LEAST_BLOCKS: u64 = 64;
const MOST_BLOCK_BITS: u32 = 10;
/// Largest number of points of a row, and of the rows of hands of at most that size, that any device can bind.
const MOST_OF_ROW: u64 = 1 << 15;
const MOST_OF_ROWS: u64 = 1 << 22;

impl Deal {
    /// Returns the copies of an ensemble.
    pub fn slots(&self, ensemble: u32) -> Range<u64> {
        slots(self.slots, self.ensembles, ensemble)
    }

    /// Returns the pass of an ensemble.
    pub fn pass(&self, ensemble: u32) -> Pass {
        // ⌊eM/L⌋ ≤ N.
        let within = ((u128::from(self.points) + 1) * u128::from(self.ensembles) - 1) / u128::from(self.slots.max(1));
        let first = within.min(u128::from(self.ensembles)) as u32;
        if ensemble < first {
            return Pass { ensembles: 0..first, rows: None };
        }
        let mut rows = self.rows();
        let pass = (ensemble - first) / rows.columns;
        let [low, high] = key(self.seed);
        let [word, place] = threefry2x32([pass, self.place], [low, high ^ AGAIN]);
        rows.first = ((u128::from(place) * u128::from(self.points)) >> 32) as u64;
        rows.word = word;
        let start = first + pass * rows.columns;
        Pass { ensembles: start..start.saturating_add(rows.columns).min(self.ensembles), rows: Some(rows) }
    }

    /// The rows of a pass, wherever they begin.
    fn rows(&self) -> PassRows {
        let hand = self.slots.div_ceil(u64::from(self.ensembles)).max(1);
        let bits = (hand / LEAST_BLOCKS).max(1).ilog2().min(MOST_BLOCK_BITS);
        // Whole blocks may need more points than exist.
        let block_bits = if hand.div_ceil(1 << bits) << bits <= self.points { bits } else { 0 };
        let count = hand.div_ceil(1 << block_bits);
        let columns = (self.points.min(MOST_OF_ROWS) / (count << block_bits)).clamp(1, MOST_OF_ROW >> block_bits);
        PassRows { first: 0, points: self.points, count, columns: columns as u32, block_bits, word: 0 }
    }

    /// Returns the points of an ensemble, counted from the cloud's first.
    pub fn hand(&self, ensemble: u32) -> Vec<u64> {
        let (slots, pass) = (self.slots(ensemble), self.pass(ensemble));
        match pass.rows {
            None => slots.collect(),
            Some(rows) => {
                (0..slots.end - slots.start).map(|n| rows.point(ensemble - pass.ensembles.start, n)).collect()
            }
        }
    }
}

impl PassRows {
    /// Returns the number of points of all rows.
    pub fn len(&self) -> u64 {
        (self.count * u64::from(self.columns)) << self.block_bits
    }

    /// Returns `true` if there are no rows: never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the n-th point of the pass's h-th ensemble.
    pub fn point(&self, hand: u32, n: u64) -> u64 {
        let row = n >> self.block_bits;
        let turn = (scrambled(self.word.wrapping_add((row as u32).wrapping_mul(0x9E37_79B9))) >> 10) % self.columns;
        let column = (u64::from(hand) + u64::from(turn)) % u64::from(self.columns);
        let block = row * u64::from(self.columns) + column;
        let along = self.first + (block << self.block_bits) + (n & ((1 << self.block_bits) - 1));
        along - if along < self.points { 0 } else { self.points }
    }
}

/// A bijection whose bits all depend on all others (C. Wellons, "Prospecting for Hash Functions", 2018: lowbias32).
fn scrambled(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7FEB_352D);
    x = (x ^ x >> 15).wrapping_mul(0x846C_A68B);
    x ^ x >> 16
}

/// Puts each cloud into canonical order, shuffles it by the seed, computes its density, and concatenates the clouds.
/// Clouds without points are left out.
///
/// The order of a cloud's points in its file has no effect; its place among the others has. Point i of the canonical
/// order is sorted by its words: those of [`threefry2x32`] with counter \[id of the point ([`Points::ids`]), place of
/// the cloud\] and the seed's key, the second word of it exclusive-or 0x73687566; equal words stay in order. So a seed
/// gives the same shuffle on every machine, and any part of a cloud has the order of the whole. `progress` counts
/// points, each of them twice.
pub fn deal(clouds: Vec<Points>, seed: u64, progress: &Progress) -> Dealt {
    deal_traced(clouds, seed, progress, None)
}

/// The origins of the points of a shuffled list.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Trace {
    /// Number of the point at each place in the input: cloud after cloud, in their order.
    pub origins: Vec<u32>,
    /// Places of points in the same place, cloud by cloud.
    pub ties: Ties,
}

impl Trace {
    /// Adds a cloud in canonical order, whose place i gets the point that `order[i]` is there.
    fn note(&mut self, canonical: &Points, order: &[u32]) {
        let first = self.origins.len() as u32;
        self.origins.extend(order.iter().map(|from| first + canonical.file_order[*from as usize]));
        let ties = Ties::find(&canonical.positions);
        if !ties.is_empty() {
            let mut places = vec![0; order.len()];
            (first..).zip(order).for_each(|(place, from)| places[*from as usize] = place);
            self.ties.extend(&ties, |from| places[from as usize]);
        }
    }
}

/// Shuffles points like [`deal`], and records the origins of points if `trace` is given.
pub(crate) fn deal_traced(clouds: Vec<Points>, seed: u64, progress: &Progress, mut trace: Option<&mut Trace>) -> Dealt {
    progress.set_length(clouds.iter().map(|cloud| 2 * cloud.len() as u64).sum());
    let (mut points, mut surfaces) = (Points::default(), Vec::new());
    for cloud in clouds {
        let Some(bounds) = cloud.drawn_bounds() else {
            // It may have points that are not drawn.
            points.append(cloud);
            continue;
        };
        let place = surfaces.len() as u32;
        let cloud = order::canonical(cloud);
        let ids = cloud.ids(&cloud.anchor(), 0..cloud.len());
        let order = shuffle(&ids, place, seed);
        if let Some(trace) = &mut trace {
            trace.note(&cloud, &order);
        }
        let cloud = shuffled(cloud, ids, &order);
        drop(order);
        progress.inc(cloud.len() as u64);
        let first = points.len() as u64;
        surfaces.push(CloudSurface {
            points: first..first + cloud.len() as u64,
            center: bounds.center(),
            density: density::estimate(&cloud.positions, progress),
            opacity: most(&cloud.opacities),
        });
        points.append(cloud);
    }
    Dealt { points: Arc::new(points), surfaces }
}

fn most(opacities: &[f32]) -> f32 {
    opacities.iter().copied().fold(0.0, f32::max)
}

fn shuffled(mut cloud: Points, ids: Vec<u32>, order: &[u32]) -> Points {
    // Random order knows no files.
    cloud.file_order = Vec::new();
    cloud.dealt_ids = ids;
    cloud.in_order(|i| order[i] as usize)
}

/// The words by which a cloud's points are shuffled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shuffle {
    place: u32,
    key: [u32; 2],
}

impl Shuffle {
    /// Returns those of the cloud at a place among the others.
    pub fn new(place: u32, seed: u64) -> Self {
        let [low, high] = key(seed);
        Self { place, key: [low, high ^ SHUFFLE] }
    }

    /// Returns the word of a point, by its id: another one for each.
    pub fn word(self, id: u32) -> u64 {
        let [first, second] = threefry2x32([id, self.place], self.key);
        u64::from(first) << 32 | u64::from(second)
    }
}

/// Returns the point to put at each place of a cloud, from the points' ids.
fn shuffle(ids: &[u32], place: u32, seed: u64) -> Vec<u32> {
    let shuffle = Shuffle::new(place, seed);
    // Points are counted in 32 bits: more of them don't fit any device.
    let mut order: Vec<(u64, u32)> = parallel::map(ids.len(), |i| (shuffle.word(ids[i]), i as u32));
    order.par_sort_unstable();
    order.into_iter().map(|(_, index)| index).collect()
}

impl Dealt {
    /// Takes the opacities of the points for those of their clouds.
    pub(crate) fn renew_opacities(&mut self) {
        for surface in &mut self.surfaces {
            surface.opacity = most(&self.points.opacities[surface.points.start as usize..surface.points.end as usize]);
        }
    }

    /// Returns the same clouds, each shuffled once more by another seed: as good an order as this one, with other
    /// ensembles.
    pub fn again(&self, seed: u64) -> Self {
        let shuffled = |(surface, place): (&CloudSurface, u32)| {
            let [first, end] = [surface.points.start, surface.points.end].map(|point| point as usize);
            shuffle(&self.points.dealt_ids[first..end], place, seed)
                .into_iter()
                .map(move |index| first + index as usize)
        };
        let order: Vec<usize> = self.surfaces.iter().zip(0..).flat_map(shuffled).collect();
        let points = Points::clone(&self.points).in_order(|i| order[i]);
        Self { points: Arc::new(points), surfaces: self.surfaces.clone() }
    }
}
