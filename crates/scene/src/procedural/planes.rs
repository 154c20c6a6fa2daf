//! `planes`: parallel planes of random points that fill the image, for which alpha blending predicts the picture.

use glam::DVec3;

use super::builder::CloudBuilder;
use super::random::Random;
use super::stack::COLORS;
use super::{Error, Generated, MAX_POINTS};

/// Half the side of a plane, and of what the camera sees of it, so that no rim is in the image.
const HALF: f64 = 1.0;
const SEEN: f64 = 0.9;

pub(super) fn generate([planes, points, size, front, back]: [f64; 5], seed: u64) -> Result<Generated, Error> {
    let [planes, points, size] = [planes, points, size].map(|count| count as usize);
    if (planes * points) as f64 > MAX_POINTS {
        return Err(Error::TooLarge { points: planes * points, bytes: planes * points * size_of::<DVec3>() });
    }
    let mut random = Random::new(seed);
    let mut scene_toml = format!(
        r#"# {planes} planes of {points} random points each; the nearest first.
[image]
size = [{size}, {size}]
background = [0.0, 0.0, 0.0]

[camera]
eye = [0.0, 0.0, 2.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 1.0, 0.0]
height = {height:?}
near = 0.5
far = 4.0

[method]
name = "spbr"
"#,
        height = 2.0 * SEEN
    );
    // Discs of about the points' distance, for methods that draw such.
    let radius = (0.8 * 2.0 * HALF / (points as f64).sqrt()) as f32;
    let mut clouds = Vec::new();
    for plane in 0..planes {
        let share = plane as f64 / (planes - 1).max(1) as f64;
        let (opacity, z) = (front + share * (back - front), -share);
        let mut builder = CloudBuilder::with_capacity(points)?;
        for _ in 0..points {
            let (x, y) = (random.range(-HALF, HALF), random.range(-HALF, HALF));
            builder.point(DVec3::new(x, y, z), COLORS[plane % COLORS.len()]);
        }
        let path = format!("plane-{}.ply", plane + 1);
        scene_toml += &format!("\n[[cloud]]\npath = \"{path}\"\nopacity = {opacity:?}\nradius = {radius:?}\n");
        clouds.push((path, builder.finish()));
    }
    Ok(Generated { clouds, scene_toml })
}
