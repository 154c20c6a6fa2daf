//! `image-space` where roundings of float32 decide: of two points the nearer one, whether a neighbor lies more than d̃
//! before a pixel, whether an edge is as strong as the threshold.
//!
//! Points have to be clear of what decides whether they are drawn at all: near and far, and the turn of their normals.

use glam::DVec3;

use super::super::coverage::is_in_depth;
use super::super::range::{ColorRange, NOTHING, PictureRange, ROUNDING, Range, hull, screen_error};
use super::{EDGES, RING, in_order, is_ring_masked, is_turned_away, layer_distance, neighbor};
use crate::View;
use pellucid_core::points::Points;
use pellucid_scene::ImageSpace;

/// The counterpart of [`super::Layer`]. A depth whose high end is +∞ may be background.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerRange {
    /// Columns and rows.
    pub size: [u32; 2],
    /// z per pixel.
    pub depth: Vec<Range>,
    /// Premultiplied color and alpha.
    pub rgba: Vec<ColorRange>,
}

/// Place where a point may show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Home {
    /// The pixel, row by row.
    pub pixel: usize,
    /// Depth of the splat.
    pub z: Range,
    /// False if it may be on another pixel.
    pub sure: bool,
}

/// Returns the pixels of a point: one, or several if it lies on their border as closely as that is computed.
pub fn homes(view: View, position: DVec3) -> Vec<Home> {
    let (at, z) = view.camera.project(position, view.size);
    if !position.is_finite() || !is_in_depth(view.camera, z) {
        return Vec::new();
    }
    let reach = |axis: usize| {
        let error = screen_error(at[axis], view.size[axis]);
        // Beyond the image all pixels are one.
        [at[axis] - error, at[axis] + error].map(|at| (at.floor() as i64).clamp(-1, i64::from(view.size[axis])))
    };
    let [columns, rows] = [reach(0), reach(1)];
    let sure = columns[0] == columns[1] && rows[0] == rows[1];
    let [width, height] = view.size.map(i64::from);
    let inside = |x: i64, y: i64| (0..width).contains(&x) && (0..height).contains(&y);
    let all = (rows[0]..=rows[1]).flat_map(|y| (columns[0]..=columns[1]).map(move |x| (x, y)));
    let seen = all.filter(|(x, y)| inside(*x, *y));
    seen.map(|(x, y)| Home { pixel: (y * width + x) as usize, z: Range::depth(z), sure }).collect()
}

/// Returns the nearest points with a depth of at least `from`. `color` is that of a point by its index, premultiplied.
pub fn nearest(
    view: View,
    points: &Points,
    cull: bool,
    from: &[Range],
    color: impl Fn(usize) -> [f64; 4],
) -> LayerRange {
    let mut candidates: Vec<Vec<(Home, usize)>> = vec![Vec::new(); from.len()];
    for index in 0..points.len() {
        if cull && is_turned_away(view.camera, points, index) {
            continue;
        }
        for home in homes(view, points.positions[index]) {
            let limit = from[home.pixel];
            if home.z.high >= limit.low {
                let sure = home.sure && home.z.low >= limit.high;
                candidates[home.pixel].push((Home { sure, ..home }, index));
            }
        }
    }
    let pixels = candidates.iter().map(|candidates| {
        let sure = candidates.iter().filter(|(home, _)| home.sure);
        let behind = sure.map(|(home, _)| home.z.high).fold(f64::INFINITY, f64::min);
        let seen = candidates.iter().filter(|(home, _)| home.z.low <= behind);
        let nearest = seen.clone().map(|(home, _)| home.z.low).fold(f64::INFINITY, f64::min);
        let nothing = behind.is_infinite().then_some(NOTHING);
        let colors = seen.map(|(_, index)| color(*index).map(Range::only));
        let depth = Range { low: nearest, high: behind };
        (depth, colors.chain(nothing).reduce(hull).unwrap_or(NOTHING))
    });
    let (depth, rgba) = pixels.unzip();
    LayerRange { size: view.size, depth, rgba }
}

/// The outcome of a decision: for sure, or perhaps.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Decided {
    Yes,
    No,
    Open,
}

