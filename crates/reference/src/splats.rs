//! Opaque splats blended in three passes (`hqs`, `splats`; Botsch, Spernat, Kobbelt 2004): the combined result of
//! visibility, attributes and normalization. [`super::opaque`] covers opaque splats where only the nearest one counts.

mod ranges;

use glam::DVec3;

pub use ranges::ranges;
pub(super) use ranges::{Candidate, blend as blend_ranges, count, for_each_list, nearest};

use super::coverage::{Coverage, Shape, Splat, footprint};
use super::fragments::Composite;
use super::{ReferencePicture, View};
use pellucid_core::points::Points;
use pellucid_scene::{BlendedSplats, ScreenSplats};

/// A splat on a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Depth along the viewing axis, in the tangent plane if the splat is oriented.
    pub z: f64,
    /// Distance from the center over the drawn radius, at most 1.
    pub rho: f64,
    /// The drawn radius in world units: after `size` and the clamp.
    pub radius: f64,
    /// The point's place in the canonical order.
    pub index: usize,
}

/// Returns the splat that is drawn for a point. The clamp in pixels, at the depth of the center, is put into the world
/// radius, so that it holds for a disc in the tangent plane too.
pub fn splat(view: View, points: &Points, index: usize, shape: Shape, settings: &ScreenSplats) -> Splat {
    let position = points.positions[index];
    let most = f64::from(settings.max_pixel_radius) / view.pixels_per_unit(view.camera.to_view(position).z).abs();
    Splat {
        position,
        radius: (f64::from(points.radii[index]) * f64::from(settings.size)).min(most),
        normal: points.own_normal(index).map(|normal| normal.as_dvec3()),
        shape,
        max_pixel_radius: f64::INFINITY,
    }
}

/// Returns the fragments of each pixel, in the order of their points, of those points that `wanted` picks.
pub fn lists(
    view: View,
    points: &Points,
    shape: Shape,
    settings: &ScreenSplats,
    wanted: impl Fn(usize) -> bool,
) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); view.pixels()];
    for index in (0..points.len()).filter(|index| wanted(*index)) {
        let splat = splat(view, points, index, shape, settings);
        for Coverage { x, y, z, rho } in footprint(view, &splat) {
            pixels[view.index(x, y)].push(Fragment { z, rho, radius: splat.radius, index });
        }
    }
    pixels
}

/// Returns the depth beyond which fragments are occluded: min(zᵢ + `blend_depth`·rᵢ), +inf for no fragments.
pub fn limit(list: &[Fragment], blend_depth: f64) -> f64 {
    list.iter().map(|f| f.z + blend_depth * f.radius).fold(f64::INFINITY, f64::min)
}

/// Returns a pixel: Σwᵢcᵢ / Σwᵢ, w = exp(−2ρ²), of the visible fragments; A = 1 where at least one exists, and the
/// smallest z.
pub fn blend(list: &[Fragment], colors: &[DVec3], blend_depth: f64) -> Composite {
    let limit = limit(list, blend_depth);
    let seen = || list.iter().filter(|f| f.z <= limit);
    let weight = |f: &Fragment| (-2.0 * f.rho * f.rho).exp();
    let total: f64 = seen().map(weight).sum();
    let sum: DVec3 = seen().map(|f| weight(f) * colors[f.index]).sum();
    let depth = seen().map(|f| f.z).fold(f64::INFINITY, f64::min);
    if total > 0.0 {
        Composite { color: sum / total, alpha: 1.0, depth }
    } else {
        Composite { depth, ..Composite::NOTHING }
    }
}

/// Returns the whole image, screen-aligned ([`Shape::Disc`]) or in the tangent planes ([`Shape::Oriented`]); opacity is
/// ignored. `colors` holds a color for each point, shaded and in the space that the image is in
/// ([`super::shading::shade`]).
pub fn render(
    view: View,
    points: &Points,
    colors: &[DVec3],
    shape: Shape,
    settings: &BlendedSplats,
) -> ReferencePicture {
    let lists = lists(view, points, shape, &settings.splats, |_| true);
    let blend_depth = f64::from(settings.blend_depth);
    ReferencePicture::of_lists(view.size, &lists, |list| blend(list, colors, blend_depth))
}
