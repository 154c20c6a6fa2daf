//! Exact transparency of discs (MCTB12) and Gaussians: the combined result of count, scan, store, sort and blend.

use glam::DVec3;

pub use super::fragments::{Composite, Fragment, before_end, composite, splat};

use super::fragments::of_disc;
use super::{ReferencePicture, View, gaussians};
use pellucid_core::points::Points;
use pellucid_scene::Discs;

/// Returns fragments of each pixel, near to far; equal depths by the point's index, so that order of arrival can't
/// show.
pub fn lists(view: View, points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let all: Vec<usize> = (0..view.pixels()).collect();
    lists_at(view, points, discs, &all)
}

/// Makes the lists like [`lists`], for these pixels alone: row · width + column, ascending.
pub fn lists_at(view: View, points: &Points, discs: &Discs, wanted: &[usize]) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); wanted.len()];
    for index in 0..points.len() {
        for (pixel, fragment) in of_point(view, points, index, discs) {
            if let Ok(at) = wanted.binary_search(&pixel) {
                pixels[at].push(fragment);
            }
        }
    }
    for list in &mut pixels {
        list.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.index.cmp(&b.index)));
    }
    pixels
}

/// Returns the fragments of a point's Gaussian or disc, each with its pixel: row · width + column.
pub(super) fn of_point(view: View, points: &Points, index: usize, discs: &Discs) -> Vec<(usize, Fragment)> {
    let of_gaussian = gaussians::fragments(view, points, index, &discs.gaussians);
    of_gaussian.unwrap_or_else(|| of_disc(view, points, index, discs))
}

/// Returns the smallest distance between successive depths of a list, over the depth; equal depths don't count, since
/// the index orders them at any precision. Below the rounding of a float32 depth the order of two fragments is a matter
/// of chance.
pub fn depth_margin(lists: &[Vec<Fragment>]) -> f64 {
    let gaps = lists.iter().flat_map(|list| list.windows(2)).map(|pair| (pair[1].z - pair[0].z) / pair[1].z.abs());
    gaps.filter(|&gap| gap != 0.0).fold(f64::INFINITY, f64::min)
}

/// Returns the depth at which a sorted list first lets through `share` of the light or less; +inf if it never does. Of
/// 1/2 it is the median depth; roundings make of it one between those of shares around 1/2.
pub fn median(list: &[Fragment], share: f64) -> f64 {
    let mut log_transmittance = 0.0f64;
    let reached = list.iter().find(|fragment| {
        log_transmittance += (-fragment.alpha).ln_1p();
        log_transmittance.exp_m1() <= share - 1.0
    });
    reached.map_or(f64::INFINITY, |fragment| fragment.z)
}

/// Returns the mean depth of a sorted list, Σ zᵢαᵢTᵢ / A with the transmittance Tᵢ before each fragment; +inf where A
/// is 0.
pub fn mean_depth(list: &[Fragment]) -> f64 {
    let (mut log_transmittance, mut sum) = (0.0f64, 0.0);
    for fragment in list {
        sum += fragment.z * fragment.alpha * log_transmittance.exp();
        log_transmittance += (-fragment.alpha).ln_1p();
    }
    let alpha = -log_transmittance.exp_m1();
    if alpha > 0.0 { sum / alpha } else { f64::INFINITY }
}

/// Returns the whole image. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], discs: &Discs) -> ReferencePicture {
    if gaussians::ellipsoid::are_drawn(points, discs) {
        return gaussians::ellipsoid::render(view, points, colors, discs);
    }
    let lists = lists(view, points, discs);
    let stop = gaussians::stop(points, &discs.gaussians);
    let pixel = |list: &[Fragment]| {
        composite(before_end(&gaussians::with_depths(view.camera, points, &discs.gaussians, list), stop), colors)
    };
    ReferencePicture::of_lists(view.size, &lists, pixel)
}
