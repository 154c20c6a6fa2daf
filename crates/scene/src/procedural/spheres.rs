//! `spheres`: points with big radii of their own: one, two that intersect, or a soup.

use glam::DVec3;

use super::builder::{CloudBuilder, Rgb};
use super::random::Random;
use super::{Error, Generated};

const RED: Rgb = [225, 70, 60];
const BLUE: Rgb = [60, 105, 225];

pub(super) fn generate([count]: [f64; 1], seed: u64) -> Result<Generated, Error> {
    let count = count as usize;
    let mut builder = CloudBuilder::with_capacity(count)?;
    let mut sphere = |center: DVec3, radius: f64, color: Rgb| {
        builder.point(center, color);
        builder.radius(radius);
    };
    match count {
        1 => sphere(DVec3::ZERO, 1.0, RED),
        2 => {
            sphere(DVec3::new(-0.5, 0.0, 0.0), 0.75, RED);
            sphere(DVec3::new(0.5, 0.0, 0.0), 0.75, BLUE);
        }
        _ => {
            let mut random = Random::new(seed);
            for _ in 0..count {
                let center = DVec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0)));
                let radius = random.range(0.1, 0.35);
                let color = std::array::from_fn(|_| 40 + random.index(201) as u8);
                sphere(center, radius, color);
            }
        }
    }
    let text =
        ["Spheres, each a point with its own radius.", "size = [512, 512]", "5.0", "fov_y = 35.0", "opacity = 0.5"];
    Ok(Generated::alone("spheres", builder.finish(), text))
}
