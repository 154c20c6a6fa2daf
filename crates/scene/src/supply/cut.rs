//! Levels of detail: which points of an out-of-core stream a picture can do without, and how much larger the others
//! become.

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

use super::tree::BlockTree;
use super::{Block, Failure, Keep, Scale, Supply, grown};
use pellucid_core::cloud::sampling;
use pellucid_core::parallel;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;

/// Limits of how much of a cloud is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Levels are left out where those above them have points this near to one another, in pixels.
    pub spacing_px: f64,
    /// Points in the picture, at most.
    pub max_points: Option<u64>,
}

/// The picture that a cut is for.
#[derive(Clone, Copy)]
pub struct CutPicture<'a> {
    /// Scale of the view's pixels.
    pub scale: Scale,
    /// The blocks of which something may be in it.
    pub blocks: &'a [u32],
    /// Function that returns `true` for places in it.
    pub shows: &'a (dyn Fn(DVec3) -> bool + Sync),
    /// A place that no camera of the picture sees.
    pub nowhere: DVec3,
    /// The seed of the order in which points without levels come.
    pub seed: u64,
}

/// The points of an out-of-core stream that are drawn of it. Each point has a spacing in pixels at which the picture
/// can do without it: that of the levels above at the nearest place of its block; without levels that of the points
/// before it in a random order. Those above the cut's are kept. It follows from camera and size alone, not from
/// windows.
pub struct Cut {
    whole: Arc<dyn Supply>,
    tree: BlockTree,
    /// True for each block of the whole that is retained.
    kept: Vec<bool>,
    /// The kept blocks, with their numbers in the whole.
    blocks: Vec<Block>,
    numbers: Vec<u32>,
    random: Random,
    /// `true` if some blocks have no levels.
    is_random: bool,
    /// Pixels that points are apart at most, where there are so many: those asked for, or more, so that no more points
    /// come than asked for.
    pub px: f64,
    /// Place that the picture doesn't show.
    pub nowhere: DVec3,
    /// Factor by which radii grow, at most.
    pub most_growth: f32,
    /// Points in the picture, where they were counted for a limit.
    shown: Option<u64>,
}

impl Debug for Cut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of {} blocks, {} px", self.blocks.len(), self.kept.len(), self.px)
    }
}

/// The random order of points without levels.
#[derive(Debug, Clone, Copy)]
struct Random {
    scale: Scale,
    /// The distance between all points, in world units; 0 if it is not known.
    spacing: f64,
    seed: u64,
}

impl Random {
    /// The pixels between all points where a world unit has so many.
    fn px(&self, unit_px: f64) -> f64 {
        if self.spacing > 0.0 { self.spacing * unit_px } else { f64::INFINITY }
    }

    /// The pixels between the points up to this one.
    fn own_px(&self, position: DVec3) -> f64 {
        let share = (f64::from(sampling::word(position, self.seed)) + 0.5) / 4_294_967_296.0;
        self.px(self.scale.px(position)) / share.sqrt()
    }

    /// The factor on radii there if points are at most so many pixels apart.
    fn growth(&self, cut_px: f64, unit_px: f64) -> f32 {
        (cut_px / self.px(unit_px)).max(1.0) as f32
    }
}

impl Cut {
    /// Returns what limits leave of an out-of-core stream. `spacing` is the distance between all points of clouds
    /// without levels, in world units.
    ///
    /// # Errors
    /// Points of clouds without levels can't be read to be counted, the coarsest level has more than are allowed, or
    /// `progress` cancels it.
    pub fn new(
        whole: Arc<dyn Supply>,
        spacing: f64,
        limits: &Limits,
        picture: &CutPicture<'_>,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let random = Random { scale: picture.scale, spacing, seed: picture.seed };
        let levels = levels_px(whole.blocks(), &picture.scale);
        let Some(most) = limits.max_points else {
            return Ok(Self::at(whole, &levels, random, limits.spacing_px, picture.nowhere));
        };
        let counts = counts(&*whole, &levels, &random, picture, progress)?;
        let px = allowed_px(&counts, most)?.max(limits.spacing_px);
        let shown = Some(counts[bin(px)..].iter().sum());
        Ok(Self { shown, ..Self::at(whole, &levels, random, px, picture.nowhere) })
    }

    /// The cut at so many pixels.
    fn at(whole: Arc<dyn Supply>, levels: &[Option<f64>], random: Random, px: f64, nowhere: DVec3) -> Self {
        let all = whole.blocks();
        // The share of a random order at the nearest place of a block; words have 32 bits.
        let share = |block: &Block| (random.px(random.scale.most_px(&block.bounds)) / px).powi(2).min(1.0);
        let keeps = |(block, own): (&Block, &Option<f64>)| own.map_or(share(block) > 1e-10, |own| own > px);
        let mut kept: Vec<bool> = all.iter().zip(levels).map(keeps).collect();
        if let Some(first) = kept.first_mut() {
            // An out-of-core stream has a block, if one without points.
            *first = true;
        }
        let tree = BlockTree::new(all);
        let is_random = levels.iter().any(Option::is_none);
        let numbers: Vec<u32> = (0..all.len() as u32).filter(|number| kept[*number as usize]).collect();
        let cut = |i: usize| {
            let (number, block) = (numbers[i] as usize, all[numbers[i] as usize]);
            let growth = if is_random { random.growth(px, random.scale.least_px(&block.bounds)) } else { 1.0 };
            let growth = growth.max(tree.most_growth(all, &kept, &block.bounds));
            let points = if levels[number].is_some() {
                block.points
            } else {
                (share(&block) * block.points as f64).ceil() as u64
            };
            (Block { radius: grown(block.radius, growth), points, ..block }, growth)
        };
        let (blocks, growths): (Vec<Block>, Vec<f32>) = parallel::gather(numbers.len(), cut).into_iter().unzip();
        let most_growth = growths.into_iter().fold(1.0, f32::max);
        Self { tree, kept, blocks, numbers, random, is_random, px, nowhere, most_growth, shown: None, whole }
    }

