//! Opaque points, squares and circles: on each pixel the nearest splat wins.

use glam::DVec3;

use super::coverage::{Shape, Splat, footprint};
use super::{ReferencePicture, View};
use pellucid_core::points::Points;
use pellucid_scene::{Relief, ScreenSplats};

/// Returns the splat that an opaque method draws for a point: the radius times `size`, or `pixel_radius` at any depth,
/// clamped to `max_pixel_radius`.
pub fn splat(points: &Points, index: usize, shape: Shape, settings: &ScreenSplats) -> Splat {
    let largest = f64::from(settings.max_pixel_radius);
    let (radius, max_pixel_radius) = match settings.pixel_radius {
        // Without end in the world, so that the clamp alone decides.
        Some(pixels) => (f64::INFINITY, f64::from(pixels).min(largest)),
        None => (f64::from(points.radii[index]) * f64::from(settings.size), largest),
    };
    Splat { position: points.positions[index], radius, normal: None, shape, max_pixel_radius }
}

/// The displacement of a fragment toward the viewer, in drawn radii: w of Schütz and Wimmer 2015.
fn moved(relief: Relief, rho: f64) -> f64 {
    match relief {
        Relief::Flat => 0.0,
        Relief::Paraboloid => 1.0 - rho * rho,
        Relief::Cone => 1.0 - rho,
        Relief::Sphere => (1.0 - rho * rho).sqrt(),
    }
}

/// Returns the whole image: the smallest z wins, after fragments are displaced toward the viewer according to `relief`,
/// and the smaller index among equal ones; opacity is ignored. `colors` holds a color for each point, shaded and in the
/// color space of the image ([`super::shading::shade`]).
pub fn render(
    view: View,
    points: &Points,
    colors: &[DVec3],
    shape: Shape,
    settings: &ScreenSplats,
    relief: Relief,
) -> ReferencePicture {
    let mut nearest: Vec<Option<usize>> = vec![None; view.pixels()];
    let mut depth = vec![f64::INFINITY; view.pixels()];
    let mut counts = vec![0; view.pixels()];
    for index in 0..points.len() {
        let splat = splat(points, index, shape, settings);
        let at_center = view.pixels_per_unit(view.camera.to_view(splat.position).z);
        let radius = splat.radius.min(splat.max_pixel_radius / at_center);
        for pixel in footprint(view, &splat) {
            let z = pixel.z - moved(relief, pixel.rho) * radius;
            let at = view.index(pixel.x, pixel.y);
            counts[at] += 1;
            // Points come in the order of their index, so an equal depth leaves the smaller one in place.
            if z < depth[at] {
                depth[at] = z;
                nearest[at] = Some(index);
            }
        }
    }
    let rgba = nearest.iter().map(|&point| point.map_or([0.0; 4], |index| colors[index].extend(1.0).to_array()));
    ReferencePicture { width: view.size[0], height: view.size[1], rgba: rgba.collect(), depth, counts }
}
