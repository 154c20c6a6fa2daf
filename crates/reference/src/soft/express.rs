//! `soft-express`: discs in the order of their centers along the axis nearest to the viewing direction.

use std::f64::consts::PI;

use glam::DVec3;

use super::density::modulated_opacity;
use super::{Behind, Model, Pixel};
use crate::View;
use crate::coverage::{Shape, Splat, footprint};
use crate::fragments::{self, Fragment};
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;

/// Eq. 19: the opacity at ρ = d/r, at most 1.
pub fn opacity(peak: f64, rho: f64) -> f64 {
    peak * ((PI * rho).cos() + 1.0) / 2.0
}

/// Returns the axis of the world that a camera looks along most nearly, as (axis, sign); x before y before z where two
/// are as near.
pub fn axis(forward: DVec3) -> (usize, f64) {
    let [x, y, z] = forward.abs().to_array();
    let axis = match () {
        () if x >= y && x >= z => 0,
        () if y >= z => 1,
        () => 2,
    };
    (axis, forward[axis].signum())
}

/// Soft points from the first to the last along that axis; equal places by index, the last one first where the view
/// goes against the axis: one order is read both ways.
fn order(camera: &Camera, points: &Points, threshold: f32) -> Vec<usize> {
    let (axis, sign) = axis(camera.forward);
    let mut order: Vec<usize> = (0..points.fields.len()).filter(|i| points.fields[*i] > threshold).collect();
    let place = |i: usize| sign * points.positions[i][axis];
    let ties = |a: usize, b: usize| if sign < 0.0 { b.cmp(&a) } else { a.cmp(&b) };
    order.sort_by(|a, b| place(*a).total_cmp(&place(*b)).then(ties(*a, *b)));
    order
}

/// Returns the discs of each of these pixels (row · width + column, ascending) in that order, behind solids too.
pub fn lists(
    view: View,
    points: &Points,
    model: &Model,
    wanted: impl Fn(usize) -> Option<usize>,
    len: usize,
) -> Vec<Vec<Fragment>> {
    let mut lists = vec![Vec::new(); len];
    for index in order(view.camera, points, model.soft.threshold) {
        let splat = Splat::facing(points.positions[index], f64::from(points.radii[index]), Shape::Disc);
        let w = super::density::modulation(points.fields[index], &model.soft);
        for pixel in footprint(view, &splat) {
            let Some(at) = wanted(view.index(pixel.x, pixel.y)) else { continue };
            let opacity = opacity(model.strength.peak, pixel.rho);
            let alpha = if w == 1.0 { opacity } else { modulated_opacity(opacity, pixel.rho, w, model.strength.peak) };
            lists[at].push(Fragment { z: pixel.z, index: index as u32, alpha });
        }
    }
    lists
}

/// Blends a pixel's list front to back: the fragments before the solid.
pub fn blend(list: &[Fragment], colors: &[DVec3], behind: &Behind) -> Pixel {
    let drawn: Vec<Fragment> = list.iter().filter(|fragment| fragment.z < behind.depth).copied().collect();
    let (color, log_transmittance) = fragments::blend(&drawn, colors);
    let first = drawn.iter().find(|fragment| fragment.alpha > 0.0).map(|fragment| fragment.z);
    Pixel::before(color, log_transmittance, first, drawn.len() as u32, behind)
}