    /// Returns the number of points in all blocks; of clouds without levels about as many.
    pub fn points(&self) -> u64 {
        self.blocks.iter().map(|block| block.points).sum()
    }

    /// Returns the number of points in the picture, if a limit had them counted, else [`Self::points`].
    pub fn shown(&self) -> u64 {
        self.shown.unwrap_or_else(|| self.points())
    }

    fn keeps(&self, position: DVec3, number: u32) -> bool {
        // Blocks of levels are kept as a whole.
        self.whole.blocks()[number as usize].branch.is_some() || self.random.own_px(position) > self.px
    }

    fn growth(&self, position: DVec3, number: u32) -> f32 {
        let blocks = self.whole.blocks();
        if blocks[number as usize].branch.is_some() {
            self.tree.growth(blocks, &self.kept, number, position)
        } else {
            self.random.growth(self.px, self.random.scale.px(position))
        }
    }
}

impl Supply for Cut {
    fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    fn most(&self) -> u64 {
        self.whole.most()
    }

    fn take(&self, blocks: &[u32], keep: Keep<'_>, progress: &Progress) -> Result<Points, Failure> {
        let numbers: Vec<u32> = blocks.iter().map(|block| self.numbers[*block as usize]).collect();
        // Numbers ascend.
        let place = |number: u32| self.numbers.partition_point(|other| *other < number) as u32;
        let keeps =
            |p: DVec3, number: u32, reach: Option<f32>| self.keeps(p, number) && (keep.keeps)(p, place(number), reach);
        let grows = |position: DVec3, number: u32| {
            let more = keep.grows.map_or(1.0, |grows| grows(position, place(number)));
            self.growth(position, number) * more
        };
        self.whole.take(
            &numbers,
            Keep { keeps: &keeps, convex: keep.convex && !self.is_random, grows: Some(&grows) },
            progress,
        )
    }
}

/// Pixels, for each block with levels, between points of the levels above it, at its nearest place; never more than
/// above it.
fn levels_px(blocks: &[Block], scale: &Scale) -> Vec<Option<f64>> {
    let mut found: Vec<Option<f64>> = Vec::with_capacity(blocks.len());
    for block in blocks {
        let own = block.branch.map(|branch| {
            let own =
                if branch.spacing.is_finite() { branch.spacing * scale.most_px(&block.bounds) } else { f64::INFINITY };
            let above = branch.parent.and_then(|parent| *found.get(parent as usize)?);
            above.map_or(own, |above| own.min(above))
        });
        found.push(own);
    }
    found
}

/// Points by their pixels, by the upper bits of the float32: 2⁻¹² of a value wide.
const BIN_SHIFT: u32 = 11;
/// Points that are looked at at once.
const AT_ONCE: u64 = 1 << 20;

fn bin(px: f64) -> usize {
    ((px as f32).to_bits() >> BIN_SHIFT) as usize
}

/// Returns how many points of a picture have how many pixels.
fn counts(
    whole: &dyn Supply,
    levels: &[Option<f64>],
    random: &Random,
    picture: &CutPicture<'_>,
    progress: &Progress,
) -> Result<Vec<u64>, Failure> {
    let mut counts = vec![0; bin(f64::INFINITY) + 1];
    let (mut some, mut points) = (Vec::new(), 0);
    let mut look = |some: &mut Vec<u32>| -> Result<(), Failure> {
        let points = whole.take(some, Keep::those(&|position, _, _| (picture.shows)(position)), progress)?;
        let bins = parallel::map_each(&points.positions, |position| bin(random.own_px(*position)));
        bins.into_iter().for_each(|bin| counts[bin] += 1);
        some.clear();
        Ok(())
    };
    for number in picture.blocks.iter().filter(|number| levels[**number as usize].is_none()) {
        some.push(*number);
        points += whole.blocks()[*number as usize].points;
        if points >= AT_ONCE {
            look(&mut some)?;
            points = 0;
        }
    }
    if !some.is_empty() {
        look(&mut some)?;
    }
    for number in picture.blocks {
        if let Some(px) = levels[*number as usize] {
            counts[bin(px)] += whole.blocks()[*number as usize].points;
        }
    }
    Ok(counts)
}

/// The pixels above which at most so many points are.
fn allowed_px(counts: &[u64], most: u64) -> Result<f64, Failure> {
    let mut all = 0u64;
    for (bin, count) in counts.iter().enumerate().rev() {
        all = all.saturating_add(*count);
        if all > most && bin + 1 == counts.len() {
            return Err(Failure::Coarsest { allowed: most, points: all });
        }
        if all > most {
            // All of this bin are left out, and what has just the least of the next one.
            return Ok(f32::from_bits(((bin + 1) << BIN_SHIFT) as u32).min(f32::MAX).into());
        }
    }
    Ok(0.0)
}

#[cfg(test)]
mod tests;
