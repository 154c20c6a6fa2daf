//! `volume`: uniform random points in a cube, their radius solved for a wanted mean depth complexity.

use glam::{DVec2, DVec3};

use super::builder::CloudBuilder;
use super::random::Random;
use super::{Builtin, Error, Generated, Given, MAX_POINTS, Parameter};

const PARAMETERS: [Parameter; 2] = [
    Parameter::count("points", 200_000.0, 1.0, MAX_POINTS, "points in the cube"),
    Parameter::real("layers", 32.0, 1.0, 100_000.0, "mean fragments of the pixels that hold any"),
];

pub(super) const BUILTIN: Builtin = Builtin {
    name: "volume",
    summary: "uniform random points in a cube, with a wanted mean number of layers per covered pixel",
    parameters: &PARAMETERS,
    generate,
};

/// Image side in pixels, and world units over it: the cube [−1, 1]³ leaves a margin.
const SIZE: usize = 512;
const HEIGHT: f64 = 2.5;

/// Reaches from any point of the cube over the whole image: at most √2·(1 + 1.25) world units.
const LARGEST_RADIUS: f64 = 3.2;

/// The search ends this near to the wanted layers; a pixel more or less on a rim is of this order for small clouds.
const TOLERANCE: f64 = 1e-3;

fn generate(given: &Given<'_>, seed: u64) -> Result<Generated, Error> {
    let [points, layers] = given.values(&PARAMETERS)?;
    let points = points as usize;
    let mut random = Random::new(seed);
    let mut builder = CloudBuilder::with_capacity(points)?;
    for _ in 0..points {
        let p = DVec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0)));
        builder.point(p, (p * 0.5 + 0.5).to_array().map(|v| (40.0 + 215.0 * v) as u8));
    }
    let cloud = builder.finish();
    let radius = solve_radius(&cloud.positions, layers)? as f32;
    let scene_toml = format!(
        r#"# {points} random points; {layers} layers per covered pixel on average at this size and view.
[image]
size = [{SIZE}, {SIZE}]

[camera]
eye = [0.0, 0.0, 4.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
height = {HEIGHT:?}

[[cloud]]
path = "volume.ply"
opacity = 0.05
radius = {radius:?}

[method]
name = "abuffer"
"#
    );
    Ok(Generated { clouds: vec![("volume.ply".to_owned(), cloud)], scene_toml })
}

/// Bisection on the radius: the mean grows with it, up to the discreteness of pixels.
fn solve_radius(positions: &[DVec3], layers: f64) -> Result<f64, Error> {
    let scale = SIZE as f64 / HEIGHT;
    let centers = || positions.iter().map(|p| DVec2::new(p.x, -p.y) * scale + 0.5 * SIZE as f64);
    let mut counter = Counter::new();
    let least = counter.mean_layers(centers(), 0.0);
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
        let mean = counter.mean_layers(centers(), radius * scale);
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

/// Counts fragments and covered pixels of screen-aligned discs by the coverage rule of the disc methods.
struct Counter {
    /// Change of each pixel's count against its left neighbor; one column more than the image.
    changes: Vec<i64>,
}

impl Counter {
    fn new() -> Self {
        Self { changes: vec![0; (SIZE + 1) * SIZE] }
    }

    /// Fragments over covered pixels; 0 if nothing is covered.
    fn mean_layers(&mut self, centers: impl Iterator<Item = DVec2>, radius_px: f64) -> f64 {
        self.changes.fill(0);
        for center in centers {
            self.add_disc(center, radius_px);
        }
        let (mut fragments, mut covered) = (0i64, 0i64);
        for row in self.changes.chunks_exact(SIZE + 1) {
            let mut count = 0;
            for change in &row[..SIZE] {
                count += change;
                fragments += count;
                covered += i64::from(count > 0);
            }
        }
        if covered == 0 { 0.0 } else { fragments as f64 / covered as f64 }
    }

    fn add_disc(&mut self, center: DVec2, radius: f64) {
        let own = center.floor();
        let first = (center.y - radius - 0.5).ceil().min(own.y).max(0.0) as usize;
        let last = ((center.y + radius - 0.5).floor().max(own.y).min(SIZE as f64 - 1.0)) as usize;
        for row in first..=last {
            let dy = row as f64 + 0.5 - center.y;
            // NaN where the row misses the disc; then `f64::min` and `max` keep the pixel of the center alone.
            let half = (radius * radius - dy * dy).sqrt();
            let (mut left, mut right) = ((center.x - half - 0.5).ceil(), (center.x + half - 0.5).floor());
            if row as f64 == own.y {
                left = left.min(own.x);
                right = right.max(own.x);
            }
            if left <= right {
                let left = left.max(0.0) as usize;
                let right = right.min(SIZE as f64 - 1.0) as usize;
                self.changes[row * (SIZE + 1) + left] += 1;
                self.changes[row * (SIZE + 1) + right + 1] -= 1;
            }
        }
    }
}
