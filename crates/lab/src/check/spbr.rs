//! Stochastic point-based rendering: surfaces of the opacity that was asked for, and ensembles that are independent.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::prelude::*;
use pellucid_core::random::threefry2x32;
use pellucid_reference::spbr::slanted;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::{CloudSurface, Dealt};
use pellucid_scene::{Spbr, SpbrSimplified};

const SIZE: [u32; 2] = [64, 64];
const PIXELS: f64 = 4096.0;
const ENSEMBLES: u32 = 20;
/// The allowed number of standard errors: 1 in 90 000 of normally distributed means lies beyond.
const ERRORS: f64 = 4.4;

pub(super) fn cases() -> Vec<Case> {
    let about = "a white plane of opacity 0.5 shows 0.5, in 4.4 standard errors";
    let white = |k: f64| one(&format!("spbr/white-plane-k-{k}"), about, move |stage| white_plane(stage, k));
    let spbr = |cos_theta| [Method::Spbr(Spbr { ensembles: ENSEMBLES, cos_theta, ..Spbr::default() })];
    let simplified = [Method::SpbrSimplified(SpbrSimplified { ensembles: 7, ..SpbrSimplified::default() })];
    joined([
        [0.3, 1.0, 4.0, 19.0].map(white).into(),
        each(&spbr(true), "slanted", tilted).about("a plane at 60 degrees, Eq. 2: 1 - (1 - 0.3)^2"),
        each(&spbr(false), "slanted-corrected", tilted).about("the same without the shading effect: 0.3"),
        each(&spbr(true), "two-planes", two_planes).about("0.4 in front of 0.7: 0.4 + 0.6 · 0.7"),
        each(&spbr(true), "opacity-0-and-1", extremes)
            .about("one point on each pixel: opaque in all images, or in none"),
        each(&spbr(true), "ensembles", independent).about("the variance of a pixel is that of 20 independent images"),
        each(&simplified, "each-point-once", once).about("one point on each pixel is in one of 7 images: A = 1/7"),
    ])
}

/// Random points on a plane through the middle of the view, tilted around its horizontal, at a depth; `density` is
/// their number per pixel of the plane's own area.
fn plane(seed: u64, density: f64, degrees: f64, depth: f64, opacity: f32) -> (Points, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    // One pixel more on each side.
    let sides = [DVec3::X * 66.0, DVec3::new(0.0, cos, sin) * 66.0 / cos];
    let area = 66.0 * 66.0 / cos;
    let count = (density * area).round() as usize;
    let mut random = Pcg64::seed_from_u64(seed);
    let mut part = || random.random_range(-0.5..0.5);
    let center = DVec3::new(32.0, -32.0, -depth);
    let points = Points {
        positions: (0..count).map(|_| center + sides[0] * part() + sides[1] * part()).collect(),
        colors: vec![Vec3::ONE; count],
        opacities: vec![opacity; count],
        radii: vec![0.0; count],
        normals: Some(vec![DVec3::new(0.0, -sin, cos).as_vec3(); count]),
        ..Points::default()
    };
    (points, count as f64 / area)
}

/// Planes of known densities, as if they were shuffled: their points are in random order already.
fn dealt(planes: Vec<(Points, f64)>) -> Dealt {
    let (mut points, mut surfaces) = (Points::default(), Vec::new());
    for (plane, density) in planes {
        let first = points.len() as u64;
        let Some(bounds) = plane.bounds() else { continue };
        let opacity = plane.opacities.iter().copied().fold(0.0, f32::max);
        surfaces.push(CloudSurface {
            points: first..first + plane.len() as u64,
            center: bounds.center(),
            density,
            opacity,
        });
        points.append(plane);
    }
    Dealt { points: Arc::new(points), surfaces }
}

/// A of each pixel. Pixels are as good as independent: points fall on them at random.
fn alphas(stage: &mut CaseRenderer, dealt: &Dealt, method: Method) -> Result<Vec<f64>> {
    let mut cloud = stage.renderer.upload(&Arranged::Dealt(dealt.clone()))?;
    let image = stage.renderer.render(&mut cloud, &Frame::new(pixels(SIZE), SIZE, method))?.image;
    Ok(image.rgba.iter().map(|pixel| f64::from(pixel[3])).collect())
}

/// The variance of A of a pixel whose points are assigned k times to [`ENSEMBLES`] images.
///
/// An image leaves a pixel free with probability 1 − α, so that its A is one of two values, with variance α (1 − α).
/// For k ≤ 1 no two images share a point, and their mean is binomial. A point that is in k of L images is in neither of
/// two given ones with probability (L − k)(L − k − 1) / (L (L − 1)). The number of points over a pixel is Poisson
/// distributed, with a mean of −ln(1 − α) L / k. So both images are free with probability e to the power of that mean
/// times the remaining probability.
fn known_variance(alpha: f64, k: f64) -> f64 {
    let count = f64::from(ENSEMBLES);
    let both_free = if k <= 1.0 {
        (1.0 - alpha).powi(2)
    } else {
        let in_neither = (count - k) * (count - k - 1.0) / (count * (count - 1.0));
        ((-alpha).ln_1p() * count / k * (1.0 - in_neither)).exp()
    };
    let covariance = both_free - (1.0 - alpha).powi(2);
    (alpha * (1.0 - alpha) + (count - 1.0) * covariance) / count
}

/// The mean of A against what it should be, for points that are assigned k times; `naive` is what it would be instead.
fn mean_alpha(found: &[f64], wanted: f64, k: f64, naive: f64) -> Finding {
    let bound = ERRORS * (known_variance(wanted, k) / PIXELS).sqrt();
    Finding::new((mean(found) - wanted).abs(), bound, (naive - wanted).abs())
}

