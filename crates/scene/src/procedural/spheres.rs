//! `spheres`: points with big radii of their own: one, two that intersect, or a soup. The first two are the synthetic
//! scenes of Seemann et al. (2018, Fig. 6 and 7), so that all points are soft for methods that have soft points.

use glam::DVec3;
use pellucid_core::cloud::Prepared;
use pellucid_core::cloud::field::Field;

use super::builder::{CloudBuilder, Rgb};
use super::random::Random;
use super::{Error, Generated};
use crate::prepare::{DEFAULT_NEIGHBORS, radius};

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
    let about = "Spheres, each a point with its own radius; all are soft for methods that have soft points.";
    let text = [about, "size = [512, 512]", "5.0", "fov_y = 35.0", "opacity = 0.5"];
    let mut cloud = builder.finish();
    cloud.prepared = Some(all_soft(count));
    Ok(Generated::alone("spheres", cloud, text))
}

/// A field F of 1 everywhere, above every threshold, which is stored with the points as `pellucid prepare` stores one:
/// methods without soft points don't see it.
fn all_soft(points: usize) -> Prepared {
    Prepared {
        neighbors: DEFAULT_NEIGHBORS,
        radius_cap: radius::DEFAULT_CAP,
        estimated_radii: false,
        field: Field::Property { name: "soft".to_owned() },
        values: vec![1.0; points],
        shadows: None,
    }
}
