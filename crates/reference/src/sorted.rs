//! Transparency of discs and Gaussians in the order of their centers: each pixel composes those that cover it by the
//! depth of their centers, or the distance, regardless of their depth in that pixel.

use glam::DVec3;

use super::fragments::{Fragment, before_end, composite, of_disc};
use super::{ReferencePicture, View, gaussians};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_scene::{Discs, GaussianSettings, Order};

/// Returns what this method orders Gaussians by. Each has one place for the whole image.
pub fn key(settings: &GaussianSettings) -> Order {
    match settings.order {
        Some(Order::Distance) => Order::Distance,
        _ => Order::Center,
    }
}

/// Returns the points by the depth of their centers along the viewing axis, Gaussians perhaps by their distance from
/// the eye; equal ones by their place in the canonical order.
pub fn order(camera: &Camera, points: &Points, settings: &GaussianSettings) -> Vec<usize> {
    let by_distance = key(settings) == Order::Distance && matches!(camera.projection, Projection::Perspective { .. });
    let key = |index: usize| {
        let position = points.positions[index];
        match by_distance && gaussians::gaussian(points, index).is_some() {
            true => position.distance(camera.eye),
            false => camera.to_view(position).z,
        }
    };
    let keys: Vec<f64> = (0..points.len()).map(key).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]).then(a.cmp(&b)));
    order
}

/// Returns fragments of each pixel in the order of their centers; z is the fragment's own depth in the pixel, of a
/// Gaussian that of its center.
pub fn lists(view: View, points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let mut pixels: Vec<Vec<Fragment>> = vec![Vec::new(); view.pixels()];
    for index in order(view.camera, points, &discs.gaussians) {
        if let Some(gaussian) = gaussians::gaussian(points, index) {
            let hits = gaussians::footprint(view, &gaussian, &discs.gaussians, key(&discs.gaussians));
            for hit in hits {
                let fragment = Fragment { z: hit.z, index: index as u32, alpha: hit.alpha };
                pixels[view.index(hit.x, hit.y)].push(fragment);
            }
            continue;
        }
        of_disc(view, points, index, discs).into_iter().for_each(|(at, fragment)| pixels[at].push(fragment));
    }
    pixels
}

/// Returns the whole image. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], discs: &Discs) -> ReferencePicture {
    let lists = lists(view, points, discs);
    let stop = gaussians::stop(points, &discs.gaussians);
    ReferencePicture::of_lists(view.size, &lists, |list| composite(before_end(list, stop), colors))
}
