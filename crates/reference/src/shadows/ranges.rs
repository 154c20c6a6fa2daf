//! Shadow textures where roundings of float32 decide: on which pixel of a light's image a point lies, which of two is
//! nearer to the light, which is occluded there, where d̃ ends, and on which of two faces of a cube a point is.

use glam::DVec3;

use super::super::image_space::{Home, homes, nearest_ranges};
use super::super::range::{ROUNDING, Range};
use super::{Frames, LEAST_COS, Map};
use crate::View;
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;

/// Returns the m of each point that float32 may find. Arguments as those of [`super::shares`], of at least one light.
pub fn share_ranges(lights: &[Frames], map: Map, points: &Points) -> Vec<Range> {
    let mut sums = vec![Range::only(0.0); points.len()];
    for light in lights {
        let lit = lit(light, map, points);
        sums.iter_mut().zip(lit).for_each(|(sum, lit)| *sum = *sum + lit);
    }
    sums.into_iter().map(|sum| sum.scaled(1.0 / lights.len() as f64)).collect()
}

/// 1 for the points that a light reaches, 0 for those in its shadow.
fn lit(light: &[Camera], map: Map, points: &Points) -> Vec<Range> {
    let distance = Range::around(map.distance, ROUNDING * map.distance);
    let images: Vec<Vec<Range>> = light.iter().map(|camera| depths(camera, map, points, distance)).collect();
    let lit = |index: usize| {
        let position = points.positions[index];
        let seen = light.iter().zip(&images).flat_map(|(camera, depths)| {
            let limit = reach(points, index, camera, distance);
            let homes = homes(View::new(camera, [map.resolution; 2]), position);
            homes.into_iter().map(move |home| (home, is_lit(home, depths[home.pixel], limit)))
        });
        let seen: Vec<(Home, Range)> = seen.collect();
        let farthest = seen.iter().map(|(home, _)| home.z.low).fold(f64::NEG_INFINITY, f64::max);
        let own = seen.iter().filter(|(home, _)| home.z.high >= farthest).map(|(_, lit)| *lit);
        own.reduce(Range::hull).unwrap_or(Range::only(1.0))
    };
    (0..points.len()).map(lit).collect()
}

/// See [`super::reference_depths`].
fn depths(camera: &Camera, map: Map, points: &Points, distance: Range) -> Vec<Range> {
    let view = View::new(camera, [map.resolution; 2]);
    let everything = vec![Range::only(f64::NEG_INFINITY); view.pixels()];
    let nearest = nearest_ranges(view, points, false, &everything, |_| [0.0; 4]);
    let filled = (0..map.fill).fold(nearest, |layer, _| layer.filled());
    (0..map.occlusion).fold(filled, |layer, _| layer.occluded_replaced(distance)).depth
}

/// Distance behind the reference depth a point is lit: `distance` / max(|n_z|, 0.1). The cosine is a sum of three
/// products with a rounded axis, which leaves four roundings of the product of lengths, and the normal's own length is
/// off by one; the quotient brings another.
fn reach(points: &Points, index: usize, camera: &Camera, distance: Range) -> Range {
    let normal = points.own_normal(index).and_then(|normal| normal.as_dvec3().try_normalize());
    let cos = normal.map_or(Range::only(1.0), |n: DVec3| {
        let cos = Range::around(n.dot(camera.forward).abs(), 5.0 * ROUNDING);
        Range { low: cos.low.max(LEAST_COS), high: cos.high.max(LEAST_COS) }
    });
    let reach = Range { low: distance.low / cos.high, high: distance.high / cos.low };
    // One for the quotient, one for 0.1.
    reach.widened(2.0 * ROUNDING * reach.high)
}

/// The sum of reference depth and reach is rounded.
fn is_lit(home: Home, depth: Range, reach: Range) -> Range {
    let end = depth + reach;
    let error = if end.is_finite() { ROUNDING * end.high.abs() } else { 0.0 };
    let is = |lit: bool| f64::from(u8::from(lit));
    Range { low: is(home.z.high <= end.low - error), high: is(home.z.low <= end.high + error) }
}
