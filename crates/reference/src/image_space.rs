//! `image-space` (Dobrev, Rosenthal, Linsen 2010, Section 3): points on one pixel each, then image filters that close
//! holes, replace occluded points seen through holes, smooth, and soften edges.
//!
//! Depths are z in world units, +∞ for background; colors are premultiplied by alpha, background is all 0. Pixels
//! outside of the image count as background. A filter reads one complete image and writes another.

mod ranges;

use glam::DVec3;

pub use ranges::{Home, LayerRange, count_of, homes, nearest as nearest_ranges, ranges, rounded_distance};

use super::coverage::{Shape, Splat, footprint};
use super::{ReferencePicture, View};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_scene::{ImageSpace, Iterations};

/// A layer of points, the input and output of the filters.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Columns and rows.
    pub size: [u32; 2],
    /// z per pixel, row by row from the top; +∞ for background.
    pub depth: Vec<f64>,
    /// Premultiplied color and alpha.
    pub rgba: Vec<[f64; 4]>,
}

/// The ring of eight neighbors as offsets (right, down), in the order of their angle.
const RING: [[i64; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]];
/// The neighbors that share an edge with the pixel.
const EDGES: [[i64; 2]; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];

/// The index of a neighbor; `None` outside of the image.
fn neighbor(size: [u32; 2], pixel: usize, [right, down]: [i64; 2]) -> Option<usize> {
    let [width, height] = size.map(i64::from);
    let (x, y) = (pixel as i64 % width + right, pixel as i64 / width + down);
    (x >= 0 && y >= 0 && x < width && y < height).then_some((y * width + x) as usize)
}

/// Returns `true` if one of the eight masks of Figure 3 matches: five consecutive neighbors of the ring are set.
fn is_ring_masked(ring: [bool; 8]) -> bool {
    (0..8).any(|start| (start..start + 5).all(|i| ring[i % 8]))
}

impl Layer {
    fn neighbor_depth(&self, pixel: usize, offset: [i64; 2]) -> f64 {
        neighbor(self.size, pixel, offset).map_or(f64::INFINITY, |at| self.depth[at])
    }

    /// Returns `true` if a mask matches neighbors that are `beyond`.
    fn is_masked(&self, pixel: usize, beyond: impl Fn(f64) -> bool) -> bool {
        is_ring_masked(RING.map(|offset| beyond(self.neighbor_depth(pixel, offset))))
    }

