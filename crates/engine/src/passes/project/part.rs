//! The part of a cloud that is projected: a threshold on the field tells solid from soft points.

use crate::points::Points;
use crate::progress::Progress;
use crate::supply::{self, Supply};

/// Part of the points of a cloud that is projected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CloudPart {
    /// All.
    All,
    /// Points whose field is at most the threshold.
    Solid(f32),
    /// Points whose field is above the threshold. Their splats' fourth component is W of Seemann et al., Eq. 22, not an
    /// opacity.
    Soft {
        /// t
        threshold: f32,
        /// l_m
        modulation: Option<f32>,
    },
    /// All; the fourth component of their splats is 1 for those whose field is at most the threshold, else 0.
    Marked(f32),
}

impl CloudPart {
    /// Returns the value of `PART` in WGSL.
    pub(super) fn value(self) -> u32 {
        match self {
            Self::All => PART_ALL,
            Self::Solid(_) => PART_SOLID,
            Self::Soft { .. } => PART_SOFT,
            Self::Marked(_) => PART_MARKED,
        }
    }

    pub(super) fn modulation(self) -> f32 {
        match self {
            Self::Soft { modulation: Some(most), .. } => most,
            _ => 0.0,
        }
    }

    pub(super) fn threshold(self) -> f32 {
        match self {
            Self::All => 0.0,
            Self::Solid(threshold) | Self::Marked(threshold) | Self::Soft { threshold, .. } => threshold,
        }
    }
}

const PART_ALL: u32 = 0;
pub(super) const PART_SOLID: u32 = 1;
pub(super) const PART_SOFT: u32 = 2;
pub(super) const PART_MARKED: u32 = 3;

/// Numbers of the points that a threshold makes solid and soft.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Parts {
    /// Points with a field of at most the threshold; all if there is no field.
    pub solid: u64,
    /// Points with a field above it.
    pub soft: u64,
    /// Median radius of these in world units, 0 if there are none.
    pub median_radius: f32,
    /// Smallest and largest field of all points; `None` without a field.
    pub ends: Option<[f32; 2]>,
}

impl Parts {
    /// Counts a scene's points.
    pub fn count(points: &Points, threshold: f32) -> Self {
        Self::new(points.len() as u64, &fields_and_radii(points), threshold)
    }

    /// Counts `len` points from their fields and radii, which are empty without a field.
    pub(super) fn new(len: u64, fields_and_radii: &[[f32; 2]], threshold: f32) -> Self {
        let mut radii: Vec<f32> = fields_and_radii.iter().filter(|[f, _]| *f > threshold).map(|[_, r]| *r).collect();
        let soft = radii.len() as u64;
        let ends = fields_and_radii.iter().map(|[field, _]| *field).fold(None, widened);
        Self { solid: len - soft, soft, median_radius: median(&mut radii), ends }
    }
}

/// Points that are looked at at once.
const AT_ONCE: u64 = 1 << 22;

impl Parts {
    /// Counts points that come some at a time, twice.
    pub(super) fn of_supply(supply: &dyn Supply, threshold: f32, progress: &Progress) -> Result<Self, supply::Failure> {
        // Radii are not below 0, so that their bits have their order. First by the upper half of the bits, then by the
        // lower one.
        let (mut all, mut upper, mut ends) = (0u64, vec![0u64; 1 << 16], None);
        let is_soft = |points: &Points, i: usize| points.fields.get(i).is_some_and(|field| *field > threshold);
        let radii = |points: &Points| -> Vec<u32> {
            let soft = (0..points.len()).filter(|i| is_soft(points, *i));
            soft.map(|i| (points.radii[i] + 0.0).to_bits()).collect()
        };
        supply::each(supply, AT_ONCE, progress, |points| {
            all += points.len() as u64;
            ends = points.fields.iter().copied().fold(ends, widened);
            radii(points).into_iter().for_each(|bits| upper[(bits >> 16) as usize] += 1);
        })?;
        let soft: u64 = upper.iter().sum();
        if soft == 0 {
            return Ok(Self { solid: all, soft, median_radius: 0.0, ends });
        }
        let ranks = [(soft - 1) / 2, soft / 2];
        let halves = ranks.map(|rank| ranked(&upper, rank));
        let mut lower = [vec![0u64; 1 << 16], vec![0u64; 1 << 16]];
        supply::each(supply, AT_ONCE, progress, |points| {
            for bits in radii(points) {
                for (half, counts) in halves.iter().zip(&mut lower) {
                    counts[(bits & 0xffff) as usize] += u64::from(half.0 == bits >> 16);
                }
            }
        })?;
        let value = |which: usize| {
            let (half, before) = halves[which];
            f32::from_bits(half << 16 | ranked(&lower[which], ranks[which] - before).0)
        };
        let (low, high) = (value(0), value(1));
        let median_radius = if ranks[0] == ranks[1] { high } else { 0.5 * low + 0.5 * high };
        Ok(Self { solid: all - soft, soft, median_radius, ends })
    }
}

