//! Very many faint splats in a pixel.

use super::splats::{Splat, SplatView, cloud};
use crate::check::prelude::*;

const COUNT: u32 = 100_000;
const OPACITY: f32 = 1e-5;

/// The pixel, in whose middle all centers are: ρ is 0 there, and each opacity that of the center.
fn pixel(stage: &mut CaseRenderer, method: Method) -> Result<[f32; 4]> {
    let settings = GaussianSettings { alpha_min: 2e-6, ..GaussianSettings::default() };
    let view = SplatView::new(pixels([1, 1]), [1, 1], settings, &method);
    let splat = |i: u32| Splat { position: at(0, 0, depth(i)), opacity: OPACITY, ..Splat::default() };
    let points = cloud(&(0..COUNT).map(splat).collect::<Vec<_>>());
    Ok(stage.render(&points, &view.frame(method))?.image.rgba[0])
}

fn depth(i: u32) -> f64 {
    1.0 + f64::from(i)
}

fn dots() -> Vec<Dot> {
    (0..COUNT).map(|i| dot(depth(i), Vec3::ONE, OPACITY)).collect()
}

/// Each rounding is relative to a sum that is at most the whole.
fn bound(method: &Method, whole: f64) -> f64 {
    roundings(method, COUNT as usize) * HALF_ULP * whole
}

pub(super) fn layers(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let (found, wanted) = (pixel(stage, method)?, composed(&dots()));
    Ok(Finding::apart(&found, &over(&dots()), &wanted, bound(&method, wanted[3])))
}

pub(super) fn coverage(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let (found, wanted) = (pixel(stage, method)?[3], composed(&dots())[3]);
    Ok(Finding::apart(&[found], &[over(&dots())[3]], &[wanted], bound(&method, wanted)))
}
