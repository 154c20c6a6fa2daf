//! The least and the most opacity of a fragment, and centers that are not drawn.

use super::super::naive::gaussians::{Formula, projected};
use super::super::naive::over_until;
use super::alone::Shares;
use super::before;
use super::shapes::{KERNELS, by, in_both, some};
use super::splats::{Splat, SplatView, cloud};
use crate::check::prelude::*;

const SIZE: [u32; 2] = [64, 48];

/// Checks both kernels; the naive formula ends an ellipse at three standard deviations.
fn beyond_three(
    stage: &mut CaseRenderer,
    method: Method,
    settings: GaussianSettings,
    splats: &[Splat],
    least: usize,
) -> CaseResult {
    let by = |kernel| SplatView::new(before(5.0, 45.0), SIZE, GaussianSettings { kernel, ..settings }, &method);
    let cut = Formula { reach: Some(3.0), ..Formula::default() };
    in_both(stage, method, KERNELS.map(by), splats, least, |splat, view| projected(splat, view, &cut))
}

pub(super) fn least_opacity(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let settings = GaussianSettings::default();
    // 500 pixels. The opacity falls below the least one at 0.0055 standard deviations, or is nowhere as large.
    let size = Vec3::splat(43.0);
    let just = |factor: f32| move |splat: Splat| Splat { opacity: factor * settings.alpha_min, ..splat };
    let step = 2f32.powi(-16);
    let mut splats: Vec<Splat> = some(4, size, 0.5).into_iter().map(just(1.0 + step)).collect();
    splats.extend(some(2, size, 0.5).into_iter().map(just(1.0 - step)));
    beyond_three(stage, method, settings, &splats, 40)
}

pub(super) fn tails(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let settings = GaussianSettings { alpha_min: 2e-6, ..GaussianSettings::default() };
    let splats: Vec<Splat> =
        some(4, Vec3::new(0.3, 0.35, 0.2), 0.3).into_iter().map(|splat| Splat { opacity: 1.0, ..splat }).collect();
    beyond_three(stage, method, settings, &splats, 2000)
}

pub(super) fn most_opacity(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let nearly = 1.0 - f32::EPSILON / 2.0;
    // Behind the first layer one product rounds. Behind more, what is covered has been rounded before, near 1.
    let one = HALF_ULP * HALF_ULP;
    let more = roundings(&method, 3) * HALF_ULP;
    let shares = shines_through(stage, method, 1.0, &[nearly, 1.0], one)?;
    Ok(shares.and(shines_through(stage, method, 0.99, &[nearly, 1.0, 1.0], more)?).finding())
}

/// White behind black layers. ρ is 0 in the middle of a pixel, so that opacities are those of the centers.
fn shines_through(
    stage: &mut CaseRenderer,
    method: Method,
    alpha_max: f32,
    layers: &[f32],
    bound: f64,
) -> Result<Shares> {
    let settings = GaussianSettings { alpha_max, ..GaussianSettings::default() };
    let view = SplatView::new(pixels([1, 1]), [1, 1], settings, &method);
    let color = |i: usize| if i + 1 == layers.len() { Vec3::ONE } else { Vec3::ZERO };
    let depth = |i: usize| 1.0 + i as f64;
    let splat = |(i, opacity): (usize, &f32)| Splat {
        position: at(0, 0, depth(i)),
        base: color(i),
        opacity: *opacity,
        ..Splat::default()
    };
    let splats: Vec<Splat> = layers.iter().enumerate().map(splat).collect();
    let image = stage.render(&cloud(&splats), &view.frame(method))?.image;
    let capped = |(i, opacity): (usize, &f32)| dot(depth(i), color(i), opacity.min(alpha_max));
    let dots: Vec<_> = layers.iter().enumerate().map(capped).collect();
    let wanted = &composed(&dots)[..3];
    let share = |found: &[f32]| apart(&found[..3], wanted) / bound;
    // Nothing is drawn behind a transmittance of 1e-4.
    Ok(Shares { found: share(&image.rgba[0]), naive: share(&over_until(&dots, 1e-4)) })
}

pub(super) fn behind(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 60.0, 0.5, 100.0);
    let splat =
        |z: f64| Splat { position: DVec3::new(0.01, 0.02, z), extents: Vec3::new(3.0, 2.0, 1.0), ..Splat::default() };
    let mut splats: Vec<Splat> = [1e-300, 1e-3, 0.4, 1.0, 5.0, 1e3, 1e30].map(splat).to_vec();
    splats.extend([0.0, 1e-30, 1e-3, 0.49, 101.0, 1e9, 1e30].map(|z| splat(-z)));
    let (mut drawn, mut naive) = (0.0f64, f64::INFINITY);
    for kernel in KERNELS {
        let view = SplatView::new(camera, [9, 9], by(kernel), &method);
        let image = stage.render(&cloud(&splats), &view.frame(method))?.image;
        let all = image.rgba.iter().flatten().chain(image.depth.iter().filter(|z| **z != f32::INFINITY));
        drawn = all.map(|c| if *c == 0.0 { 0.0 } else { 1.0 }).fold(drawn, f64::max);
        // Divided by a negative depth they appear in the image, upside down.
        let everywhere = Formula { nearest: f32::NEG_INFINITY, ..Formula::default() };
        let seen = splats.iter().flat_map(|splat| projected(splat, &view, &everywhere));
        naive = naive.min(seen.map(|seen| f64::from(seen.alpha)).fold(0.0, f64::max));
    }
    Ok(Finding::new(drawn, 0.0, naive))
}