    /// The pixel of the 3×3 stencil with the smallest depth; equal depths by color. Itself if all are background.
    fn nearest(&self, pixel: usize) -> usize {
        let rank = |at: &usize| (self.depth[*at], self.rgba[*at]);
        let before = |a: &usize, b: &usize| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal);
        let ring = RING.iter().filter_map(|offset| neighbor(self.size, pixel, *offset));
        ring.chain([pixel]).min_by(before).unwrap_or(pixel)
    }

    /// Each pixel with the values of the pixel that `from` names for it.
    fn taken(&self, from: impl Fn(usize) -> usize) -> Self {
        let sources: Vec<usize> = (0..self.depth.len()).map(from).collect();
        Self {
            size: self.size,
            depth: sources.iter().map(|&at| self.depth[at]).collect(),
            rgba: sources.iter().map(|&at| self.rgba[at]).collect(),
        }
    }

    /// Section 3.2: a background pixel that no mask of background keeps takes the values of its nearest neighbor.
    pub fn filled(&self) -> Self {
        self.taken(|pixel| {
            let stays = self.depth[pixel].is_finite() || self.is_masked(pixel, f64::is_infinite);
            if stays { pixel } else { self.nearest(pixel) }
        })
    }

    /// Section 3.3: a pixel of depth d that no mask of neighbors beyond d − `distance` keeps is one that is seen
    /// through a hole, and takes the values of the nearest in the stencil. Background stays.
    pub fn occluded_replaced(&self, distance: f64) -> Self {
        self.taken(|pixel| {
            let d = self.depth[pixel];
            // Points at the same depth never occlude, however small the distance is.
            let floor = (d - distance).min(d.next_down());
            let stays = d.is_infinite() || self.is_masked(pixel, |depth| depth > floor);
            if stays { pixel } else { self.nearest(pixel) }
        })
    }

    /// Section 3.4, Table 1: the alleviated Gaussian 16, 2, 1 over what is not background, normalized by the weights
    /// that took part. Depths stay.
    pub fn smoothed(&self) -> Self {
        let smooth = |pixel: usize| {
            if self.depth[pixel].is_infinite() {
                return self.rgba[pixel];
            }
            let weighted = RING.map(|offset| {
                let weight = if EDGES.contains(&offset) { 2.0 } else { 1.0 };
                (neighbor(self.size, pixel, offset), weight)
            });
            let used = weighted.into_iter().chain([(Some(pixel), 16.0)]);
            let used: Vec<(usize, f64)> = used
                .filter_map(|(at, weight)| Some((at?, weight)))
                .filter(|(at, _)| self.depth[*at].is_finite())
                .collect();
            let total: f64 = used.iter().map(|(_, weight)| weight).sum();
            std::array::from_fn(|c| used.iter().map(|&(at, weight)| weight * self.rgba[at][c]).sum::<f64>() / total)
        };
        Self { rgba: (0..self.depth.len()).map(smooth).collect(), ..self.clone() }
    }

    /// Returns the strength of a depth edge at a pixel (Section 3.5, Table 2): t = min(1, |L| / (4·`distance`)) with L
    /// = 4d − Σ of the four edge neighbors' depths, background at `far`.
    pub fn edge(&self, pixel: usize, distance: f64, far: f64) -> f64 {
        let known = |depth: f64| if depth.is_finite() { depth } else { far };
        let around: f64 = EDGES.iter().map(|offset| known(self.neighbor_depth(pixel, *offset))).sum();
        ((4.0 * known(self.depth[pixel]) - around).abs() / (4.0 * distance)).min(1.0)
    }

    /// Section 3.5: where [`Layer::edge`] is at least `threshold`, (1 − t/2)·own + (t/2)·mean of the four edge
    /// neighbors, color and alpha, of background too. Depths stay.
    pub fn antialiased(&self, distance: f64, far: f64, threshold: f64) -> Self {
        let soften = |pixel: usize| {
            let t = self.edge(pixel, distance, far);
            let own = self.rgba[pixel];
            if t < threshold {
                return own;
            }
            let around = EDGES.map(|offset| neighbor(self.size, pixel, offset).map_or([0.0; 4], |at| self.rgba[at]));
            let mean = |c: usize| around.iter().map(|rgba| rgba[c]).sum::<f64>() / 4.0;
            std::array::from_fn(|c| (1.0 - 0.5 * t) * own[c] + 0.5 * t * mean(c))
        };
        Self { rgba: (0..self.depth.len()).map(soften).collect(), ..self.clone() }
    }

    /// Returns all filters in their order; `far` is the camera's.
    pub fn filtered(self, filters: &ImageSpace, distance: f64, far: f64) -> Self {
        let soften = |layer: &Self, threshold| layer.antialiased(distance, far, threshold);
        in_order(self, filters, Self::filled, |layer| layer.occluded_replaced(distance), Self::smoothed, soften)
    }
}

/// Returns a layer after all filters in their order. `soften` has the threshold of edges.
fn in_order<L: PartialEq>(
    mut layer: L,
    filters: &ImageSpace,
    fill: impl Fn(&L) -> L,
    replace: impl Fn(&L) -> L,
    smooth: impl Fn(&L) -> L,
    soften: impl Fn(&L, f64) -> L,
) -> L {
    layer = iterated(layer, filters.fill, fill);
    layer = iterated(layer, filters.occlusion, replace);
    (0..filters.smooth).for_each(|_| layer = smooth(&layer));
    if filters.antialias { soften(&layer, f64::from(filters.antialias_threshold)) } else { layer }
}

