//! Uchida et al. 2020, Fig. 6: a tenth of the points of a white plane is moved and red; how far is its image from that
//! of the plane without noise?

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_scene::{Brightness, Method, SpbrSimplified};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::chart::{self, Axis, Row};
use super::scans::MOVED;
use super::stage::{Stage, gauss, nmse, plane, random};

/// Side of the paper's image, its points, and the variance of its noise if the plane's side is 1.
const SIDE: f64 = 1024.0;
const POINTS: f64 = 1e7;
const VARIANCE: f64 = 1e-5;
/// Sides of the plane in pixels: what the paper's variance of 10 pixels² means, and what its NMSE of 0.247 at L = 1
/// means.
const PLANES: [f64; 2] = [1000.0, 847.0];

const ENSEMBLES: [u32; 15] = [1, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50, 75, 100, 125, 150];

/// Writes `noise.svg` and `noise.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let mut table = Vec::new();
    let mut panels = Vec::new();
    for plane_px in PLANES {
        let count = (POINTS * scale * scale).round() as usize;
        let per_pixel = POINTS / plane_px.powi(2);
        let clean = plane(count, stage.seed);
        // The same spread in pixels, while the plane has fewer.
        let noisy = moved(&clean, (VARIANCE / (scale * scale)).sqrt(), stage.seed + 1);
        let (mut clean, mut noisy) = (stage.upload(clean)?, stage.upload(noisy)?);
        let height = SIDE / plane_px;
        let mut rows = Vec::new();
        for ensembles in ENSEMBLES {
            let method = SpbrSimplified { ensembles, brightness: Brightness::Factor(1.0) };
            let mut image = |cloud| stage.square(cloud, side, height, Method::SpbrSimplified(method));
            let nmse = nmse(&image(&mut clean)?, &image(&mut noisy)?);
            let expected = expected(per_pixel, ensembles as usize, &mut random(stage.seed + 2));
            println!("plane of {plane_px} pixels, L {ensembles}: NMSE {nmse:.4}, expected {expected:.4}");
            table.push(vec![plane_px, count as f64, f64::from(ensembles), nmse, expected]);
            rows.push(Row { x: f64::from(ensembles), found: nmse, spread: 0.0, expected });
        }
        panels.push((format!("plane of {plane_px} of 1024 pixels, {per_pixel:.1} points per pixel"), rows));
    }
    chart::figure(folder, "noise", Axis::tens("ensembles L", 1.0), Axis::tens("NMSE", 1e-3), &panels)?;
    let header = "side of the plane in the paper's pixels,points,ensembles,NMSE,expected NMSE";
    super::write(folder, "noise.csv", &chart::csv(header, &table))
}

/// The plane with a tenth of its points moved by Gaussian noise of this standard deviation, and red.
fn moved(clean: &Points, deviation: f64, seed: u64) -> Points {
    let (mut points, mut random) = (clean.clone(), random(seed));
    for (position, color) in points.positions.iter_mut().zip(&mut points.colors) {
        if random.random::<f64>() < MOVED {
            *position += deviation * DVec3::from_array([(); 3].map(|()| gauss(&mut random)));
            *color = Vec3::X;
        }
    }
    points
}

/// Gray of red: 76 of 255.
const RED: f64 = 0.299;

/// Pixels behind an expected value: it is found to about 1%.
const TRIALS: usize = 50_000;

/// Expected NMSE of a pixel away from the plane's rim, by chance alone, without a geometry: a Poisson number of white
/// points, of those that were moved away, and of red ones that came, half of them before the plane. Each image shuffles
/// its points into ensembles anew.
fn expected(per_pixel: f64, ensembles: usize, random: &mut Pcg64) -> f64 {
    let (mut error, mut whole) = (0.0, 0.0);
    for _ in 0..TRIALS {
        let white = poisson((1.0 - MOVED) * per_pixel, random);
        let [away, red] = [(); 2].map(|()| poisson(MOVED * per_pixel, random));
        let mut clean = vec![0.0; ensembles];
        (0..white + away).for_each(|_| clean[random.random_range(0..ensembles)] = 1.0);
        let mut noisy = vec![0.0; ensembles];
        (0..white).for_each(|_| noisy[random.random_range(0..ensembles)] = 1.0);
        let mut reds: Vec<_> = (0..red).map(|_| (random.random::<bool>(), random.random_range(0..ensembles))).collect();
        reds.sort_unstable();
        for (is_before, ensemble) in reds {
            if is_before || noisy[ensemble] == 0.0 {
                noisy[ensemble] = RED;
            }
        }
        let [clean, noisy] = [clean, noisy].map(|values| values.iter().sum::<f64>() / ensembles as f64);
        (error, whole) = (error + (clean - noisy).powi(2), whole + clean * clean);
    }
    error / whole
}

/// A Poisson number, by the product of uniform ones (Knuth); fit for means of some tens.
fn poisson(mean: f64, random: &mut Pcg64) -> usize {
    let limit = (-mean).exp();
    let (mut product, mut count) = (random.random::<f64>(), 0);
    while product > limit {
        product *= random.random::<f64>();
        count += 1;
    }
    count
}
