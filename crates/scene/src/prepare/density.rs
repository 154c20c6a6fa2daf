//! Estimates the number of points per unit of a surface's area by counting in spheres (Tanaka et al. 2016, Section
//! 3.2.1).
//!
//! The paper counts the points in spheres of radius R, a fiftieth of the diagonal of the points' box, around points
//! chosen at random, and divides the mean by the area πR² of a great circle. That is exact on planes and on spheres
//! alike (a ball of radius R cuts πR² out of any sphere), except for four effects that are corrected here.
//!
//! * **The center** is a point itself and would always be counted, so it is excluded. Points that keep their distance,
//!   as in a thinned cloud, then lack one point around it, and points that were measured twice have one too many. The
//!   number is the same for each radius, so a third radius reveals it.
//! * **Rims.** A sphere that extends beyond a rim holds too few points. Over a flat piece of area A and perimeter P the
//!   mean count is ρ(πr² − 2Pr³/3A) (the slope of the covariogram: Matheron, "Random Sets and Integral Geometry",
//!   1975). The relative loss is proportional to r, so two radii reveal it for any outline.
//! * **Other surfaces and thickness.** Two sheets closer than R count as one; a rough surface whose points scatter by
//!   more than r doesn't look like a surface to so small a sphere. On a surface the count grows as r², so among R and
//!   its halves the radius with that growth is chosen (the correlation dimension of Grassberger and Procaccia, 1983, is
//!   2), with a penalty for small counts. Sheets that no radius separates count as one, as in the paper. Points that
//!   fill a volume have no area: their density is that of the sphere of radius R, about as in the paper.
//! * **Points in rows** of a grid enter a sphere by whole rows. A point at distance d counts 2(1 − d²/r²) instead of 1,
//!   which is twice the mean over all spheres up to that area, so that no row enters all at once.
//!
//! Where points are few, R is doubled up to three times, and more than 1000 centers are used where that is cheap.

use std::convert::Infallible;
use std::f64::consts::PI;
use std::ops::Range;

use bytemuck::Zeroable;
use glam::DVec3;
use pellucid_core::progress::Progress;
use rayon::prelude::*;

use crate::lists::Lists;
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;

/// Diagonals of the box to a sphere's radius.
const DIAGONAL: f64 = 50.0;
/// Number of centers that are always used, if the cloud has as many points.
const CENTERS: usize = 1000;
/// Limit on the pairs of a point and a center, near or not, up to which more centers are used.
const CHEAP_PAIRS: usize = 2_000_000_000;
/// Pairs that are measured at most: beyond, only some of the points are counted.
const MAX_PAIRS: u64 = 400_000_000;
/// Points that are counted at most: the first ones.
pub(super) const COUNTED: usize = 1 << 23;
/// Points that a radius of a fiftieth is meant for; with a quarter of that it is doubled, up to [`MAX_DOUBLINGS`]
/// times.
const MANY: usize = 40_000;
/// See [`MANY`].
const MAX_DOUBLINGS: u32 = 3;
/// Radii that are looked at, each half of the one before.
const RADII: usize = 16;
/// Points that one thread counts at a time.
pub(super) const BLOCK: usize = 1 << 14;
/// Blocks of points in memory that are shown at a time, so that progress is seen.
const SHOWN: usize = 64;

/// Returns points per unit of area (world units squared) of the surface that contains them; 0 if fewer than two of them
/// differ or no two are close to each other. Finite.
///
/// `shuffled` are finite positions in random order: the first ones serve as centers, and if counting all would take
/// long, only the first ones are counted.
pub fn estimate(shuffled: &[DVec3], progress: &Progress) -> f64 {
    let Ok(density) = estimate_of(shuffled, progress);
    density
}

/// Finite positions in random order, which may be somewhere else than in memory.
pub(super) trait Shuffled {
    /// Reason why they can't be read.
    type Error;

    /// Returns how many there are.
    fn count(&self) -> usize;

    /// The box around all of them; `None` without any.
    fn bounds(&self) -> Option<Bounds>;

    /// Shows the first `count` of them, some after others, whose number is a multiple of [`BLOCK`] except for the last
    /// ones.
    fn show(&self, count: usize, see: &mut dyn FnMut(&[DVec3])) -> Result<(), Self::Error>;
}

impl Shuffled for [DVec3] {
    type Error = Infallible;

    fn count(&self) -> usize {
        self.len()
    }

    fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self)
    }

    fn show(&self, count: usize, see: &mut dyn FnMut(&[DVec3])) -> Result<(), Infallible> {
        self[..count].chunks(SHOWN * BLOCK).for_each(see);
        Ok(())
    }
}

/// Estimates the density like [`estimate`], from positions that may be somewhere else.
pub(super) fn estimate_of<S: Shuffled + ?Sized>(shuffled: &S, progress: &Progress) -> Result<f64, S::Error> {
    let count = shuffled.count();
    let Some(frame) = Frame::enclosing(shuffled.bounds(), count) else { return Ok(0.0) };
    let centers = CENTERS.max(CHEAP_PAIRS / count).min(count);
    let mut first = Vec::with_capacity(centers);
    shuffled.show(centers, &mut |some| first.extend_from_slice(some))?;
    let grid = Grid::fill(&frame, &first);
    let (mut pairs, most) = (0, count.min(COUNTED));
    shuffled.show(most, &mut |some| pairs += grid.pairs(&frame, some))?;
    let counted = affordable(pairs, most).max(centers);
    let (mut bands, mut seen) = ([Band::default(); RADII], 0);
    shuffled.show(counted, &mut |some| {
        grid.count(&frame, seen, some, &mut bands);
        seen += some.len();
        progress.inc(some.len() as u64);
    })?;
    progress.inc((count - counted) as u64);
    // For one center, as if all points were counted.
    let weight = (count - 1) as f64 / ((counted - 1) as f64 * centers as f64);
    let density = extrapolate(&bands, centers, weight) / frame.radius / frame.radius;
    Ok(density.min(f64::MAX))
}

/// Number of points, out of so many that are together in `pairs`, that can be counted within [`MAX_PAIRS`].
fn affordable(pairs: u64, points: usize) -> usize {
    match pairs {
        0..=MAX_PAIRS => points,
        _ => (points as u128 * u128::from(MAX_PAIRS) / u128::from(pairs)) as usize,
    }
}

/// Coordinates in which the largest sphere has radius 1 and all are at least 0.
struct Frame {
    min: DVec3,
    /// The largest radius in world units.
    radius: f64,
    /// Cells of side 1 along each axis.
    cells: [usize; 3],
}

impl Frame {
    /// `None` if no two points differ.
    fn enclosing(bounds: Option<Bounds>, points: usize) -> Option<Self> {
        let bounds = bounds?;
        let doublings = (0..MAX_DOUBLINGS).find(|&d| points << (2 * d) >= MANY).unwrap_or(MAX_DOUBLINGS);
        // Divided before anything is squared: the diagonal of a box of ±1e308 would overflow, and its sides too.
        let part = f64::from(1 << doublings) / DIAGONAL;
        let sides = bounds.max * part - bounds.min * part;
        let largest = sides.max_element();
        if largest <= 0.0 {
            return None;
        }
        let radius = largest * (sides / largest).length();
        let mut frame = Self { min: bounds.min, radius, cells: [1; 3] };
        // At most 50 of them: the box's sides are no longer than its diagonal.
        frame.cells = frame.local(bounds.max).to_array().map(|side| side as usize + 1);
        (radius.is_finite() && radius > 0.0).then_some(frame)
    }

    fn local(&self, p: DVec3) -> DVec3 {
        // Halved first, as the sides may be beyond float64.
        (0.5 * p - 0.5 * self.min) / self.radius * 2.0
    }

    fn cell(&self, local: DVec3) -> usize {
        let [x, y, z] = self.at(local);
        (z * self.cells[1] + y) * self.cells[0] + x
    }

    fn at(&self, local: DVec3) -> [usize; 3] {
        let local = local.to_array();
        std::array::from_fn(|axis| (local[axis] as usize).min(self.cells[axis] - 1))
    }

    /// The cells along an axis that a sphere around a point of cell `at` meets.
    fn neighbors(&self, at: usize, axis: usize) -> Range<usize> {
        at.saturating_sub(1)..(at + 2).min(self.cells[axis])
    }
}

/// The count between two radii: pairs, and the sum of d² in the frame's coordinates.
#[derive(Clone, Copy, Default, Zeroable)]
struct Band {
    pairs: u64,
    squares: f64,
}

/// The centers whose spheres may reach into each cell.
struct Grid {
    centers: Vec<DVec3>,
    cells: Lists,
}