/// Returns a layer after some iterations of a filter.
fn iterated<L: PartialEq>(mut layer: L, iterations: Iterations, filter: impl Fn(&L) -> L) -> L {
    for _ in 0..iterations.most() {
        let next = filter(&layer);
        if iterations == Iterations::Auto && next == layer {
            break;
        }
        layer = next;
    }
    layer
}

/// n·v of a point, v toward the viewer and of any length: a point is culled unless it is positive. `None` without a
/// normal.
pub fn facing(camera: &Camera, position: DVec3, normal: DVec3) -> Option<f64> {
    let to_viewer = match camera.projection {
        Projection::Perspective { .. } => camera.eye - position,
        Projection::Orthographic { .. } => -camera.forward,
    };
    (normal != DVec3::ZERO).then(|| normal.dot(to_viewer))
}

/// Returns `true` if a point is culled.
fn is_turned_away(camera: &Camera, points: &Points, index: usize) -> bool {
    let normal = points.own_normal(index).map_or(DVec3::ZERO, |normal| normal.as_dvec3());
    facing(camera, points.positions[index], normal).is_some_and(|cos| cos <= 0.0)
}

/// Returns the smallest depth between two layers in world units: the one that is set, else 1% of the diagonal of the
/// points' box.
pub fn layer_distance(set: Option<f32>, points: &Points) -> f64 {
    set.map_or_else(|| 0.01 * points.bounds().map_or(0.0, |bounds| bounds.diagonal()), f64::from)
}

/// Returns the footprint of a point: its pixel.
pub fn splat(points: &Points, index: usize) -> Splat {
    Splat::facing(points.positions[index], 0.0, Shape::Point)
}

/// Returns the nearest point of each pixel with a depth of at least `from[pixel]`, with that depth; the smaller index
/// among equals. `cull`: points whose normal looks away from the viewer are left out.
pub fn nearest(view: View, points: &Points, cull: bool, from: &[f64]) -> Vec<Option<(f64, usize)>> {
    let mut found: Vec<Option<(f64, usize)>> = vec![None; view.pixels()];
    for index in 0..points.len() {
        if cull && is_turned_away(view.camera, points, index) {
            continue;
        }
        for pixel in footprint(view, &splat(points, index)) {
            let at = view.index(pixel.x, pixel.y);
            if pixel.z >= from[at] && found[at].is_none_or(|(z, _)| pixel.z < z) {
                found[at] = Some((pixel.z, index));
            }
        }
    }
    found
}

/// Returns the points found as a layer; `alpha` of a point by its index.
pub fn layer(size: [u32; 2], found: &[Option<(f64, usize)>], colors: &[DVec3], alpha: impl Fn(usize) -> f64) -> Layer {
    let color = |index: usize| (alpha(index) * colors[index]).extend(alpha(index)).to_array();
    Layer {
        size,
        depth: found.iter().map(|point| point.map_or(f64::INFINITY, |(z, _)| z)).collect(),
        rgba: found.iter().map(|point| point.map_or([0.0; 4], |(_, index)| color(index))).collect(),
    }
}

/// Returns the whole image; opacity is ignored, and a pixel counts one where it is not background after the filters.
/// `colors` holds a color for each point, shaded and in the space that the image is in ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], filters: &ImageSpace) -> ReferencePicture {
    let everything = vec![f64::NEG_INFINITY; view.pixels()];
    let found = nearest(view, points, filters.cull, &everything);
    let distance = layer_distance(filters.min_layer_distance, points);
    let layer = layer(view.size, &found, colors, |_| 1.0).filtered(filters, distance, view.camera.far);
    let counts = layer.depth.iter().map(|depth| u32::from(depth.is_finite())).collect();
    ReferencePicture { width: view.size[0], height: view.size[1], rgba: layer.rgba, depth: layer.depth, counts }
}
