//! Opaque points, squares and circles: on each pixel the nearest splat wins.

use glam::DVec3;

use super::Picture;
use super::coverage::{Shape, Splat, footprint};
use crate::camera::Camera;
use crate::points::Points;
use crate::scene::ScreenSplats;

/// The splat that an opaque method draws for a point: the radius times `size`, clamped to `max_pixel_radius`.
pub fn splat(points: &Points, index: usize, shape: Shape, settings: &ScreenSplats) -> Splat {
    Splat {
        position: points.positions[index],
        radius: f64::from(points.radii[index]) * f64::from(settings.size),
        normal: None,
        shape,
        max_pixel_radius: f64::from(settings.max_pixel_radius),
    }
}

/// The whole image: the smallest z wins, the smaller index among equal ones; opacity is ignored. `colors` holds a color
/// for each point, shaded and in the space that the image is in ([`super::shading::shade`]).
pub fn render(
    camera: &Camera,
    size: [u32; 2],
    points: &Points,
    colors: &[DVec3],
    shape: Shape,
    settings: &ScreenSplats,
) -> Picture {
    let pixels = size[0] as usize * size[1] as usize;
    let mut nearest: Vec<Option<usize>> = vec![None; pixels];
    let mut depth = vec![f64::INFINITY; pixels];
    let mut counts = vec![0; pixels];
    for index in 0..points.len() {
        for pixel in footprint(camera, size, &splat(points, index, shape, settings)) {
            let at = pixel.y as usize * size[0] as usize + pixel.x as usize;
            counts[at] += 1;
            // Points come in the order of their index, so an equal depth leaves the smaller one in place.
            if pixel.z < depth[at] {
                depth[at] = pixel.z;
                nearest[at] = Some(index);
            }
        }
    }
    let rgba = nearest.iter().map(|&point| point.map_or([0.0; 4], |index| colors[index].extend(1.0).to_array()));
    Picture { width: size[0], height: size[1], rgba: rgba.collect(), depth, counts }
}
