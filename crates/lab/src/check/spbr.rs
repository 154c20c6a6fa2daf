//! Stochastic point-based rendering: surfaces of the opacity that was asked for, and ensembles that are independent.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::stage::{at, frame, pixels};
use super::{Case, Finding, Stage, Trouble, each, one};
use pellucid_engine::points::Points;
use pellucid_engine::prepare::ensembles::{Dealt, Surface};
use pellucid_engine::random::threefry2x32;
use pellucid_engine::reference::spbr::slanted;
use pellucid_engine::scene::{Method, Spbr, SpbrSimplified};

type Found = Result<Finding, Trouble>;

const SIZE: [u32; 2] = [64, 64];
const PIXELS: f64 = 4096.0;
const ENSEMBLES: u32 = 20;
/// Standard errors that are allowed: 1 in 150 000 of normally distributed means lies beyond.
const ERRORS: f64 = 4.5;

pub(super) fn cases() -> Vec<Case> {
    let plane = |k: f64, name: &str| {
        one(name, "a white plane of opacity 0.5 shows 0.5, in 4.5 standard errors", move |stage| white_plane(stage, k))
    };
    let white = vec![
        plane(0.3, "spbr/white-plane-k-0.3"),
        plane(1.0, "spbr/white-plane-k-1"),
        plane(4.0, "spbr/white-plane-k-4"),
        plane(19.0, "spbr/white-plane-k-19"),
    ];
    let spbr = |cos_theta| [Method::Spbr(Spbr { ensembles: ENSEMBLES, cos_theta, ..Spbr::default() })];
    let simplified = [Method::SpbrSimplified(SpbrSimplified { ensembles: 7, ..SpbrSimplified::default() })];
    [
        white,
        each(&spbr(true), "slanted", "a plane at 60 degrees, Eq. 2: 1 - (1 - 0.3)^2", tilted),
        each(&spbr(false), "slanted-corrected", "the same without the shading effect: 0.3", tilted),
        each(&spbr(true), "two-planes", "0.4 before 0.7: 0.4 + 0.6 · 0.7", two_planes),
        each(&spbr(true), "opacity-0-and-1", "one point on each pixel: opaque in all images, or in none", extremes),
        each(&spbr(true), "ensembles", "the variance of a pixel is that of 20 independent images", independent),
        each(&simplified, "each-point-once", "one point on each pixel is in one of 7 images: A = 1/7", once),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Points at random on a plane through the middle of the view, tilted around its horizontal, so many over each pixel of its own
/// area, at a depth.
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

/// Planes of known densities, as if they were dealt: their points are in random order already.
fn dealt(planes: Vec<(Points, f64)>) -> Dealt {
    let (mut points, mut surfaces) = (Points::default(), Vec::new());
    for (plane, density) in planes {
        let first = points.len() as u64;
        let Some(bounds) = plane.bounds() else { continue };
        let opacity = plane.opacities.iter().copied().fold(0.0, f32::max);
        surfaces.push(Surface { points: first..first + plane.len() as u64, center: bounds.center(), density, opacity });
        points.append(plane);
    }
    Dealt { points: Arc::new(points), surfaces }
}

/// A of each pixel.
fn alphas(stage: &mut Stage, dealt: &Dealt, method: Method) -> Result<Vec<f64>, Trouble> {
    let mut cloud = stage.renderer.upload_dealt(dealt)?;
    let image = stage.renderer.render(&mut cloud, &frame(pixels(SIZE), SIZE, method))?.image;
    Ok(image.rgba.iter().map(|pixel| f64::from(pixel[3])).collect())
}

/// Mean and variance. Pixels are as good as independent: points fall on them at random.
fn moments(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / PIXELS;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (PIXELS - 1.0))
}

/// The mean of A against what it should be; `naive` is what it would be instead.
fn mean_alpha(found: &[f64], wanted: f64, naive: f64) -> Finding {
    let (mean, variance) = moments(found);
    let bound = ERRORS * (variance / PIXELS).sqrt();
    Finding { error: (mean - wanted).abs(), bound, naive: (naive - wanted).abs() }
}

/// Points over a pixel such that the ratio is k: k = L (−ln(1 − α)) / ρ.
fn density(alpha: f64, k: f64) -> f64 {
    f64::from(ENSEMBLES) * -(-alpha).ln_1p() / k
}

fn white_plane(stage: &mut Stage, k: f64) -> Found {
    let list = dealt(vec![plane(10 + k as u64, density(0.5, k), 0.0, 10.0, 0.5)]);
    let found = alphas(stage, &list, Method::Spbr(Spbr { ensembles: ENSEMBLES, ..Spbr::default() }))?;
    let naive = if k > 1.0 {
        // Copies dealt to any ensemble, perhaps twice to one: T becomes T^(1 - (k - 1) / 2L).
        1.0 - 0.5f64.powf(1.0 - (k - 1.0) / (2.0 * f64::from(ENSEMBLES)))
    } else {
        // Eq. 1 over segments of 7 pixels: n = ln(1 - α) / ln(1 - 1/7), over 7 pixels.
        1.0 - (-(0.5f64.ln() / (1.0 - 1.0 / 7.0f64).ln()) / 7.0).exp()
    };
    Ok(mean_alpha(&found, 0.5, naive))
}

fn tilted(stage: &mut Stage, method: Method) -> Found {
    let list = dealt(vec![plane(2, density(0.3, 0.5), 60.0, 200.0, 0.3)]);
    let both = [slanted(0.3, 0.5), 0.3];
    let [wanted, naive] = match method {
        Method::Spbr(Spbr { cos_theta: true, .. }) => both,
        _ => [both[1], both[0]],
    };
    Ok(mean_alpha(&alphas(stage, &list, method)?, wanted, naive))
}

fn two_planes(stage: &mut Stage, method: Method) -> Found {
    let front = plane(3, density(0.4, 0.5), 0.0, 10.0, 0.4);
    let back = plane(4, density(0.7, 0.5), 0.0, 20.0, 0.7);
    let found = alphas(stage, &dealt(vec![back, front]), method)?;
    // Opacities that add up.
    Ok(mean_alpha(&found, 0.4 + 0.6 * 0.7, 1.0))
}

fn independent(stage: &mut Stage, method: Method) -> Found {
    let list = dealt(vec![plane(5, density(0.5, 1.0), 0.0, 10.0, 0.5)]);
    let (_, variance) = moments(&alphas(stage, &list, method)?);
    let wanted = 0.5 * 0.5 / f64::from(ENSEMBLES);
    // The variance of a sample variance: 2 and the excess kurtosis, -2 / L, over n.
    let bound = ERRORS * (2.0 / PIXELS).sqrt();
    // The same image L times.
    Ok(Finding { error: (variance / wanted - 1.0).abs(), bound, naive: f64::from(ENSEMBLES) - 1.0 })
}

/// One point in the middle of each pixel.
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

fn extremes(stage: &mut Stage, method: Method) -> Found {
    let mut error = 0f64;
    for opacity in [0.0, 1.0] {
        let found = alphas(stage, &grid(opacity), method)?;
        error = found.iter().map(|alpha| (alpha - f64::from(opacity)).abs()).fold(error, f64::max);
    }
    // ln(1 - α) is infinite, and so are the points that are wanted.
    Ok(Finding { error, bound: 0.0, naive: f64::INFINITY })
}

fn once(stage: &mut Stage, method: Method) -> Found {
    let found = alphas(stage, &grid(1.0), method)?;
    let apart = |alpha: &f64| (alpha - 1.0 / 7.0).abs();
    // Each point in each image with probability 1/7.
    let drawn = |i: u32| (0..7).filter(|e| threefry2x32([i, *e], [0, 0])[0] < u32::MAX / 7).count() as f64 / 7.0;
    let naive = (0..4096).map(|i| apart(&drawn(i))).fold(0.0, f64::max);
    Ok(Finding { error: found.iter().map(apart).fold(0.0, f64::max), bound: 2.0 * f64::from(f32::EPSILON), naive })
}