/// Two ends, so far apart that a field lies between them.
fn widened(ends: Option<[f32; 2]>, field: f32) -> Option<[f32; 2]> {
    let [low, high] = ends.unwrap_or([field; 2]);
    Some([low.min(field), high.max(field)])
}

/// The bin with the value of a rank, and how many are in the bins before.
fn ranked(counts: &[u64], rank: u64) -> (u32, u64) {
    let mut before = 0;
    for (bin, count) in counts.iter().enumerate() {
        if rank < before + count {
            return (bin as u32, before);
        }
        before += count;
    }
    (0, 0)
}

/// Field and radius of each point; nothing without a field.
pub(super) fn fields_and_radii(points: &Points) -> Vec<[f32; 2]> {
    points.fields.iter().zip(&points.radii).map(|(field, radius)| [*field, *radius]).collect()
}

/// The median, the mean of the middle two of an even number; 0 of none.
fn median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    let (_, upper, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
    let upper = *upper;
    if values.len().is_multiple_of(2) {
        let lower = values[..middle].iter().copied().fold(f32::MIN, f32::max);
        0.5 * lower + 0.5 * upper
    } else {
        upper
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_come_some_at_a_time_have_the_same_parts() {
        for count in [1, 2, 9, 10, 40_000, 40_001] {
            let spread = |i: usize, by: usize| ((i * by) % 65_537) as f32;
            let points = Points {
                positions: (0..count).map(|i| glam::DVec3::splat(i as f64)).collect(),
                colors: vec![glam::Vec3::ONE; count],
                opacities: vec![1.0; count],
                radii: (0..count).map(|i| 0.001 * spread(i, 48_271)).collect(),
                fields: (0..count).map(|i| spread(i, 16_807) / 65_537.0).collect(),
                ..Points::default()
            };
            let held = supply::HeldPoints::new(std::sync::Arc::new(points.clone()));
            for threshold in [0.0, 0.3, 0.9, 1.0] {
                let found = Parts::of_supply(&held, threshold, &Progress::hidden()).unwrap();
                assert_eq!(found, Parts::count(&points, threshold), "{count} {threshold}");
            }
        }
    }

    #[test]
    fn a_threshold_parts_a_cloud() {
        let points = [[0.2, 9.0], [0.6, 3.0], [0.5, 7.0], [0.9, 1.0], [0.7, 2.0], [0.8, 8.0]];
        let ends = Some([0.2, 0.9]);
        assert_eq!(Parts::new(6, &points, 0.5), Parts { solid: 2, soft: 4, median_radius: 2.5, ends });
        assert_eq!(Parts::new(6, &points, 0.6), Parts { solid: 3, soft: 3, median_radius: 2.0, ends });
        assert_eq!(Parts::new(6, &points, 1.0), Parts { solid: 6, soft: 0, median_radius: 0.0, ends });
        assert_eq!(Parts::new(6, &[], 0.0), Parts { solid: 6, soft: 0, median_radius: 0.0, ends: None });
    }
}
