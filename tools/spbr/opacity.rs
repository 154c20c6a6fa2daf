//! Tanaka et al. 2016, Fig. 5: a white plane shows its opacity, whatever the number of its points.

use std::path::Path;

use pellucid_engine::Result;
use pellucid_scene::{Method, Spbr};

use super::chart::{self, Axis, Row};
use super::stage::{Stage, plane};

/// Side of the paper's image, its ensembles, its numbers of points.
const SIDE: f64 = 512.0;
const ENSEMBLES: u32 = 1000;
const POINTS: [f64; 2] = [1e7, 4e7];

/// Writes `opacity.svg` and `opacity.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let mut table = Vec::new();
    let mut panels = Vec::new();
    for points in POINTS {
        // As many in each pixel as in the paper.
        let per_pixel = points / SIDE.powi(2);
        let count = (per_pixel * f64::from(side).powi(2)).round() as usize;
        let mut cloud = stage.upload(plane(count, stage.seed))?;
        let mut rows = Vec::new();
        for alpha in [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9] {
            let method = Method::Spbr(Spbr { ensembles: ENSEMBLES, ..Spbr::default() });
            let image = stage.thinned(&mut cloud, side, alpha as f32, method)?;
            let grays: Vec<_> = image.rgba.iter().map(|pixel| 255.0 * f64::from(pixel[0])).collect();
            let mean = grays.iter().sum::<f64>() / grays.len() as f64;
            let spread = (grays.iter().map(|gray| (gray - mean).powi(2)).sum::<f64>() / grays.len() as f64).sqrt();
            // The share of the ensembles that a point is in.
            let q = -(1.0f64 - alpha).ln() / per_pixel;
            let independent = 255.0 * independent_spread(alpha, per_pixel, q);
            let expected_spread = 255.0 * expected_spread(alpha, per_pixel, q);
            let k = q * f64::from(ENSEMBLES);
            println!(
                "{points:.0e} points ({count}), α {alpha}, k {k:.2}: mean {mean:.2} of {:.2}, spread {spread:.2} of {expected_spread:.2}, by independent copies {independent:.2}",
                255.0 * alpha
            );
            table.push(vec![points, count as f64, alpha, k, mean, 255.0 * alpha, spread, expected_spread, independent]);
            rows.push(Row { x: alpha, found: mean, spread, expected: 255.0 * alpha });
        }
        panels.push((format!("{per_pixel:.1} points per pixel (n = {points:.0e} on 512²)"), rows));
    }
    chart::figure(folder, "opacity", Axis::even("opacity α"), Axis::even("mean gray, bars: spread"), &panels)?;
    let header =
        "points of the paper,points,alpha,k,mean,expected mean,spread,expected spread,spread of independent copies";
    super::write(folder, "opacity.csv", &chart::csv(header, &table))
}

/// Standard deviation of a pixel over the number of its points (Poisson) and the ensembles they are in, as they are
/// shuffled here: the ensembles of a pass have no point in common, those of two passes as many as chance brings. Of
/// large clouds a pass has a part of the points alone, which adds some.
fn expected_spread(alpha: f64, per_pixel: f64, q: f64) -> f64 {
    let ensembles = f64::from(ENSEMBLES);
    let of_pass = (1.0 / q).floor().clamp(1.0, ensembles);
    let (passes, rest) = ((ensembles / of_pass).floor(), ensembles % of_pass);
    let pairs = passes * of_pass * (ensembles - of_pass) + rest * (ensembles - rest);
    let between = (1.0 - alpha).powi(2) * (per_pixel * q * q).exp_m1();
    (alpha * (1.0 - alpha) / ensembles + pairs / ensembles.powi(2) * between).sqrt()
}

/// Returns the spread if each point were in that share of the ensembles at random, as in the paper: between any two of
/// them.
fn independent_spread(alpha: f64, per_pixel: f64, q: f64) -> f64 {
    let between = (1.0 - alpha).powi(2) * (per_pixel * q * q).exp_m1();
    (between + alpha * (1.0 - alpha) / f64::from(ENSEMBLES)).sqrt()
}
