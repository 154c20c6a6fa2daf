//! `peel-layers` where roundings of float32 decide.

use std::ops::Add;

use glam::DVec3;

use super::super::image_space::{LayerRange, count_of, nearest_ranges, rounded_distance};
use super::super::range::{NOTHING, PictureRange, ROUNDING, Range};
use crate::View;
use pellucid_core::points::Points;
use pellucid_scene::PeelLayers;

/// See [`super::layers`]. A layer of which only roundings say that something is in it is there.
fn layers(view: View, points: &Points, colors: &[DVec3], settings: &PeelLayers) -> Vec<LayerRange> {
    let filters = &settings.filters;
    let distance = rounded_distance(filters.min_layer_distance, points);
    let color = |index: usize| {
        let alpha = f64::from(points.opacities[index]);
        (alpha * colors[index]).extend(alpha).to_array()
    };
    let mut from = vec![Range::only(f64::NEG_INFINITY); view.pixels()];
    let mut layers = Vec::new();
    while layers.len() < settings.peeled() as usize {
        let found = nearest_ranges(view, points, filters.cull, &from, color);
        if found.depth.iter().all(|depth| depth.low.is_infinite()) {
            break;
        }
        let layer = found.filtered(filters, distance, view.camera.far);
        // The sum is rounded.
        let next = |depth: &Range| match depth.low {
            f64::INFINITY => *depth,
            low => (*depth + distance).widened(ROUNDING * (low.abs() + distance.high)),
        };
        from = layer.depth.iter().map(next).collect();
        layers.push(layer);
    }
    layers
}

/// Returns the images that float32 may make of [`super::render`]'s. Arguments as there.
pub fn ranges(view: View, points: &Points, colors: &[DVec3], settings: &PeelLayers) -> PictureRange {
    let layers = layers(view, points, colors, settings);
    let layers = super::shown(&layers, settings);
    let pixels = view.pixels();
    let mut picture = PictureRange { width: view.size[0], ..PictureRange::default() };
    for pixel in 0..pixels {
        let (mut rgba, mut transmittance) = (NOTHING, Range::only(1.0));
        for layer in layers {
            let front = layer.rgba[pixel];
            rgba = std::array::from_fn(|c| rgba[c] + transmittance.times(front[c]));
            transmittance = transmittance.times(front[3].complement());
        }
        let counts = layers.iter().map(|layer| count_of(layer.depth[pixel]));
        picture.push(rgba, depth_of(layers, pixel), counts.fold(Range::only(0.0), Range::add));
    }
    picture
}

/// The depth of the first layer with α > 0; each may be the first up to one that has it for sure.
fn depth_of(layers: &[LayerRange], pixel: usize) -> Range {
    let mut depth: Option<Range> = None;
    for layer in layers.iter().filter(|layer| layer.rgba[pixel][3].high > 0.0) {
        let own = layer.depth[pixel];
        depth = Some(depth.map_or(own, |depth| depth.hull(own)));
        if layer.rgba[pixel][3].low > 0.0 {
            return depth.unwrap_or(own);
        }
    }
    let none = Range::only(f64::INFINITY);
    depth.map_or(none, |depth| depth.hull(none))
}