impl Decided {
    fn of(surely: bool, perhaps: bool) -> Self {
        match (surely, perhaps) {
            (true, _) => Self::Yes,
            (false, true) => Self::Open,
            (false, false) => Self::No,
        }
    }
}

impl LayerRange {
    fn neighbor_depth(&self, pixel: usize, offset: [i64; 2]) -> Range {
        neighbor(self.size, pixel, offset).map_or(Range::only(f64::INFINITY), |at| self.depth[at])
    }

    /// Tells if one of the eight masks keeps a pixel, of neighbors that lie beyond a depth.
    fn is_masked(&self, pixel: usize, floor: Range) -> Decided {
        let ring = RING.map(|offset| self.neighbor_depth(pixel, offset));
        Decided::of(is_ring_masked(ring.map(|z| z.low > floor.high)), is_ring_masked(ring.map(|z| z.high > floor.low)))
    }

    /// The values of the pixel of the 3×3 stencil with the smallest depth.
    fn nearest(&self, pixel: usize) -> (Range, ColorRange) {
        let around = RING.iter().filter_map(|offset| neighbor(self.size, pixel, *offset)).chain([pixel]);
        let depth = around.clone().map(|at| self.depth[at]).reduce(Range::least).unwrap_or(self.depth[pixel]);
        let nearest = around.filter(|at| self.depth[*at].low <= depth.high);
        (depth, nearest.map(|at| self.rgba[at]).reduce(hull).unwrap_or(NOTHING))
    }

    /// Pixels that are kept as they are, and the others with the values of the nearest around them.
    fn replaced(&self, is_kept: impl Fn(usize) -> Decided) -> Self {
        let pixel = |pixel: usize| {
            let own = (self.depth[pixel], self.rgba[pixel]);
            let (depth, rgba) = self.nearest(pixel);
            match is_kept(pixel) {
                Decided::Yes => own,
                Decided::No => (depth, rgba),
                Decided::Open => (own.0.hull(depth), hull(own.1, rgba)),
            }
        };
        let (depth, rgba) = (0..self.depth.len()).map(pixel).unzip();
        Self { size: self.size, depth, rgba }
    }

    /// See [`super::Layer::filled`].
    pub fn filled(&self) -> Self {
        // Beyond the largest number is background alone.
        let finite = Range::only(f64::MAX);
        self.replaced(|pixel| {
            let Range { low, high } = self.depth[pixel];
            match (low.is_finite(), high.is_finite()) {
                (_, true) => Decided::Yes,
                (false, _) => self.is_masked(pixel, finite),
                (true, false) if self.is_masked(pixel, finite) == Decided::Yes => Decided::Yes,
                (true, false) => Decided::Open,
            }
        })
    }

    /// See [`super::Layer::occluded_replaced`]. The difference of depth and `distance` is rounded.
    pub fn occluded_replaced(&self, distance: Range) -> Self {
        self.replaced(|pixel| {
            let own = self.depth[pixel];
            if own.low.is_infinite() {
                return Decided::Yes;
            }
            let floor = Range { low: own.low - distance.high, high: own.high - distance.low };
            let floor = floor.widened(ROUNDING * own.low.abs().max(distance.high));
            let kept = self.is_masked(pixel, Range { low: floor.low, high: floor.high.min(own.high) });
            // Perhaps background, which stays.
            if own.high.is_infinite() && kept == Decided::No { Decided::Open } else { kept }
        })
    }

    /// See [`super::Layer::smoothed`].
    pub fn smoothed(&self) -> Self {
        let smooth = |pixel: usize| {
            let own = self.depth[pixel];
            if own.low.is_infinite() {
                return self.rgba[pixel];
            }
            let ring = RING.iter().filter_map(|offset| {
                let weight = if EDGES.contains(offset) { 2.0 } else { 1.0 };
                Some((neighbor(self.size, pixel, *offset)?, weight))
            });
            let used = ring.chain([(pixel, 16.0)]).filter(|(at, _)| self.depth[*at].low.is_finite());
            // A mean lies between what it is made of, whatever takes part.
            if used.clone().any(|(at, _)| self.depth[at].high.is_infinite()) {
                return used.map(|(at, _)| self.rgba[at]).reduce(hull).unwrap_or(NOTHING);
            }
            let total: f64 = used.clone().map(|(_, weight)| weight).sum();
            let sum = |c: usize| {
                used.clone().fold(Range::only(0.0), |sum, (at, weight)| sum + self.rgba[at][c].scaled(weight / total))
            };
            std::array::from_fn(sum)
        };
        Self { rgba: (0..self.depth.len()).map(smooth).collect(), ..self.clone() }
    }

