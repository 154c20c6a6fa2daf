//! Blended splats where roundings of float32 decide which of them count.

use glam::DVec3;

use super::super::coverage::{Shape, Splat, possible};
use super::super::range::{ColorRange, NOTHING, PictureRange, ROUNDING, Range};
use super::splat;
use crate::View;
use pellucid_core::points::Points;
use pellucid_scene::{BlendedSplats, ScreenSplats};

/// A splat that a pixel may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    pub z: Range,
    pub rho: Range,
    pub radius: f64,
    pub index: usize,
    pub sure: bool,
}

impl Candidate {
    /// z + `blend_depth`·r. The radius has seven roundings: size, scale, clamp, and back to world units.
    fn end(&self, blend_depth: f64) -> Range {
        self.behind(self.z, blend_depth)
    }

    /// Returns the same behind another depth.
    pub fn behind(&self, z: Range, blend_depth: f64) -> Range {
        let reach = blend_depth * self.radius;
        let end = z + Range::only(reach);
        let largest = if end.high.is_finite() { end.high.abs() } else { end.low.abs() };
        // An infinite sum is not rounded.
        if largest.is_finite() { end.widened(ROUNDING * (9.0 * reach + largest)) } else { end }
    }

    /// exp(−2ρ²), least and most.
    fn weight(&self) -> Range {
        let weight = |rho: f64| (-2.0 * rho * rho).exp();
        Range { low: weight(self.rho.high), high: weight(self.rho.low) }
    }
}

/// The smallest of some numbers by their owner, and the smallest without that owner.
#[derive(Clone, Copy)]
struct Smallest {
    first: (f64, usize),
    second: f64,
}

impl Smallest {
    fn of(numbers: impl Iterator<Item = (f64, usize)>) -> Self {
        let none = Self { first: (f64::INFINITY, usize::MAX), second: f64::INFINITY };
        numbers.fold(none, |before, (number, owner)| {
            if number < before.first.0 {
                Self { first: (number, owner), second: before.first.0 }
            } else {
                Self { second: before.second.min(number), ..before }
            }
        })
    }

    /// The smallest that others own.
    fn without(self, owner: usize) -> f64 {
        if self.first.1 == owner { self.second } else { self.first.0 }
    }
}

/// Returns a pixel, as [`super::blend`]. A splat never hides itself. Those that count for sure have a mean; the others,
/// and what of the weights is not sure, move it toward other colors by no more than their share of the weight.
pub(crate) fn blend(list: &[Candidate], colors: &[DVec3], blend_depth: f64) -> (ColorRange, Range) {
    let ends = |f: &Candidate| (f.end(blend_depth), f.index);
    let may_hide = Smallest::of(list.iter().map(ends).map(|(end, index)| (end.low, index)));
    let hides = Smallest::of(list.iter().filter(|f| f.sure).map(ends).map(|(end, index)| (end.high, index)));
    let may_count = |f: &&Candidate| f.z.low <= hides.without(f.index);
    let counts = |f: &Candidate| f.sure && f.z.high <= may_hide.without(f.index);
    let (mut sum, mut total, mut open) = (DVec3::ZERO, 0.0, 0.0);
    for f in list.iter().filter(may_count) {
        let weight = f.weight();
        if counts(f) {
            sum += weight.low * colors[f.index];
            total += weight.low;
            open += weight.high - weight.low;
        } else {
            open += weight.high;
        }
    }
    let one = |is: bool| f64::from(u8::from(is));
    let alpha = Range { low: one(list.iter().any(|f| f.sure)), high: one(!list.is_empty()) };
    let mean = |c: usize| {
        let may_count = list.iter().filter(may_count).map(|f| Range::only(colors[f.index][c]));
        let nothing = (alpha.low == 0.0).then_some(NOTHING[c]);
        let Some(all) = may_count.chain(nothing).reduce(Range::hull) else { return NOTHING[c] };
        if total == 0.0 {
            return all;
        }
        let Range { low, high } = Range::around(sum[c] / total, (all.high - all.low) * open / (total + open));
        Range { low: low.max(all.low), high: high.min(all.high) }
    };
    ([mean(0), mean(1), mean(2), alpha], nearest(list))
}

/// Returns the smallest depth, +inf without a splat.
pub(crate) fn nearest(list: &[Candidate]) -> Range {
    list.iter().fold(Range::only(f64::INFINITY), |depth, f| {
        depth.least(if f.sure { f.z } else { Range { high: f64::INFINITY, ..f.z } })
    })
}

/// Returns the images that float32 may make of [`super::render`]'s. Arguments as there.
pub fn ranges(view: View, points: &Points, colors: &[DVec3], shape: Shape, settings: &BlendedSplats) -> PictureRange {
    let mut picture = PictureRange { width: view.size[0], ..PictureRange::default() };
    for_each_list(view, points, shape, &settings.splats, |list| {
        let (rgba, depth) = blend(list, colors, f64::from(settings.blend_depth));
        picture.push(rgba, depth, count(list));
    });
    picture
}

/// Returns the number of splats of a pixel.
pub(crate) fn count(list: &[Candidate]) -> Range {
    Range { low: list.iter().filter(|f| f.sure).count() as f64, high: list.len() as f64 }
}

/// Calls for each pixel, row by row, with what it may have: all lists together may be large.
pub(crate) fn for_each_list(
    view: View,
    points: &Points,
    shape: Shape,
    settings: &ScreenSplats,
    mut visit: impl FnMut(&[Candidate]),
) {
    let drawn: Vec<Splat> = (0..points.len()).map(|index| splat(view, points, index, shape, settings)).collect();
    for row in 0..view.size[1] {
        let mut lists = vec![Vec::new(); view.size[0] as usize];
        for (index, splat) in drawn.iter().enumerate() {
            for p in possible(view, splat, row..row + 1) {
                lists[p.x as usize].push(Candidate { z: p.z, rho: p.rho, radius: splat.radius, index, sure: p.sure });
            }
        }
        lists.iter().for_each(|list| visit(list));
    }
}
