//! Sizes at their limits: units of a scene, positions far from the origin, dilations, splats smaller than pixels.

use super::super::naive::gaussians::{Formula, along_rays, projected};
use super::alone::alone;
use super::before;
use super::shapes::{KERNELS, by, by_both, in_both, some};
use super::splats::{Splat, SplatView};
use crate::check::prelude::*;
use pellucid_scene::Kernel;

const SIZE: [u32; 2] = [64, 48];

/// Returns splats around the origin, within a view from a distance of 10.
fn scene() -> Vec<Splat> {
    let mut splats = some(5, Vec3::new(0.5, 0.2, 0.8), 1.0);
    splats.extend(some(1, Vec3::new(4.0, 3.0, 2.0), 1.0));
    splats
}

/// Checks the scene in other units. The determinant of a covariance is a product of six lengths: too small or too large
/// for float32.
pub(super) fn in_units(stage: &mut CaseRenderer, method: Method, unit: f64) -> CaseResult {
    let splats: Vec<Splat> = scene().iter().map(|splat| splat.scaled(unit)).collect();
    by_both(stage, method, before(10.0 * unit, 45.0), &splats, 500)
}

pub(super) fn far(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let offset = DVec3::new(4_478_000.25, 5_413_000.5, 431.125);
    let moved = |splat: Splat| Splat { position: splat.position + offset, ..splat };
    let splats: Vec<Splat> = some(6, Vec3::new(0.02, 0.01, 0.03), 0.1).into_iter().map(moved).collect();
    let camera = before(1.0, 20.0);
    let camera = Camera { eye: camera.eye + offset, ..camera };
    let views = KERNELS.map(|kernel| SplatView::new(camera, SIZE, by(kernel), &method));
    // With positions in float32.
    in_both(stage, method, views, &splats, 300, |splat, view| match view.settings.kernel {
        Kernel::Ray => along_rays(splat, view),
        _ => projected(splat, view, &Formula::default()),
    })
}

pub(super) fn dilated(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = before(5.0, 45.0);
    let splats = some(2, Vec3::new(1e-4, 2e-4, 5e-4), 0.3);
    let large = GaussianSettings { dilation: 900.0, ..by(Kernel::Ewa) };
    let view = SplatView::new(camera, [256, 224], large, &method);
    // An ellipse of three standard deviations.
    let cut = Formula { reach: Some(3.0), ..Formula::default() };
    let shares = alone(stage, method, &view, &splats, 10_000, |splat| projected(splat, &view, &cut))?;
    let huge = SplatView::new(camera, SIZE, GaussianSettings { dilation: 1e25, ..large }, &method);
    // Opaque everywhere, and no formula fails.
    let other = alone(stage, method, &huge, &splats, 1000, |_| Vec::new())?;
    Ok(shares.larger(other).finding())
}

pub(super) fn subpixel(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let settings = GaussianSettings { antialias: true, ..by(Kernel::Ewa) };
    let view = SplatView::new(before(5.0, 45.0), SIZE, settings, &method);
    // A pixel is a twelfth of a unit.
    let sizes = [3e-4f32, 3e-3, 1e-2, 3e-2, 9e-2].into_iter().zip(0..);
    let sized =
        |(size, i): (f32, usize)| Splat { opacity: 1.0, ..some(5, size * Vec3::new(1.0, 0.8, 0.9), 0.5)[i].clone() };
    let splats: Vec<Splat> = sizes.map(sized).collect();
    // Without the factor: as opaque as if they were larger.
    Ok(alone(stage, method, &view, &splats, 20, |splat| projected(splat, &view, &Formula::default()))?.finding())
}
