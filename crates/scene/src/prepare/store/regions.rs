//! Space in regions with not too many points.

use std::collections::HashMap;

use glam::{DVec3, UVec3};

use super::super::morton;
use super::source::RegionStore;
use pellucid_core::cloud::{Bounds, Cloud};
use pellucid_core::morton::{BITS, divided};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;
use pellucid_io::Error;
use pellucid_io::store::Store;

/// Levels of the cells whose points are counted.
const LEVELS: u32 = 7;

/// Nodes that are read at once.
const BATCH: usize = 64;

/// A cell of the Morton curve through the cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Region {
    pub level: u32,
    /// The first digits of the codes of its points.
    code: u64,
}

impl Region {
    /// Tells for each of some positions if it is in the region.
    pub fn holds(self, positions: &[DVec3], bounds: &Bounds) -> Vec<bool> {
        let codes = morton::codes(positions, bounds);
        parallel::map_each(&codes, |code| *code >> (3 * (BITS - self.level)) == self.code)
    }

    /// Returns its box, to rounding.
    pub fn bounds(self, bounds: &Bounds) -> Bounds {
        let digits = |axis: u32| {
            (0..self.level).fold(0, |at, level| at | ((self.code >> (3 * level + axis) & 1) as u32) << level)
        };
        let at = UVec3::new(digits(0), digits(1), digits(2));
        // As codes are made: the longest side has one cell less than there are numbers.
        let side = morton::cell_side(bounds) * f64::from(1_u32 << (BITS - self.level));
        let min = bounds.min + at.as_dvec3() * side;
        Bounds { min, max: min + side }
    }
}

/// Regions with at most so many points, as far as cells of the finest level allow. Each cloud of points that is read is
/// shown to `see`.
pub(super) fn regions<T: Send>(
    source: &RegionStore,
    most: u64,
    progress: &Progress,
    see: impl Fn(&Cloud) -> T + Sync,
    mut take: impl FnMut(T),
) -> Result<Vec<Region>, Error> {
    progress.reset();
    progress.set_length(source.octree.summary().points);
    let mut counts: HashMap<u64, u64> = HashMap::new();
    let nodes: Vec<usize> = (0..source.octree.nodes().len()).collect();
    for batch in nodes.chunks(BATCH) {
        progress.check().map_err(|_| Error::Cancelled { path: source.octree.summary().path.clone() })?;
        let read = |node: &usize| -> Result<_, Error> {
            let cloud = source.octree.read(*node)?.cloud;
            progress.inc(cloud.len() as u64);
            Ok((morton::codes(&cloud.positions, &source.bounds), see(&cloud)))
        };
        for (codes, seen) in parallel::try_map_each(batch, read)? {
            codes.into_iter().for_each(|code| *counts.entry(code >> (3 * (BITS - LEVELS))).or_default() += 1);
            take(seen);
        }
    }
    let mut counts: Vec<(u64, u64)> = counts.into_iter().collect();
    counts.sort_unstable();
    let region = |(level, code, _)| Region { level, code: code >> (3 * (LEVELS - level)) };
    Ok(divided(LEVELS, &counts, most).into_iter().map(region).collect())
}
