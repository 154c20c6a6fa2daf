//! Random Gaussians.

use glam::{DVec3, Quat, Vec3};
use pellucid_core::cloud::gaussians::{Gaussians, REACH, coefficients};
use pellucid_core::points::Points;
use pellucid_scene::prepare::order;
use rand::RngExt;

use crate::random;

/// Gaussians around the origin.
#[derive(Debug, Clone)]
pub struct Soup {
    /// Seed of the generator.
    pub seed: u64,
    /// Number of Gaussians.
    pub count: usize,
    /// Standard deviations, evenly distributed in their logarithms, each axis by itself.
    pub extents: std::ops::Range<f32>,
    /// Opacities.
    pub opacities: std::ops::Range<f32>,
    /// Degree of the harmonics.
    pub degree: u32,
}

impl Default for Soup {
    fn default() -> Self {
        Self { seed: 1, count: 200, extents: 0.01..0.3, opacities: 0.0..1.0, degree: 0 }
    }
}

impl Soup {
    /// Makes the Gaussians in a cube of side 2, in canonical order.
    pub fn points(&self) -> Points {
        order::canonical(self.unordered())
    }

    /// Makes the Gaussians in the order of the generator.
    pub fn unordered(&self) -> Points {
        let (mut r, count) = (random(self.seed), self.count);
        let mut points = Points::default();
        let mut gaussians = Gaussians { degree: self.degree, ..Gaussians::default() };
        let [low, high] = [self.extents.start, self.extents.end].map(f32::ln);
        for _ in 0..count {
            let mut each = |range: std::ops::Range<f32>| Vec3::from([(); 3].map(|()| r.random_range(range.clone())));
            let (place, extents, color) = (each(-1.0..1.0), each(low..high), each(0.0..1.0));
            let harmonics: Vec<Vec3> = (0..coefficients(self.degree)).map(|_| each(-0.3..0.3)).collect();
            let turn = Quat::from_xyzw(
                r.random_range(-1.0..1.0),
                r.random_range(-1.0..1.0),
                r.random_range(-1.0..1.0),
                r.random_range(-1.0..1.0),
            );
            points.positions.push(DVec3::from(place));
            points.colors.push(color);
            points.opacities.push(r.random_range(self.opacities.clone()));
            gaussians.extents.push(extents.exp());
            gaussians.rotations.push(turn.normalize());
            gaussians.bases.push(color);
            gaussians.harmonics.extend(harmonics);
        }
        points.radii = gaussians.extents.iter().map(|extents| REACH * extents.max_element()).collect();
        points.gaussians = Some(gaussians);
        points
    }
}
