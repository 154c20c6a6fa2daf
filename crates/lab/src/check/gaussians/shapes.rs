//! Needles, plates and flat splats; centers far beside the image; rays that end in a splat.

use glam::{DVec2, Quat};

use super::super::naive::gaussians::{Formula, Seen, along_rays, projected};
use super::alone::{Expected, Known, Shares, alone, compared};
use super::before;
use super::splats::{Splat, SplatView, cloud, part, turned};
use crate::check::prelude::*;
use pellucid_reference::gaussians::{PlacedGaussian, ewa, gaussian};
use pellucid_reference::range::Range;
use pellucid_scene::Kernel;

const SIZE: [u32; 2] = [64, 48];

/// The two kernels.
pub(super) const KERNELS: [Kernel; 2] = [Kernel::Ewa, Kernel::Ray];

pub(super) fn by(kernel: Kernel) -> GaussianSettings {
    GaussianSettings { kernel, ..GaussianSettings::default() }
}

/// Splats of these extents, turned and placed each in its own way around the origin, up to so far from it.
pub(super) fn some(count: u32, extents: Vec3, spread: f64) -> Vec<Splat> {
    let splat = |i: u32| Splat {
        position: spread * DVec3::from_array([0, 1, 2].map(|axis| part(i, axis))),
        extents,
        rotation: turned(i),
        opacity: 0.9,
        ..Splat::default()
    };
    (0..count).map(splat).collect()
}

/// Long splats, each tilted against the screen and turned on it.
fn sticks(extents: Vec3, spread: f64) -> Vec<Splat> {
    let stick = |i: u32| Splat {
        rotation: Quat::from_rotation_z(0.3 + 0.5 * i as f32) * Quat::from_rotation_y(0.4 * part(i, 9) as f32),
        position: spread * DVec3::new(part(i, 0), part(i, 1), part(i, 2)),
        ..some(1, extents, 0.0)[0].clone()
    };
    (0..6).map(stick).collect()
}

pub(super) fn needles(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = Camera { projection: Projection::Orthographic { height: 4.8 }, ..before(5.0, 45.0) };
    let view = SplatView::new(camera, SIZE, GaussianSettings::default(), &method);
    let splats = sticks(Vec3::new(1e3, 1e-3, 1e-3), 0.5);
    let expected = |splat: &Splat| along_an_axis(&view, splat, &method);
    // The products of variances are 1e15, and their difference is 3e7.
    let naive = |splat: &Splat| projected(splat, &view, &Formula::default());
    Ok(compared(stage, method, &view, &splats, 500, expected, naive)?.finding())
}

/// A needle along its first axis, thinner than a pixel. Its opacity follows from the distance w from that axis on the
/// screen, over a variance v that is that of the dilation nearly alone.
///
/// With u for a rounding: the axis has components that are off by 40 u of its length (an entry of a turned quaternion
/// and its products), and by 8 u where rows are made orthogonal (Higham, "Accuracy and Stability of Numerical
/// Algorithms", Section 19.3). At d pixels from the center w is off by √2 · 48 u d, and d itself by one rounding of a
/// pixel and eight of its products. What 8 u of the length L adds across the needle, its variance gains.
fn along_an_axis(view: &SplatView, splat: &Splat, method: &Method) -> Option<Expected> {
    let gaussian = gaussian(&cloud(std::slice::from_ref(splat)), 0)?;
    let placed = PlacedGaussian::new(View::new(&view.camera, view.size), &gaussian)?;
    let screen = ewa::Projected::new(&placed, &view.settings);
    let long = screen.columns[0];
    let thin = screen.columns[1].length().hypot(screen.columns[2].length());
    let variance = screen.dilation + thin * thin;
    let stray = 8.0 * HALF_ULP * long.length();
    let of_variance = (stray * stray + 2.0 * stray * thin) / variance;
    let [least, most] = [view.settings.alpha_min, view.settings.alpha_max].map(f64::from);
    let depth = Range { low: f64::NEG_INFINITY, high: f64::INFINITY };
    let known = |[x, y]: [u32; 2]| {
        let offset = DVec2::new(f64::from(x), f64::from(y)) + 0.5 - screen.center;
        let (rho2, w) = (screen.rho2(offset), long.perp_dot(offset).abs() / long.length());
        let off = HALF_ULP * ((48.0 * 2f64.sqrt() + 8.0) * offset.length() + 1.0);
        let of_rho2 = (2.0 * w + off) * off / variance + rho2 * (of_variance + 16.0 * HALF_ULP);
        // Two roundings in the exponential, one in the product; and those of a list of one.
        let of_alpha = (3.0 + roundings(method, 1)) * HALF_ULP;
        let alpha = screen.opacity * (-0.5 * rho2).exp();
        let high = (alpha * (0.5 * of_rho2).exp() * (1.0 + of_alpha)).min(most);
        let low = (alpha * (-0.5 * of_rho2).exp() * (1.0 - of_alpha)).min(most);
        let exact = (alpha >= least).then_some((alpha.min(most), view.camera.to_view(splat.position).z));
        let range = Range { low: low.max(least), high };
        (high >= least).then_some(Known { exact, alpha: range, depth, sure: low >= least })
    };
    Some(Expected(view.pixels().map(known).collect()))
}

