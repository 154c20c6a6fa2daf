//! Points in blocks, of which some are taken at a time: clouds that don't fit the device, or the host's memory.

mod cut;
mod scale;
mod spacing;
mod tree;

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

pub use cut::{Cut, CutPicture, Limits};
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;
use pellucid_core::points::{Points, Unseen};
use pellucid_core::progress::{Cancelled, Progress};
pub use scale::Scale;
#[doc(hidden)]
pub use spacing::spacing;

/// A scene's points in blocks. Discs in one place are either in one block, or in blocks of which each holds the largest
/// radius there: taking every block that overlaps a region of the image yields all visible discs of any location in
/// it. Gaussians are taken by how far they reach themselves, since a few reach across most scenes.
pub trait Supply: Debug + Send + Sync {
    /// The blocks.
    fn blocks(&self) -> &[Block];

    /// Points that may be taken at a time: as many as memory is given for.
    fn most(&self) -> u64 {
        u64::MAX
    }

    /// Estimates how many points are in places that show; `None` if nothing is known of it.
    fn estimate(&self, _shows: &(dyn Fn(DVec3) -> bool + Sync)) -> Option<u64> {
        None
    }

    /// Reads those points of some blocks, in ascending order, that `keep` keeps, in canonical order. They have the
    /// columns of all points, even if they are empty.
    ///
    /// # Errors
    /// Returns an error if the points can't be read, or `progress` cancels it.
    fn take(&self, blocks: &[u32], keep: Keep<'_>, progress: &Progress) -> Result<Points, Failure>;
}

/// Shows all points, about so many at a time.
///
/// # Errors
/// Returns an error if the points can't be read, or `progress` cancels it.
pub fn each(
    supply: &dyn Supply,
    at_once: u64,
    progress: &Progress,
    mut see: impl FnMut(&Points),
) -> Result<(), Failure> {
    let (mut some, mut count) = (Vec::new(), 0);
    let blocks = supply.blocks();
    for (number, block) in blocks.iter().enumerate() {
        some.push(number as u32);
        count += block.points;
        if count >= at_once || number + 1 == blocks.len() {
            see(&supply.take(&some, Keep::ALL, progress)?);
            (some, count) = (Vec::new(), 0);
        }
    }
    Ok(())
}

/// Choice of the points that are taken, and of how much larger they become: by their place and the number of their
/// block. Discs in one place of a block are taken together, and Gaussians that reach as far.
#[derive(Clone, Copy)]
pub struct Keep<'a> {
    /// Function that returns `true` for those that are taken: by place, block, and of a Gaussian how far it reaches.
    /// One that reaches farther is taken before others.
    pub keeps: &'a (dyn Fn(DVec3, u32, Option<f32>) -> bool + Sync),
    /// `true` if all points of a block are taken whose box has corners that would be: no part of space is left out
    /// between them.
    pub convex: bool,
    /// The factor on the radius of discs, if any has one.
    pub grows: Option<&'a (dyn Fn(DVec3, u32) -> f32 + Sync)>,
}

impl<'a> Keep<'a> {
    /// All of them.
    pub const ALL: Keep<'static> = Keep { keeps: &|_, _, _| true, convex: true, grows: None };

    /// Returns those in a convex part of space, as they are. Points may be taken as well that don't show.
    pub fn those(keeps: &'a (dyn Fn(DVec3, u32, Option<f32>) -> bool + Sync)) -> Self {
        Self { keeps, convex: true, grows: None }
    }
}

/// Makes discs larger by a factor each. Gaussians stay as they are.
pub(crate) fn grow(points: &mut Points, factors: &[f32]) {
    let Points { radii, gaussians, .. } = points;
    let is_disc = |i: usize| gaussians.as_ref().is_none_or(|all| !all.is_one(i));
    parallel::for_each_mut(radii, |i, radius| {
        if is_disc(i) {
            *radius = grown(*radius, factors[i]);
        }
    });
}

/// Returns a radius times a factor, finite.
#[doc(hidden)]
pub fn grown(radius: f32, factor: f32) -> f32 {
    (radius * factor).min(f32::MAX)
}

/// Reason why points can't be taken.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Failure {
    /// The store failed.
    #[error("{0}")]
    Store(#[from] Arc<pellucid_io::Error>),
    /// The coarsest level has more points than are allowed.
    #[error("{points} points of the coarsest level are in the picture, {allowed} are allowed")]
    Coarsest { allowed: u64, points: u64 },
    /// Somebody who watches the progress wanted the work to end.
    #[error("cancelled")]
    Cancelled,
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Some points of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// A box around them, in world coordinates.
    pub bounds: Bounds,
    /// The largest radius of all points in that box that aren't farther apart than points in one place, in world units.
    /// Of Gaussians the farthest that one of its own reaches.
    pub radius: f32,
    /// Number of points.
    pub points: u64,
    /// Place of the block among the levels of its cloud; `None` if that has no levels.
    pub branch: Option<Branch>,
}

