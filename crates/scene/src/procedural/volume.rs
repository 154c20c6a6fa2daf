//! `volume`: uniform random points in a cube, their radius solved for a wanted mean depth complexity.

use glam::{DVec2, DVec3};

use super::builder::CloudBuilder;
use super::random::Random;
use super::{Error, Generated};
use crate::covered::Pixels;

/// Image side in pixels, and world units over it: the cube [−1, 1]³ leaves a margin.
const SIZE: u32 = 512;
const HEIGHT: f64 = 2.5;

/// Reaches from any point of the cube over the whole image: at most √2·(1 + 1.25) world units.
const LARGEST_RADIUS: f64 = 3.2;

/// The search ends this near to the wanted layers; a pixel more or less on a rim is of this order for small clouds.
const TOLERANCE: f64 = 1e-3;

pub(super) fn generate([points, layers]: [f64; 2], seed: u64) -> Result<Generated, Error> {
    let points = points as usize;
    let mut random = Random::new(seed);
    let mut builder = CloudBuilder::with_capacity(points)?;
    for _ in 0..points {
        let p = DVec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0)));
        builder.point(p, (p * 0.5 + 0.5).to_array().map(|v| (40.0 + 215.0 * v) as u8));
    }
    let cloud = builder.finish();
    let radius = solve_radius(&cloud.positions, layers)? as f32;
    let about = format!("{points} random points; {layers} layers per covered pixel on average at this size and view.");
    let (image, lens) = (format!("size = [{SIZE}, {SIZE}]"), format!("height = {HEIGHT:?}"));
    let keys = format!("opacity = 0.05\nradius = {radius:?}");
    Ok(Generated::alone("volume", cloud, [&about, &image, "4.0", &lens, &keys]))
}

/// Bisection on the radius: the mean grows with it, up to the discreteness of pixels.
fn solve_radius(positions: &[DVec3], layers: f64) -> Result<f64, Error> {
    let scale = f64::from(SIZE) / HEIGHT;
    let centers = || positions.iter().map(|p| DVec2::new(p.x, -p.y) * scale + 0.5 * f64::from(SIZE));
    let mean_layers = |radius_px: f64| {
        let mut pixels = Pixels::none([SIZE; 2]);
        centers().for_each(|center| pixels.cover(center, radius_px));
        let [fragments, covered] = pixels.counts();
        if covered == 0 { 0.0 } else { fragments as f64 / covered as f64 }
    };
    let least = mean_layers(0.0);
    let most = positions.len() as f64;
    if layers < least * (1.0 - TOLERANCE) || layers > most {
        return Err(Error::OutOfReach { layers, points: positions.len(), least, most });
    }
    // Every pixel of the cube's image is covered about n·πR²/(its pixels) times, which starts the search near its end.
    let cube_px = (2.0 * scale) * (2.0 * scale);
    let guess = (layers * cube_px / (std::f64::consts::PI * most)).sqrt() / scale;
    let (mut low, mut high) = (0.0, LARGEST_RADIUS);
    let mut radius = guess.min(LARGEST_RADIUS);
    // The square law (layers ∝ R²) is exact except for rims and the center's own pixel, so a few steps with it suffice;
    // the halvings after it always end. A remainder after 50 steps is a jump of the mean, which no radius avoids.
    for step in 0..50 {
        let mean = mean_layers(radius * scale);
        if (mean / layers - 1.0).abs() < TOLERANCE {
            break;
        }
        if mean < layers {
            low = radius;
        } else {
            high = radius;
        }
        let next = radius * (layers / mean).sqrt();
        radius = if step < 10 && low < next && next < high { next } else { 0.5 * (low + high) };
    }
    Ok(radius)
}
