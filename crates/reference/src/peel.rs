//! Depth peeling of discs and Gaussians: layer after layer, on each pixel the nearest fragment behind the last one that
//! was peeled.

use glam::DVec3;

use super::abuffer::of_point;
use super::fragments::{Composite, Fragment, before_end};
use super::{ReferencePicture, View, gaussians};
use pellucid_core::points::Points;
use pellucid_scene::Discs;

/// Returns fragments of each pixel in the order of the points, unsorted by depth.
pub fn fragments(view: View, points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); view.pixels()];
    for index in 0..points.len() {
        for (at, fragment) in of_point(view, points, index, discs) {
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
pub fn render(view: View, points: &Points, colors: &[DVec3], discs: &Discs, layers: u32) -> ReferencePicture {
    let stop = gaussians::stop(points, &discs.gaussians);
    let pixel = |list: Vec<Fragment>| {
        let all = peel(&list, layers);
        let peeled = before_end(&all, stop);
        let mut color = DVec3::ZERO;
        let mut transmittance = 1.0;
        for fragment in peeled {
            color += transmittance * fragment.alpha * colors[fragment.index as usize];
            transmittance *= 1.0 - fragment.alpha;
        }
        let shown = gaussians::with_depths(view.camera, points, &discs.gaussians, peeled);
        let depth = shown.iter().find(|f| f.alpha > 0.0).map_or(f64::INFINITY, |f| f.z);
        (Composite { color, alpha: 1.0 - transmittance, depth }, peeled.len() as u32)
    };
    ReferencePicture::of(view.size, fragments(view, points, discs).into_iter().map(pixel))
}