pub(super) fn by_ray(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    // A narrow view: needles that reach far in depth have rays of which roundings leave nothing.
    let view = SplatView::new(before(5.0, 0.045), SIZE, by(Kernel::Ray), &method);
    let splats = sticks(Vec3::new(1.0, 1e-4, 1e-4), 5e-4);
    Ok(alone(stage, method, &view, &splats, 300, |splat| along_rays(splat, &view))?.finding())
}

pub(super) fn plates(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = before(5.0, 7.0);
    // Turned about the viewing axis, and tilted out of it.
    let plate = |i: u32| Splat {
        rotation: Quat::from_rotation_z(0.9 * i as f32) * Quat::from_rotation_x(0.005 * (1 + i) as f32),
        extents: Vec3::new(1.0, 1e-4, 1.0),
        position: 0.1 * DVec3::new(part(i, 0), part(i, 1), 0.0),
        opacity: 0.9,
        ..Splat::default()
    };
    by_both(stage, method, camera, &(0..6).map(plate).collect::<Vec<_>>(), 300)
}

pub(super) fn flat(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let splats = some(6, Vec3::new(0.5, 0.8, 0.0), 0.5);
    // The inverse of their covariance is none.
    by_both(stage, method, before(5.0, 45.0), &splats, 300)
}

/// Checks both kernels; the naive formula works along rays.
pub(super) fn by_both(
    stage: &mut CaseRenderer,
    method: Method,
    camera: Camera,
    splats: &[Splat],
    least: usize,
) -> CaseResult {
    let mut shares = Shares::NOTHING;
    for kernel in KERNELS {
        let view = SplatView::new(camera, SIZE, by(kernel), &method);
        let naive = |splat: &Splat| if kernel == Kernel::Ray { along_rays(splat, &view) } else { Vec::new() };
        shares = shares.larger(alone(stage, method, &view, splats, least, naive)?);
    }
    Ok(shares.finding())
}

/// Checks the views of both kernels; a naive formula must fail in each.
pub(super) fn in_both(
    stage: &mut CaseRenderer,
    method: Method,
    [ewa, rays]: [SplatView; 2],
    splats: &[Splat],
    least: usize,
    naive: impl Fn(&Splat, &SplatView) -> Vec<Seen>,
) -> CaseResult {
    let shares = alone(stage, method, &ewa, splats, least, |splat| naive(splat, &ewa))?;
    Ok(shares.and(alone(stage, method, &rays, splats, least, |splat| naive(splat, &rays))?).finding())
}

pub(super) fn wide(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = before(5.0, 60.0);
    let view = SplatView::new(camera, SIZE, GaussianSettings::default(), &method);
    let beside = |i: u32| Splat {
        position: DVec3::new([8.0, -7.0, 1.0, 0.0][i as usize], [0.5, 2.0, 6.0, -6.5][i as usize], 2.5),
        extents: Vec3::new(1.5, 1.2, 1.8),
        rotation: turned(i),
        ..Splat::default()
    };
    let unbounded = Formula { clamp: f32::INFINITY, ..Formula::default() };
    let naive = |splat: &Splat| projected(splat, &view, &unbounded);
    let splats: Vec<Splat> = (0..4).map(beside).collect();
    Ok(alone(stage, method, &view, &splats, 300, naive)?.finding())
}

pub(super) fn parallel(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = Camera { projection: Projection::Orthographic { height: 4.0 }, ..before(5.0, 45.0) };
    let splats = some(6, Vec3::new(0.6, 0.3, 0.05), 1.5);
    let of_perspective = Formula { perspective: true, ..Formula::default() };
    let views = KERNELS.map(|kernel| SplatView::new(camera, SIZE, by(kernel), &method));
    in_both(stage, method, views, &splats, 300, |splat, view| projected(splat, view, &of_perspective))
}

pub(super) fn through_the_eye(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let camera = perspective(DVec3::ZERO, DVec3::NEG_Z, 80.0, 0.25, 100.0);
    let view = SplatView::new(camera, SIZE, by(Kernel::Ray), &method);
    let around = |splat: Splat| Splat { position: 0.5 * splat.position + DVec3::NEG_Z, ..splat };
    let splats: Vec<Splat> = some(8, Vec3::new(1.2, 0.7, 0.9), 1.0).into_iter().map(around).collect();
    // The projection that is linear around the center.
    let naive = |splat: &Splat| projected(splat, &view, &Formula::default());
    Ok(alone(stage, method, &view, &splats, 300, naive)?.finding())
}
