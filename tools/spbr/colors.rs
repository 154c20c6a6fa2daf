//! Uchida et al. 2020, Section 4.2.2: a tenth of the points has noise in its colors; how far is the image from that
//! without?

use std::path::Path;

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::color::encode_srgb;
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::{Brightness, Method, SpbrSimplified};
use rand::RngExt;

use super::chart::{self, Axis, Row};
use super::scans::{self, MOVED};
use super::stage::{Stage, gauss, nmse, noisy_plane, of_level, random};

/// Side of the paper's images.
const SIDE: f64 = 1024.0;
/// Points of the plane on a pixel, as in the paper's first experiment.
const PER_PIXEL: f64 = 10.0;
/// Points of the garden at the full size.
const POINTS: f64 = 8e6;
/// Variance of each of red, green and blue, in levels².
const VARIANCE: f64 = 100.0;
/// Gray of the plane: far from black and white, where noise is cut off.
const GRAY: f64 = 128.0;
/// Weights of red, green and blue in gray.
const WEIGHTS: [f64; 3] = [0.299, 0.587, 0.114];

const ENSEMBLES: [u32; 10] = [1, 2, 3, 5, 10, 20, 30, 50, 100, 150];

/// Writes `colors.svg` and `colors.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let plane = noisy_plane((PER_PIXEL * f64::from(side).powi(2)).round() as usize, GRAY, 0.0, stage.seed);
    let garden = scans::merged(scans::built_in("garden", POINTS * scale * scale, stage.seed)?);
    let cameras = [Stage::front(1.0), scans::aslant(&garden)];
    let mut pairs = Vec::new();
    for (points, camera) in [plane, garden].into_iter().zip(cameras) {
        let noisy = recolored(points.clone(), stage.seed + 2);
        pairs.push((stage.upload(points)?, stage.upload(noisy)?, camera));
    }
    let (mut table, mut rows) = (Vec::new(), Vec::new());
    for ensembles in ENSEMBLES {
        let mut found = Vec::new();
        for pair in &mut pairs {
            found.push(distance(stage, pair, side, ensembles)?);
        }
        let expected = expected(PER_PIXEL, f64::from(ensembles));
        println!("L {ensembles}: NMSE {:.2e}, expected {expected:.2e}; garden {:.2e}", found[0], found[1]);
        table.push(vec![f64::from(ensembles), found[0], expected, found[1]]);
        rows.push(Row { x: f64::from(ensembles), found: found[0], spread: 0.0, expected });
    }
    let panels = [(format!("plane of gray {GRAY}, {PER_PIXEL} points per pixel"), rows)];
    chart::figure(folder, "colors", Axis::tens("ensembles L", 1.0), Axis::tens("NMSE", 1e-6), &panels)?;
    super::write(folder, "colors.csv", &chart::csv("ensembles,NMSE,expected NMSE,NMSE of the garden", &table))
}

/// NMSE of the second cloud's image against the first one's.
fn distance(
    stage: &mut Stage,
    (clean, noisy, camera): &mut (DeviceCloud, DeviceCloud, Camera),
    side: u32,
    ensembles: u32,
) -> Result<f64> {
    let method = Method::SpbrSimplified(SpbrSimplified { ensembles, brightness: Brightness::Factor(1.0) });
    let standard = stage.image(clean, *camera, [side; 2], method)?;
    Ok(nmse(&standard, &stage.image(noisy, *camera, [side; 2], method)?))
}

/// Adds noise to the colors of a tenth of the points, clamped to the 256 levels.
fn recolored(mut points: Points, seed: u64) -> Points {
    let mut random = random(seed);
    for color in &mut points.colors {
        if random.random::<f64>() < MOVED {
            let mut noisy =
                |linear: f32| of_level(255.0 * f64::from(encode_srgb(linear)) + VARIANCE.sqrt() * gauss(&mut random));
            *color = Vec3::from_array(color.to_array().map(&mut noisy));
        }
    }
    points
}

/// Expected NMSE of the plane, with a Poisson number of points on a pixel, m of them on average.
///
/// M of the L images hit a pixel; each shows another point, of which a tenth has noise of the variance V in its gray.
/// So the error has the mean square V E\[M\] / 10 L², and the image G² E\[M²\] / L². Images are hit independently, with
/// a = 1 − e^(−m/L): E\[M\] = La, and E\[M²\] = La(1 − a + La).
fn expected(per_pixel: f64, ensembles: f64) -> f64 {
    let hit = -(-per_pixel / ensembles).exp_m1();
    let variance = VARIANCE * WEIGHTS.iter().map(|weight| weight * weight).sum::<f64>();
    MOVED * variance / (GRAY * GRAY) / (1.0 - hit + ensembles * hit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One opaque image shows a noisy point in a tenth of the pixels: 0.1 · 44.7 / 128² = 2.73e-4. As images become
    /// many, all of a pixel's 10 points are seen beside each other: an 11th of it.
    #[test]
    fn noise_falls_to_an_eleventh_with_ten_points_on_a_pixel() {
        assert!((expected(10.0, 1.0) - 2.728e-4).abs() < 1e-7, "{}", expected(10.0, 1.0));
        assert!((expected(10.0, 1e6) * 11.0 / expected(10.0, 1.0) - 1.0).abs() < 1e-3);
    }
}