/// Place of a block in a tree of levels, each of which makes those above it finer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// The block above, whose number is smaller; `None` of a root.
    pub parent: Option<u32>,
    /// The distance between points of the levels above, in world units; infinite where there are none.
    pub spacing: f64,
    /// The factor on radii above it that makes up for leaving out this block and all below it: the discs of a place
    /// together keep their area. At least 1.
    pub growth: f32,
}

/// Points of a block of those in memory; more if that many are in one place.
const BLOCK: usize = 1 << 12;

/// Points in memory, in canonical order, in which those near in space are near in the list.
#[derive(Clone)]
pub struct HeldPoints {
    points: Arc<Points>,
    blocks: Vec<Block>,
    /// First point of each block, with their number as the last entry.
    starts: Vec<usize>,
}

impl Debug for HeldPoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} points in {} blocks", self.points.len(), self.blocks.len())
    }
}

impl HeldPoints {
    /// Returns points in canonical order.
    pub fn new(points: Arc<Points>) -> Self {
        let starts = starts(&points);
        let block = |i: usize| {
            let range = starts[i]..starts[i + 1];
            let positions = points.positions[range.clone()].iter().copied();
            let radius = points.radii[range.clone()].iter().copied().fold(0.0, f32::max);
            Some(Block { bounds: Bounds::enclosing(positions)?, radius, points: range.len() as u64, branch: None })
        };
        let blocks = parallel::gather(starts.len() - 1, block).into_iter().flatten().collect();
        Self { points, blocks, starts }
    }
}

/// Returns the first points of blocks that cut no run of points in one place, and the number of all points.
#[doc(hidden)]
pub fn starts(points: &Points) -> Vec<usize> {
    let (positions, mut found) = (&points.positions, vec![0]);
    let mut next = BLOCK;
    while next < positions.len() {
        if positions[next] == positions[next - 1] {
            next += 1;
        } else {
            found.push(next);
            next += BLOCK;
        }
    }
    found.push(positions.len());
    found
}

impl Supply for HeldPoints {
    fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    fn take(&self, blocks: &[u32], keep: Keep<'_>, _progress: &Progress) -> Result<Points, Failure> {
        let positions = &self.points.positions;
        let places = |i: usize| -> Vec<u32> {
            let block = blocks[i];
            let all = self.starts[block as usize]..self.starts[block as usize + 1];
            let keeps = |place: &usize| (keep.keeps)(positions[*place], block, self.points.reach(*place));
            all.filter(keeps).map(|place| place as u32).collect()
        };
        let places: Vec<Vec<u32>> = parallel::gather(blocks.len(), places);
        let factors: Option<Vec<f32>> = keep.grows.map(|grows| {
            let grow = |i: usize, place: &u32| grows(positions[*place as usize], blocks[i]);
            let of_block = |i: usize| -> Vec<f32> { places[i].iter().map(|place| grow(i, place)).collect() };
            parallel::gather(blocks.len(), of_block).concat()
        });
        let mut taken = self.points.subset(&places.concat(), 1.0);
        if let Some(factors) = factors {
            grow(&mut taken, &factors);
        }
        Ok(Points { unseen: Arc::<Unseen>::default(), ..taken })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(positions: Vec<DVec3>) -> Points {
        let radii = (0..positions.len()).map(|i| i as f32).collect();
        Points { radii, ..pellucid_testing_host::white(positions, 0.5) }
    }

    #[test]
    fn blocks_part_no_place_and_give_their_points_back() {
        let mut positions: Vec<DVec3> = (0..3 * BLOCK).map(|i| DVec3::splat(i as f64)).collect();
        // A run across the first border.
        positions[BLOCK - 2..BLOCK + 5].fill(DVec3::splat(BLOCK as f64 - 2.0));
        let held = HeldPoints::new(Arc::new(points(positions)));
        assert_eq!(held.starts, [0, BLOCK + 5, 2 * BLOCK + 5, 3 * BLOCK]);
        let [first, second, _] = held.blocks() else { panic!("{held:?}") };
        assert_eq!((first.points, first.radius), (BLOCK as u64 + 5, BLOCK as f32 + 4.0));
        assert_eq!(second.bounds.min, DVec3::splat(BLOCK as f64 + 5.0));
        let taken = held.take(&[0, 2], Keep::ALL, &Progress::hidden()).unwrap();
        assert_eq!(taken.len(), BLOCK + 5 + BLOCK - 5);
        assert_eq!(taken.radii[BLOCK + 4..BLOCK + 6], [BLOCK as f32 + 4.0, 2.0 * BLOCK as f32 + 5.0]);
        let few = held.take(&[0, 1], Keep::those(&|p, block, _| p.x < 2.0 && block == 0), &Progress::hidden()).unwrap();
        assert_eq!(few.radii, [0.0, 1.0]);
        let keep = Keep { keeps: &|p, _, _| p.x < 2.0, convex: true, grows: Some(&|p, _| 2.0 + p.x as f32) };
        assert_eq!(held.take(&[0, 1], keep, &Progress::hidden()).unwrap().radii, [0.0, 3.0]);
        let none = held.take(&[0, 1], Keep::those(&|_, _, _| false), &Progress::hidden()).unwrap();
        assert!(none.is_empty());
    }
}
