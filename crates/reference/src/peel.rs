//! Depth peeling of discs and Gaussians: layer after layer, on each pixel the nearest fragment behind the last one that
//! was peeled.

use glam::DVec3;

use super::abuffer::of_point;
use super::fragments::{Fragment, before_end};
use super::{ReferencePicture, gaussians};
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_scene::Discs;

/// Returns fragments of each pixel in the order of the points, unsorted by depth.
pub fn fragments(camera: &Camera, size: [u32; 2], points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); size[0] as usize * size[1] as usize];
    for index in 0..points.len() {
        for (at, fragment) in of_point(camera, size, points, index, discs) {
            pixels[at].push(fragment);
        }
    }
    pixels
}

/// Returns the nearest fragment behind `last`, or of all without one: the smallest (z, index) greater than the last
/// one's. The index separates fragments at equal depth.
pub fn next(fragments: &[Fragment], last: Option<Fragment>) -> Option<Fragment> {
    let rank = |f: &Fragment| (f.z, f.index);
    let behind = fragments.iter().filter(|f| last.is_none_or(|last| rank(f) > rank(&last)));
    behind.copied().min_by(|a, b| a.z.total_cmp(&b.z).then(a.index.cmp(&b.index)))
}

/// Returns up to `layers` fragments of a pixel in peeling order, nearest first; 0 peels all.
pub fn peel(fragments: &[Fragment], layers: u32) -> Vec<Fragment> {
    let mut peeled: Vec<Fragment> = Vec::new();
    while layers == 0 || peeled.len() < layers as usize {
        match next(fragments, peeled.last().copied()) {
            Some(fragment) => peeled.push(fragment),
            None => break,
        }
    }
    peeled
}

/// Returns the whole image from at most `layers` layers (0: all of them); its counts are those of the layers that were
/// blended. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(
    camera: &Camera,
    size: [u32; 2],
    points: &Points,
    colors: &[DVec3],
    discs: &Discs,
    layers: u32,
) -> ReferencePicture {
    let (mut rgba, mut depth, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    let stop = gaussians::stop(points, &discs.gaussians);
    for pixel in fragments(camera, size, points, discs) {
        let all = peel(&pixel, layers);
        let peeled = before_end(&all, stop);
        let mut color = DVec3::ZERO;
        let mut transmittance = 1.0;
        for fragment in peeled {
            color += transmittance * fragment.alpha * colors[fragment.index as usize];
            transmittance *= 1.0 - fragment.alpha;
        }
        rgba.push(color.extend(1.0 - transmittance).to_array());
        counts.push(peeled.len() as u32);
        let shown = gaussians::with_depths(camera, points, &discs.gaussians, peeled);
        depth.push(shown.iter().find(|f| f.alpha > 0.0).map_or(f64::INFINITY, |f| f.z));
    }
    ReferencePicture { width: size[0], height: size[1], rgba, depth, counts }
}
