//! `plane`: random points on a white square before black (Tanaka et al., Fig. 5).

use glam::DVec3;

use super::builder::CloudBuilder;
use super::random::{Random, unit_circle};
use super::{Error, Generated};

/// Half the side of the square, which is centered on the origin in the plane z = 0 before the tilt.
const HALF: f64 = 1.0;

pub(super) fn generate([points, tilt, opacity]: [f64; 3], seed: u64) -> Result<Generated, Error> {
    let points = points as usize;
    let (cos, sin) = unit_circle(tilt / 360.0);
    let (right, normal) = (DVec3::new(cos, 0.0, -sin), DVec3::new(sin, 0.0, cos));
    let mut random = Random::new(seed);
    let mut builder = CloudBuilder::with_capacity(points)?;
    for _ in 0..points {
        let (x, y) = (random.range(-HALF, HALF), random.range(-HALF, HALF));
        builder.point(x * right + y * DVec3::Y, [255; 3]);
        builder.normal(normal);
    }
    // Independent points leave exp(−π·0.8²) = 13% of the square uncovered, whatever their number.
    let radius = (0.8 * 2.0 * HALF / (points as f64).sqrt()) as f32;
    let about =
        format!("A white plane of {points} random points after Tanaka et al., Fig. 5, tilted by {tilt} degrees.");
    let image = "size = [512, 512]\nbackground = [0.0, 0.0, 0.0]";
    let keys = format!("color_by = \"rgb\"\nopacity = {opacity:?}\nradius = {radius:?}");
    Ok(Generated::alone("plane", builder.finish(), [&about, image, "4.0", "height = 2.5", &keys]))
}