impl Grid {
    fn fill(frame: &Frame, centers: &[DVec3]) -> Self {
        let centers: Vec<DVec3> = centers.iter().map(|&p| frame.local(p)).collect();
        let cells = |center: DVec3| {
            let [x, y, z] = frame.at(center);
            let (columns, rows, slabs) = (frame.neighbors(x, 0), frame.neighbors(y, 1), frame.neighbors(z, 2));
            let [width, height, _] = frame.cells;
            slabs.flat_map(move |z| {
                let columns = columns.clone();
                rows.clone().flat_map(move |y| columns.clone().map(move |x| (z * height + y) * width + x))
            })
        };
        let members = |(center, place): (u32, &DVec3)| cells(*place).map(move |cell| (cell, center));
        let lists = Lists::new(frame.cells.iter().product(), || (0..).zip(&centers).flat_map(members));
        Self { cells: lists, centers }
    }

    /// The pairs of a center and one of some points that may be near to it.
    fn pairs(&self, frame: &Frame, points: &[DVec3]) -> u64 {
        points.par_iter().map(|&p| self.cells.of(frame.cell(frame.local(p))).len() as u64).sum()
    }

    /// Adds to the bands. Band b holds the pairs of a center and another point whose distance d has 2⁻ᵇ⁻¹ ≤ d < 2⁻ᵇ;
    /// the last one all nearer ones too. `first` points were counted before, a multiple of [`BLOCK`]. The sums don't
    /// depend on the number of cores.
    fn count(&self, frame: &Frame, first: usize, points: &[DVec3], all: &mut [Band; RADII]) {
        let count = |block: usize| {
            let mut bands = [Band::default(); RADII];
            for (i, &point) in points[block * BLOCK..].iter().take(BLOCK).enumerate() {
                let local = frame.local(point);
                for &center in self.cells.of(frame.cell(local)) {
                    let squared = self.centers[center as usize].distance_squared(local);
                    if squared < 1.0 && center as usize != first + block * BLOCK + i {
                        let band = &mut bands[band_of(squared)];
                        band.pairs += 1;
                        band.squares += squared;
                    }
                }
            }
            bands
        };
        let blocks: Vec<[Band; RADII]> = parallel::map(points.len().div_ceil(BLOCK), count);
        for bands in blocks {
            for (sum, band) in all.iter_mut().zip(bands) {
                sum.pairs += band.pairs;
                sum.squares += band.squares;
            }
        }
    }
}

/// The band of a squared distance below 1.
fn band_of(squared: f64) -> usize {
    // ⌊log₂ d²⌋, below 0.
    let exponent = (squared.to_bits() >> 52) as i32 - 1023;
    (((-1 - exponent) / 2) as usize).min(RADII - 1)
}

/// Points per unit of area in the frame's coordinates; 0 without pairs.
fn extrapolate(bands: &[Band; RADII], centers: usize, weight: f64) -> f64 {
    // For each radius 2⁻ʲ: the pairs within it, and their estimate of the density.
    let mut within = Band::default();
    let mut seen = [(0.0, 0.0); RADII];
    for j in (0..RADII).rev() {
        within.pairs += bands[j].pairs;
        within.squares += bands[j].squares;
        // 1 / r².
        let per_area = f64::from(1u32 << (2 * j));
        let count = 2.0 * (within.pairs as f64 - within.squares * per_area);
        seen[j] = (within.pairs as f64, weight * count.max(0.0) * per_area / PI);
    }
    let mut best = (f64::INFINITY, seen[0].1);
    for (j, seen) in seen.windows(3).enumerate() {
        let [(_, whole), (pairs, half), (_, quarter)] = [seen[0], seen[1], seen[2]];
        if pairs == 0.0 || half == 0.0 {
            break;
        }
        // The deviation of the exponent of r from 2. The effect of rims is compensated except for its square.
        let missing = (whole / half).log2();
        let off = if missing < 0.0 { missing * missing } else { missing };
        // For a circle's lattice points the last third of the digits is random (Gauss's circle problem); for random
        // points it is the square root.
        let chance = (pairs / centers as f64).powf(-2.0 / 3.0) + 2.0 / pairs.sqrt();
        if off + chance < best.0 {
            // whole = ρ − rim − own, half = ρ − rim/2 − 4 own, quarter = ρ − rim/4 − 16 own. No surface has less than
            // no rim, and no more than the center itself can be missing, which counts 2.
            let most = 2.0 * weight * centers as f64 * f64::from(1u32 << (2 * j)) / PI;
            let own = (((half - whole) - 2.0 * (quarter - half)) / 21.0).min(most);
            let rim = (2.0 * (half - whole) + 6.0 * own).max(0.0);
            best = (off + chance, (whole + rim + own).max(0.0));
        }
    }
    best.1
}
