//! Soft spheres and discs by their formulas as they are printed.

use std::f32::consts::PI;

use glam::Vec3;

use crate::check::stage::Dot;
use pellucid_core::camera::Camera;
use pellucid_reference::View;
use pellucid_reference::soft::Ray;

/// Soft spheres (Seemann et al. 2018) as the paper writes them: the ray by b² − c, Eq. 5 to 7 with a difference of two
/// antiderivatives and of their logarithms, running sums of colors and weights, 1 − exp(−x).
#[derive(Debug, Clone, Copy)]
pub struct Soft {
    /// λ.
    pub lambda: f32,
    /// The part of the ray that is looked at.
    pub limits: [f32; 2],
    /// Spheres that an array holds.
    pub most_open: usize,
}

impl Soft {
    /// Returns the method with a sufficiently long array, and no limits.
    pub fn new(lambda: f32) -> Self {
        Self { lambda, limits: [f32::NEG_INFINITY, f32::INFINITY], most_open: usize::MAX }
    }

    /// The images' pixels, row by row.
    pub fn image(&self, dots: &[Dot], camera: &Camera, size: [u32; 2]) -> Vec<[f32; 4]> {
        let rows = 0..size[1];
        rows.flat_map(|y| (0..size[0]).map(move |x| [x, y])).map(|at| self.pixel(dots, camera, size, at)).collect()
    }

    /// A single pixel.
    pub fn pixel(&self, dots: &[Dot], camera: &Camera, size: [u32; 2], at: [u32; 2]) -> [f32; 4] {
        let ray = Ray::new(View::new(camera, size), at);
        let (origin, direction) = (ray.origin.as_vec3(), ray.direction.as_vec3());
        let mut spheres = Vec::new();
        for dot in dots {
            let center = camera.to_view(dot.position).as_vec3() - origin;
            let middle = center.dot(direction);
            let squared = center.dot(center) - middle * middle;
            let discriminant = dot.radius * dot.radius - squared;
            if discriminant >= 0.0 {
                let half = discriminant.sqrt();
                let distance = squared.max(0.0).sqrt();
                spheres.push(Sphere { middle, half, distance, radius: dot.radius, color: dot.color });
            }
        }
        self.blend(&spheres)
    }

    fn blend(&self, spheres: &[Sphere]) -> [f32; 4] {
        let cut = |s: f32| s.clamp(self.limits[0], self.limits[1]);
        let ends = |(i, s): (usize, &Sphere)| [(cut(s.middle - s.half), i, true), (cut(s.middle + s.half), i, false)];
        let mut events: Vec<(f32, usize, bool)> = spheres.iter().enumerate().flat_map(ends).collect();
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut color, mut weight, mut open) = (Vec3::ZERO, 0f32, Vec::new());
        let (mut sum, mut rest) = (Vec3::ZERO, 1f32);
        for (i, (from, which, enters)) in events.iter().enumerate() {
            let sphere = &spheres[*which];
            let own = 1.0 - sphere.distance / sphere.radius;
            if *enters && open.len() < self.most_open {
                (color, weight) = (color + own * sphere.color, weight + own);
                open.push(*which);
            } else if let Some(place) = open.iter().position(|other| !*enters && other == which) {
                (color, weight) = (color - own * sphere.color, weight - own);
                open.swap_remove(place);
            }
            let Some((to, ..)) = events.get(i + 1).filter(|_| !open.is_empty()) else { continue };
            let depth: f32 = open.iter().map(|i| self.lambda * spheres[*i].integral(*from, *to)).sum();
            let opacity = 1.0 - (-depth).exp();
            sum += rest * opacity * color / weight;
            rest *= 1.0 - opacity;
        }
        [sum.x, sum.y, sum.z, 1.0 - rest]
    }
}

struct Sphere {
    middle: f32,
    half: f32,
    distance: f32,
    radius: f32,
    color: Vec3,
}

impl Sphere {
    fn integral(&self, from: f32, to: f32) -> f32 {
        let squared = self.distance * self.distance;
        let antiderivative = |s: f32| {
            let x = s - self.middle;
            let root = (x * x + squared).sqrt();
            self.radius * x - 0.5 * (x * root + squared * (x + root).ln())
        };
        antiderivative(to) - antiderivative(from)
    }
}

/// The profile of a soft disc (Eq. 19 without λ) at a distance from its center.
pub fn disc(distance: f32, radius: f32) -> f32 {
    ((PI * distance / radius).cos() + 1.0) / 2.0
}