    /// See [`super::Layer::edge`]. Four sums are rounded, none of them larger than all depths together; distance, its
    /// multiple, the quotient and far bring a rounding each.
    pub fn edge(&self, pixel: usize, distance: Range, far: f64) -> Range {
        let far = Range::around(far, ROUNDING * far);
        let known = |depth: Range| match (depth.low.is_finite(), depth.high.is_finite()) {
            (true, true) => depth,
            (true, false) => depth.hull(far).least(Range::only(f64::MAX)),
            _ => far,
        };
        let own = known(self.depth[pixel]).scaled(4.0);
        let around =
            EDGES.iter().fold(Range::only(0.0), |sum, offset| sum + known(self.neighbor_depth(pixel, *offset)));
        let error = 4.0 * ROUNDING * (own.high + around.high);
        let [low, high] = [own.low - around.high - error, own.high - around.low + error];
        let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        let share = |edge: f64, distance: f64, error: f64| (edge / (4.0 * distance) * (1.0 + error)).min(1.0);
        Range {
            low: share(least, distance.high, -4.0 * ROUNDING),
            high: share(low.abs().max(high.abs()), distance.low, 4.0 * ROUNDING),
        }
    }

    /// See [`super::Layer::antialiased`].
    pub fn antialiased(&self, distance: Range, far: f64, threshold: f64) -> Self {
        let soften = |pixel: usize| {
            let t = self.edge(pixel, distance, far);
            let own = self.rgba[pixel];
            let around = EDGES.map(|offset| neighbor(self.size, pixel, offset).map_or(NOTHING, |at| self.rgba[at]));
            let mixed = std::array::from_fn(|c| {
                let mean = around.iter().fold(Range::only(0.0), |sum, rgba| sum + rgba[c]).scaled(0.25);
                let at = |t: f64| own[c].scaled(1.0 - 0.5 * t) + mean.scaled(0.5 * t);
                at(t.low).hull(at(t.high))
            });
            match Decided::of(t.low >= threshold, t.high >= threshold) {
                Decided::Yes => mixed,
                Decided::No => own,
                Decided::Open => hull(own, mixed),
            }
        };
        Self { rgba: (0..self.depth.len()).map(soften).collect(), ..self.clone() }
    }

    /// See [`super::Layer::filtered`].
    pub fn filtered(self, filters: &ImageSpace, distance: Range, far: f64) -> Self {
        let soften = |layer: &Self, threshold| layer.antialiased(distance, far, threshold);
        in_order(self, filters, Self::filled, |layer| layer.occluded_replaced(distance), Self::smoothed, soften)
    }
}

/// [`layer_distance`] as float32 has it.
pub fn rounded_distance(set: Option<f32>, points: &Points) -> Range {
    let distance = layer_distance(set, points);
    Range::around(distance, ROUNDING * distance)
}

/// Returns the images that float32 may make of [`super::render`]'s. Arguments as there.
pub fn ranges(view: View, points: &Points, colors: &[DVec3], filters: &ImageSpace) -> PictureRange {
    let everything = vec![Range::only(f64::NEG_INFINITY); view.pixels()];
    let color = |index: usize| colors[index].extend(1.0).to_array();
    let found = nearest(view, points, filters.cull, &everything, color);
    let distance = rounded_distance(filters.min_layer_distance, points);
    let layer = found.filtered(filters, distance, view.camera.far);
    let counts = layer.depth.iter().map(|depth| count_of(*depth)).collect();
    PictureRange { width: view.size[0], rgba: layer.rgba, depth: layer.depth, counts }
}

/// 1 where something is, 0 for background.
pub fn count_of(depth: Range) -> Range {
    let one = |depth: f64| f64::from(u8::from(depth.is_finite()));
    Range { low: one(depth.high), high: one(depth.low) }
}
