//! Stochastic point-based rendering where roundings of float32 decide: which ensemble draws a point that is smaller
//! than a pixel, which pixels a square covers, which of two points is nearer.

use glam::DVec3;

use super::super::range::{ColorRange, Range};
use super::{
    DEPTH_ERROR, Drawn, Inputs, ROUNDING, Rule, View, dealing, drawn, hands_of, least_area, screen_error, share,
};
use pellucid_scene::prepare::ensembles::Dealt;

/// The image and its standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranges {
    /// Mean color, and the share of ensembles that drew something.
    pub rgba: Vec<ColorRange>,
    /// The nearest depth over all ensembles.
    pub depth: Vec<Range>,
    /// The standard errors of R, G, B, infinite for a single ensemble.
    pub stderr: Vec<[Range; 3]>,
}

/// A point on a pixel of an ensemble.
#[derive(Clone)]
struct Candidate {
    z: Range,
    index: usize,
    /// False if roundings decide that it is there.
    sure: bool,
}

/// Sums of all ensembles in a pixel.
#[derive(Clone)]
struct Sums {
    color: [Range; 3],
    squares: [Range; 3],
    drawn: Range,
    depth: Range,
}

impl Sums {
    const EMPTY: Self = Self {
        color: [Range::only(0.0); 3],
        squares: [Range::only(0.0); 3],
        drawn: Range::only(0.0),
        depth: Range::only(f64::INFINITY),
    };

    /// Adds an ensemble. Every candidate may be seen that is not behind one that is there for sure.
    fn add(&mut self, candidates: &[Candidate], colors: &[DVec3]) {
        let sure = candidates.iter().filter(|candidate| candidate.sure);
        let behind = sure.map(|candidate| candidate.z.high).fold(f64::INFINITY, f64::min);
        let seen = || candidates.iter().filter(|candidate| candidate.z.low <= behind);
        let nearest = seen().map(|candidate| candidate.z.low).fold(f64::INFINITY, f64::min);
        let any = |is_any: bool| f64::from(u8::from(is_any));
        self.depth = self.depth.least(Range { low: nearest, high: behind });
        self.drawn = self.drawn + Range { low: any(behind.is_finite()), high: any(nearest.is_finite()) };
        for (c, (color, squares)) in self.color.iter_mut().zip(&mut self.squares).enumerate() {
            let nothing = behind.is_infinite().then_some(Range::only(0.0));
            let values = seen().map(|candidate| Range::only(colors[candidate.index][c]));
            let Some(value) = values.chain(nothing).reduce(Range::hull) else { continue };
            *color = *color + value;
            *squares = *squares + value.times(value);
        }
    }

    fn mean(&self, ensembles: f64) -> ColorRange {
        let [r, g, b] = self.color;
        [r, g, b, self.drawn].map(|sum| Range { low: sum.low / ensembles, high: sum.high / ensembles })
    }

    /// Returns the standard error, as in [`super::render`].
    fn stderr(&self, ensembles: f64) -> [Range; 3] {
        let error = |squares: f64, sum: f64| {
            ((squares - sum * sum / ensembles).max(0.0) / (ensembles * (ensembles - 1.0))).sqrt()
        };
        std::array::from_fn(|c| match ensembles {
            1.0 => Range::only(f64::INFINITY),
            _ => Range {
                low: error(self.squares[c].low, self.color[c].high),
                high: error(self.squares[c].high, self.color[c].low),
            },
        })
    }
}

/// An image of several to which points are dealt together, L ensembles for each: image `index` has those from
/// `index`·L to (`index` + 1)·L of `images`·L.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    /// Number of the image, from 0.
    pub index: u32,
    /// Number of images, at least 1.
    pub images: u32,
}

/// Returns the images that float32 may make of [`super::render`]'s. Arguments as there.
pub fn ranges(view: View, dealt: &Dealt, colors: &[DVec3], rule: &Rule, seed: u64) -> Ranges {
    ranges_of(view, dealt, colors, rule, seed, Turn { index: 0, images: 1 })
}

