//! Colors of splats: harmonics, and values that no display has.

use super::alone::Shares;
use super::before;
use super::shapes::some;
use super::splats::{Splat, SplatView, cloud, part};
use crate::check::prelude::*;
use pellucid_reference::gaussians::harmonics;

/// The most that a basis function of a degree has if no term of it is negative: 35 z⁴ − 30 z² + 3 has 68 of its factor.
const LOUDEST: [f64; 4] = [0.49, 0.64, 0.84, 7.2];

/// Roundings in such a term. A direction has 20 in each component: 2 for the difference, 4 for the square of the
/// length, 9 for its root and 5 for the quotient, as Vulkan allows them. Four directions, 8 products, 24 sums.
const TERM: f64 = 112.0;

/// Renders splats one by one, and compares colors over their opacities with those of a camera in float64. `off` is the
/// most that a color is off by, and `naive` what another formula makes of it.
fn compared(
    stage: &mut CaseRenderer,
    method: Method,
    view: &SplatView,
    splats: &[Splat],
    off: impl Fn(&Splat, usize) -> f64,
    naive: impl Fn(&Splat) -> DVec3,
) -> Result<Shares> {
    let mut shares = Shares::NOTHING;
    for splat in splats {
        let points = cloud(std::slice::from_ref(splat));
        let wanted = harmonics::color(&points, 0, &view.camera, ColorSpace::Encoded).unwrap_or(DVec3::NAN);
        let image = stage.render(&points, &view.frame(method))?.image;
        let other = naive(splat);
        for pixel in image.rgba.iter().filter(|pixel| pixel[3] > 0.1) {
            for c in 0..3 {
                let allowed = off(splat, c) + roundings(&method, 1) * HALF_ULP * wanted[c].abs();
                let share = |found: f64| match (found - wanted[c]).abs() {
                    0.0 => 0.0,
                    off if off.is_nan() => f64::INFINITY,
                    off => off / allowed,
                };
                let found = f64::from(pixel[c]) / f64::from(pixel[3]);
                shares = shares.larger(Shares { found: share(found), naive: share(other[c]) });
            }
        }
    }
    // Nothing was seen.
    Ok(if shares.naive == 0.0 { Shares { found: f64::INFINITY, ..shares } } else { shares })
}

pub(super) fn harmonics(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let offset = DVec3::new(4_478_000.25, 5_413_000.5, 431.125);
    let camera = before(2.0, 60.0);
    let view =
        SplatView::new(Camera { eye: camera.eye + offset, ..camera }, [32, 24], GaussianSettings::default(), &method);
    let coefficient = |i: u32, k: u32| Vec3::from_array([0, 1, 2].map(|c| 0.3 * part(40 * i + k, 50 + c) as f32));
    let colored = |(splat, i): (Splat, u32)| Splat {
        position: splat.position + offset,
        base: Vec3::new(0.9, 0.7, 0.8),
        harmonics: (0..24).map(|k| coefficient(i, k)).collect(),
        ..splat
    };
    let splats: Vec<Splat> = some(6, Vec3::splat(0.1), 0.6).into_iter().zip(0..).map(colored).collect();
    let off = |splat: &Splat, c: usize| {
        let degree = |k: usize| [3, 8, 15].iter().filter(|end| k >= **end).count();
        let terms = splat.harmonics.iter().enumerate().map(|(k, f)| LOUDEST[degree(k)] * f64::from(f[c].abs()));
        TERM * HALF_ULP * (f64::from(splat.base[c].abs()) + terms.sum::<f64>())
    };
    // Positions in float32, half a unit apart.
    let rounded = |position: DVec3| position.as_vec3().as_dvec3();
    let near = Camera { eye: rounded(view.camera.eye), ..view.camera };
    let naive = |splat: &Splat| {
        let moved = Splat { position: rounded(splat.position), ..splat.clone() };
        harmonics::color(&cloud(&[moved]), 0, &near, ColorSpace::Encoded).unwrap_or(DVec3::NAN)
    };
    Ok(compared(stage, method, &view, &splats, off, naive)?.finding())
}

pub(super) fn beyond(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let view = SplatView::new(before(5.0, 45.0), [32, 24], GaussianSettings::default(), &method);
    let bases = [Vec3::new(3.0, -1.0, 0.5), Vec3::new(1e4, 0.25, -1e4), Vec3::new(-1e-30, 1.5, 0.0)].into_iter();
    let splats: Vec<Splat> =
        some(3, Vec3::splat(0.3), 0.5).into_iter().zip(bases).map(|(splat, base)| Splat { base, ..splat }).collect();
    // As 8 bits have them.
    let naive = |splat: &Splat| splat.base.as_dvec3().clamp(DVec3::ZERO, DVec3::ONE);
    Ok(compared(stage, method, &view, &splats, |_, _| 0.0, naive)?.finding())
}
