//! Points that stand apart: statistical outlier removal, as in the Point Cloud Library (Rusu et al. 2008).

use glam::DVec3;
use pellucid_core::progress::Progress;
use rayon::prelude::*;

use super::neighbors::Places;

/// Differences of mean distances below this share of their mean are rounding.
const LEAST_DIFFERENCE: f64 = 1e-9;

/// Multiple of a limit, found without the outliers so far, beyond which points are outliers that these masked.
const MASKED: f64 = 10.0;

/// Rule that tells which points are outliers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// Neighbors that a point's mean distance is taken over, at least 1.
    pub k: usize,
    /// Standard deviations above the mean from which a point is an outlier, at least 0.
    pub factor: f32,
}

/// Marks the outliers among finite positions: those whose mean distance to their `k` nearest other points exceeds mean
/// + factor · standard deviation of these distances over the cloud. The deviation is that of a sample (n − 1).
///
/// Outliers that are very far away raise the limit above nearer ones. So the limit is found again without those beyond
/// it, and points beyond ten times that one are outliers as well, until there are none.
///
/// With fewer than k other points k is their number. Sums follow an order by position, so that shuffled points have the
/// same outliers. Distances that differ only by rounding make none.
pub fn find(positions: &[DVec3], rule: Rule, progress: &Progress) -> Vec<bool> {
    let k = rule.k.min(positions.len().saturating_sub(1));
    let Some(places) = Places::group(positions, None).filter(|_| k > 0) else {
        return vec![false; positions.len()];
    };
    let distances = places.visit(k, progress, |place, others, _| mean_distance(&places, place, others, k));
    let factor = f64::from(rule.factor);
    let mut most = limit(&places, &distances, factor, f64::INFINITY);
    // Until the nearer ones are found, too.
    loop {
        let next = MASKED * limit(&places, &distances, factor, most);
        if !distances.iter().any(|distance| next < *distance && *distance <= most) {
            break;
        }
        most = next;
    }
    let mut marks = vec![false; positions.len()];
    for place in (0..places.len()).filter(|&place| distances[place] > most) {
        places.members(place).for_each(|rank| marks[places.index(rank)] = true);
    }
    marks
}

/// The mean distance of a point at a place to its `k` nearest others; those in the same place have distance 0.
fn mean_distance(places: &Places, place: usize, others: &[u32], k: usize) -> f64 {
    let here = places.position(place);
    let distance = |&rank: &u32| (places.position(places.place_of(rank)) - here).length();
    others.iter().map(distance).sum::<f64>() / k as f64
}

/// The distance above which a point is an outlier, of those with `most` at most. Each point of a place counts.
fn limit(places: &Places, distances: &[f64], factor: f64, most: f64) -> f64 {
    let sum = |value: &dyn Fn(f64) -> f64| -> f64 {
        let each = distances.iter().enumerate().filter(|(_, distance)| **distance <= most);
        each.map(|(place, distance)| places.members(place).len() as f64 * value(*distance)).sum()
    };
    let count = sum(&|_| 1.0);
    let mean = sum(&|distance| distance) / count;
    let variance = sum(&|distance| (distance - mean).powi(2)) / (count - 1.0).max(1.0);
    mean * (1.0 + LEAST_DIFFERENCE) + factor * variance.sqrt()
}

/// Returns the number of marks.
pub fn count(marks: &[bool]) -> usize {
    marks.par_iter().filter(|mark| **mark).count()
}
