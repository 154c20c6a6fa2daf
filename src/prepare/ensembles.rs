//! Points in the order that ensembles are dealt from (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! Each cloud's points stand in random order, one cloud behind the other. The copies of a cloud's points are the slots
//! 0, 1, 2, … of an endless list that repeats its points in this order: slot m is point m mod N. Of these the first
//! M = round(kN) are dealt: ensemble e of L takes slots ⌊eM/L⌋ to ⌊(e+1)M/L⌋. So no copy is stored, the sizes of ensembles
//! differ by at most one, for k < 1 the points left out are random, and while k ≤ L no ensemble holds a point twice, since
//! its copies are N slots apart and an ensemble has M/L ≤ N of them.

use std::ops::Range;

use glam::DVec3;

use crate::points::Points;

/// What is known of one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Where its points stand in the list.
    pub points: Range<u64>,
    /// Middle of the box of its points, in world coordinates: where a point is one pixel wide.
    pub center: DVec3,
    /// Points for each unit of a surface's area (world units squared), by counting spheres; 0 if it has no area.
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
