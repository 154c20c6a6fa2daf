//! Ellipsoids of constant density along one ray.

use super::splats::{Splat, SplatView, cloud};
use crate::check::prelude::*;
use pellucid_scene::Kernel;

/// Roundings in an optical depth over itself: of the axes and of the frame of a Gaussian that is turned by nothing,
/// some 12; of the density, its logarithm included, 8; of the chord and of the exponential, 8.
const DEPTH: f64 = 28.0;

/// The only pixel, whose ray goes through all centers.
fn pixel(stage: &mut CaseRenderer, method: Method, splats: &[Splat]) -> Result<[f32; 4]> {
    let settings = GaussianSettings { kernel: Kernel::Ellipsoid, alpha_max: 1.0, ..GaussianSettings::default() };
    let view = SplatView::new(pixels([1, 1]), [1, 1], settings, &method);
    Ok(stage.render(&cloud(splats), &view.frame(method))?.image.rgba[0])
}

fn ball(depth: f64, extent: f32, opacity: f32, base: Vec3) -> Splat {
    Splat { position: at(0, 0, depth), extents: Vec3::splat(extent), opacity, base, ..Splat::default() }
}

/// Optical depth of an opacity.
fn depth_of(opacity: f32) -> f64 {
    -(-f64::from(opacity)).ln_1p()
}

const FAINT: u32 = 100_000;

/// Checks many faint ellipsoids, each of which overlaps most of the others.
pub(super) fn faint(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let opacity = 1e-5f32;
    let splats: Vec<Splat> = (0..FAINT).map(|i| ball(2e5 + f64::from(i), 1e5, opacity, Vec3::ONE)).collect();
    let found = pixel(stage, method, &splats)?;
    let wanted = -(-f64::from(FAINT) * depth_of(opacity)).exp_m1();
    // Segment by segment as a product of transmittances, which are 1 less what float32 no longer sees.
    let segment = depth_of(opacity) as f32 / 2e5;
    let clear = (0..2 * FAINT).fold(1f32, |clear, k| {
        let open = if k < FAINT { k + 1 } else { 2 * FAINT - 1 - k };
        clear * (1.0 - segment * open as f32)
    });
    let naive = apart(&[1.0 - clear], &[wanted]);
    let bound = HALF_ULP * (DEPTH / std::f64::consts::E + roundings(&method, 2 * FAINT as usize) * wanted);
    Ok(Finding::new(apart(&found[3..], &[wanted]), bound, naive))
}

/// Thinner than a step between depths of float32.
pub(super) fn thin(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let thickness = 1e-8f32;
    let plate =
        |depth: f64, base: Vec3| Splat { extents: Vec3::new(2.0, 2.0, thickness), ..ball(depth, 1.0, 0.5, base) };
    let splats = [plate(9.0, Vec3::X), plate(10.0, Vec3::Y), plate(11.0, Vec3::Z)];
    let found = pixel(stage, method, &splats)?;
    let wanted = [0.5, 0.25, 0.125, 0.875];
    // Between depths as float32 has them there is nothing.
    let length = |depth: f32| (depth + thickness) - (depth - thickness);
    let density = depth_of(0.5) as f32 / (2.0 * thickness);
    let clear = [9f32, 10.0, 11.0].map(|depth| (-density * length(depth)).exp());
    let naive = apart(&[1.0 - clear.iter().product::<f32>()], &wanted[3..]);
    // x exp(-x) is at most 1/e.
    let bound = 3.0 * DEPTH * HALF_ULP / std::f64::consts::E;
    Ok(Finding::new(apart(&found, &wanted), bound, naive))
}

/// A plate a hundred million times as dense as the ball that it is in: what is behind it in the ball has the ball's
/// density alone.
pub(super) fn dense_within(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let thickness = 1e-5f32;
    let plate = Splat { extents: Vec3::new(2.0, 2.0, thickness), ..ball(1000.0, 1.0, 0.5, Vec3::X) };
    let splats = [ball(1000.0, 900.0, 0.75, Vec3::Y), plate];
    let found = pixel(stage, method, &splats)?;
    // Half of the ball, half of what is left, and the other half of the ball; the plate's share of the ball is 1e-8.
    let wanted = [0.5 * 0.5, 0.5 + 0.25 * 0.5, 0.0, 0.875];
    let (ball, plate) = (depth_of(0.75) as f32 / 1800.0, depth_of(0.5) as f32 / (2.0 * thickness));
    // A running sum: what is left of the ball's density when the plate's is taken out again.
    let left = ((ball + plate) - plate) * 900.0;
    let naive = apart(&[0.5 + 0.25 * (1.0 - (-left).exp())], &wanted[1..2]);
    let bound = 3.0 * DEPTH * HALF_ULP / std::f64::consts::E + 2e-8;
    Ok(Finding::new(apart(&found, &wanted), bound, naive))
}

/// The eye is within: what lies before near is not seen.
pub(super) fn around_the_eye(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // From 1.5 before near, which is at 0.5, to 4.5 behind it.
    let found = pixel(stage, method, &[ball(2.0, 3.0, 0.984_375, Vec3::ONE)])?;
    let share = |part: f64| -(-depth_of(0.984_375) * part).exp_m1();
    let wanted = share(4.5 / 6.0);
    let naive = apart(&[share(1.0) as f32], &[wanted]);
    let bound = DEPTH * HALF_ULP / std::f64::consts::E;
    Ok(Finding::new(apart(&found[3..], &[wanted]), bound, naive))
}

/// Checks two ellipsoids of a centimeter, at coordinates of a projected map.
pub(super) fn georeferenced(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let offset = DVec3::new(4_478_000.0, 5_413_000.0, 431.0);
    let settings = GaussianSettings { kernel: Kernel::Ellipsoid, alpha_max: 1.0, ..GaussianSettings::default() };
    let mut view = SplatView::new(pixels([1, 1]), [1, 1], settings, &method);
    view.camera.eye += offset;
    // They overlap in half of each.
    let all = [ball(5.0, 0.01, 0.75, Vec3::X), ball(5.01, 0.01, 0.75, Vec3::Y)];
    let moved = all.clone().map(|splat| Splat { position: splat.position + offset, ..splat });
    let found = stage.render(&cloud(&moved), &view.frame(method))?.image.rgba[0];
    let wanted = [0.5 + 0.5 * 0.75 * 0.5, 0.5 * 0.75 * 0.5 + 0.125 * 0.5, 0.0, 0.9375];
    // In float32 the offset in x is a multiple of half a meter, and the ray passes beside both.
    let naive = apart(&[0.0; 4], &wanted);
    // Places are off by 2^-24 of depths of 5, the ends of chords twice: over a chord of 0.02, that has the optical
    // depth ln 4.
    let moved = 4.0 * HALF_ULP * 5.02 / 0.02 * depth_of(0.75);
    let bound = 4.0 * (DEPTH * HALF_ULP / std::f64::consts::E + moved);
    Ok(Finding::new(apart(&found, &wanted), bound, naive))
}
