//! One-layer transparency where roundings of float32 decide: which splats count, which soft ones lie behind the layer,
//! and whether the layer lies before the solids.

use glam::DVec3;

use super::super::range::{ColorRange, PictureRange, Range, hull};
use super::super::splats::{Candidate, blend_ranges as blend, count, for_each_list, nearest};
use super::{is_soft, shape_of};
use crate::View;
use pellucid_core::points::Points;
use pellucid_scene::{BlendedSplats, OneLayer};

/// Returns the images that float32 may make of [`super::render`]'s. Arguments as there.
pub fn ranges(view: View, points: &Points, colors: &[DVec3], settings: &OneLayer) -> PictureRange {
    let splats = BlendedSplats::default();
    let blend_depth = f64::from(splats.blend_depth);
    let mut picture = PictureRange { width: view.size[0], ..PictureRange::default() };
    for_each_list(view, points, shape_of(points), &splats.splats, |list| {
        let (soft, solid): (Vec<Candidate>, Vec<Candidate>) =
            list.iter().partition(|f| is_soft(points, f.index, settings.threshold));
        let (rgba, depth) = pixel(&soft, &solid, colors, f64::from(settings.softness), blend_depth);
        picture.push(rgba, depth, count(list));
    });
    picture
}

/// See [`super::Parts::blend`].
fn pixel(
    soft: &[Candidate],
    solid: &[Candidate],
    colors: &[DVec3],
    softness: f64,
    blend_depth: f64,
) -> (ColorRange, Range) {
    let (layer, layer_depth) = blend(soft, colors, blend_depth);
    let behind = soft.iter().filter_map(|f| {
        let end = f.behind(layer_depth, blend_depth);
        (f.z.high > end.low).then_some(Candidate { sure: f.sure && f.z.low > end.high, ..*f })
    });
    let others: Vec<Candidate> = solid.iter().copied().chain(behind).collect();
    let rest = blend(&others, colors, blend_depth);
    let solid_depth = nearest(solid);
    if layer_depth.low.is_infinite() || solid_depth.high <= layer_depth.low {
        return rest;
    }
    // Opaque where the rest is.
    let alpha = |rest: f64| if rest > 0.0 { 1.0 } else { softness };
    let [low, high] = [rest.0[3].low, rest.0[3].high].map(alpha);
    let layered: ColorRange = std::array::from_fn(|c| match c {
        3 => Range { low: low.min(high), high: low.max(high) },
        _ => layer[c].scaled(softness) + rest.0[c].scaled(1.0 - softness),
    });
    let depth = if softness > 0.0 { layer_depth } else { rest.1 };
    let is_layered = layer_depth.high.is_finite() && solid_depth.low > layer_depth.high;
    if is_layered { (layered, depth) } else { (hull(layered, rest.0), depth.hull(rest.1)) }
}