/// Returns the images like [`ranges`], for one of several images to which points are dealt together.
pub fn ranges_of(view: View, dealt: &Dealt, colors: &[DVec3], rule: &Rule, seed: u64, turn: Turn) -> Ranges {
    let ids = &dealt.points.ids(&dealt.points.anchor(), 0..dealt.points.len());
    let inputs = Inputs { view, dealt, ids, rule: *rule, seed };
    let hands = hands_of(&inputs, turn.images, dealing::hands);
    let mut sums = vec![Sums::EMPTY; view.pixels()];
    for ensemble in (0..rule.ensembles).map(|ensemble| turn.index * rule.ensembles + ensemble) {
        for (sums, candidates) in sums.iter_mut().zip(candidates(&inputs, ensemble, &hands)) {
            sums.add(&candidates, colors);
        }
    }
    let ensembles = f64::from(rule.ensembles);
    Ranges {
        rgba: sums.iter().map(|sums| sums.mean(ensembles)).collect(),
        depth: sums.iter().map(|sums| sums.depth).collect(),
        stderr: sums.iter().map(|sums| sums.stderr(ensembles)).collect(),
    }
}

/// Everything that an ensemble may draw on each pixel.
fn candidates(inputs: &Inputs, ensemble: u32, hands: &[Vec<Vec<u64>>]) -> Vec<Vec<Candidate>> {
    let mut pixels = vec![Vec::new(); inputs.view.pixels()];
    for (surface, hands) in inputs.dealt.surfaces.iter().zip(hands) {
        let share = share(inputs.view, inputs.dealt, surface, &inputs.rule);
        for point in &hands[ensemble as usize] {
            let index = (surface.points.start + point) as usize;
            // Near and far are rounded, too.
            let [wide, narrow] = [1.0, -1.0].map(|sign| drawn(inputs, &share, index, sign * 2.0 * DEPTH_ERROR));
            let Some(point) = wide else { continue };
            let least = least_area(inputs.ids[index], ensemble, inputs.seed);
            if point.area + point.area_error <= least {
                continue;
            }
            let is_drawn = narrow.is_some() && point.area - point.area_error > least;
            for (pixel, covers) in covered(&point, inputs.view.size) {
                let sure = is_drawn && covers;
                pixels[pixel].push(Candidate { z: Range::depth(point.z), index, sure });
            }
        }
    }
    pixels
}

/// The pixels that a drawn point may cover, and whether it does for sure.
fn covered(point: &Drawn, size: [u32; 2]) -> impl Iterator<Item = (usize, bool)> + use<> {
    let [columns, rows] = [0, 1].map(|axis| Side::new(point, axis, size[axis]));
    let width = i64::from(size[0]);
    rows.possible().flat_map(move |y| {
        columns.possible().map(move |x| ((y * width + x) as usize, rows.is_sure(y) && columns.is_sure(x)))
    })
}

/// The first column or row of a point, and one past its last: what they may be.
#[derive(Clone, Copy)]
struct Side {
    first: [i64; 2],
    end: [i64; 2],
}

impl Side {
    /// Half the side of the square has half the area's relative error, and a rounding for its root and its half each;
    /// it is taken from or added to a half, then to the fraction of a pixel, where the sum is below 1.5 more.
    fn new(point: &Drawn, axis: usize, side: u32) -> Self {
        let at = point.at[axis];
        let [small, large] = [-1.0, 1.0].map(|sign| 0.5 * (point.area + sign * point.area_error).max(1.0).sqrt());
        let error = screen_error(at, side) + ROUNDING * (4.0 * large + 2.0);
        let pixel = |x: f64| ((x + 0.5).floor() as i64).clamp(0, i64::from(side));
        Self {
            first: [pixel(at - large - error), pixel(at - small + error)],
            end: [pixel(at + small - error), pixel(at + large + error)],
        }
    }

    fn possible(self) -> std::ops::Range<i64> {
        self.first[0]..self.end[1]
    }

    fn is_sure(self, at: i64) -> bool {
        (self.first[1]..self.end[0]).contains(&at)
    }
}