/// Points per pixel that give the ratio k = L (−ln(1 − α)) / ρ.
fn density(alpha: f64, k: f64) -> f64 {
    f64::from(ENSEMBLES) * -(-alpha).ln_1p() / k
}

fn white_plane(stage: &mut CaseRenderer, k: f64) -> CaseResult {
    let list = dealt(vec![plane(10 + k as u64, density(0.5, k), 0.0, 10.0, 0.5)]);
    let found = alphas(stage, &list, Method::Spbr(Spbr { ensembles: ENSEMBLES, ..Spbr::default() }))?;
    let naive = if k > 1.0 {
        // Copies assigned to any ensemble, perhaps twice to one: T becomes T^(1 - (k - 1) / 2L).
        1.0 - 0.5f64.powf(1.0 - (k - 1.0) / (2.0 * f64::from(ENSEMBLES)))
    } else {
        // Eq. 1 over segments of 7 pixels: n = ln(1 - α) / ln(1 - 1/7), over 7 pixels.
        1.0 - (-(0.5f64.ln() / (1.0 - 1.0 / 7.0f64).ln()) / 7.0).exp()
    };
    Ok(mean_alpha(&found, 0.5, k, naive))
}

fn tilted(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let list = dealt(vec![plane(2, density(0.3, 0.5), 60.0, 200.0, 0.3)]);
    let both = [slanted(0.3, 0.5), 0.3];
    let [wanted, naive] = match method {
        Method::Spbr(Spbr { cos_theta: true, .. }) => both,
        _ => [both[1], both[0]],
    };
    Ok(mean_alpha(&alphas(stage, &list, method)?, wanted, 0.5, naive))
}

fn two_planes(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let front = plane(3, density(0.4, 0.5), 0.0, 10.0, 0.4);
    let back = plane(4, density(0.7, 0.5), 0.0, 20.0, 0.7);
    let found = alphas(stage, &dealt(vec![back, front]), method)?;
    // Opacities that add up.
    Ok(mean_alpha(&found, 0.4 + 0.6 * 0.7, 0.5, f64::from((0.4f32 + 0.7).min(1.0))))
}

fn independent(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let list = dealt(vec![plane(5, density(0.5, 1.0), 0.0, 10.0, 0.5)]);
    let found = variance(&alphas(stage, &list, method)?);
    let wanted = 0.5 * 0.5 / f64::from(ENSEMBLES);
    // The variance of a sample variance: 2 and the excess kurtosis, -2 / L, over n.
    let bound = ERRORS * (2.0 / PIXELS).sqrt();
    // The same image L times.
    let same = |i: u32| if threefry2x32([i, 0], [0, 0])[0] < u32::MAX / 2 { 1.0 } else { 0.0 };
    let naive = variance(&(0..4096).map(same).collect::<Vec<f64>>());
    Ok(Finding::new((found / wanted - 1.0).abs(), bound, (naive / wanted - 1.0).abs()))
}

/// Returns a point in the middle of each pixel.
fn grid(opacity: f32) -> Dealt {
    let points = Points {
        positions: (0..4096).map(|i| at(i % 64, i / 64, 10.0)).collect(),
        colors: vec![Vec3::ONE; 4096],
        opacities: vec![opacity; 4096],
        radii: vec![0.0; 4096],
        ..Points::default()
    };
    dealt(vec![(points, 1.0)])
}

fn extremes(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let (mut error, mut naive) = (0f64, 0f64);
    for opacity in [0.0, 1.0] {
        let found = alphas(stage, &grid(opacity), method)?;
        error = found.iter().map(|alpha| (alpha - f64::from(opacity)).abs()).fold(error, f64::max);
        // ln(1 - α) is infinite, and so is the number of copies: its fractional part is undefined.
        let copies = ENSEMBLES as f32 * -(1.0 - opacity).ln();
        let part = copies - copies.floor();
        let share = (copies.floor() + part) / ENSEMBLES as f32;
        naive = naive.max(apart(&[share], &[opacity.into()]));
    }
    Ok(Finding::new(error, 0.0, naive))
}

fn once(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let found = alphas(stage, &grid(1.0), method)?;
    let apart = |alpha: &f64| (alpha - 1.0 / 7.0).abs();
    // Each point in each image with probability 1/7.
    let drawn = |i: u32| (0..7).filter(|e| threefry2x32([i, *e], [0, 0])[0] < u32::MAX / 7).count() as f64 / 7.0;
    let naive = (0..4096).map(|i| apart(&drawn(i))).fold(0.0, f64::max);
    Ok(Finding::new(found.iter().map(apart).fold(0.0, f64::max), 2.0 * f64::from(f32::EPSILON), naive))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_variance_lies_between_one_image_and_independent_ones() {
        let alone = |alpha: f64| alpha * (1.0 - alpha);
        for alpha in [0.1, 0.5, 0.9] {
            for k in [0.3, 1.0] {
                assert!((known_variance(alpha, k) - alone(alpha) / 20.0).abs() < 1e-15);
            }
            let shared = [4.0, 19.0, 20.0].map(|k| known_variance(alpha, k));
            assert!(shared[0] > alone(alpha) / 20.0 && shared[1] > shared[0], "{shared:?}");
            // Each point in all images: they are the same.
            assert!((shared[2] - alone(alpha)).abs() < 1e-15, "{shared:?}");
        }
    }
}
