//! The kernel `ellipsoid`: constant density within the semi-axes s (Mai et al. 2025, "EVER: Exact Volumetric Ellipsoid Rendering").
//!
//! The density per unit of length is σ = −ln(1 − min(o, `alpha_max`)) / (2·min s), so that a ray along the shortest axis meets the opacity of the splat.
//! Between the places where a ray enters or leaves an ellipsoid, or meets a disc, densities add up: over a length Δ the opacity is
//! 1 − exp(−Δ·Σσ), and the color Σσc / Σσ. A Gaussian without thickness is a disc of opacity o; of infinite density it is opaque where it is
//! entered. Rays are cut at near, and not at far.
//!
//! In coordinates y of the ellipsoid, x = μ + M y, a ray is y = g + s·h, and |y|² ≤ 1 for s within √(|h|² − |g × h|²) / |h|² of −g·h / |h|².

use glam::DVec3;

use super::super::abuffer::{Composite, of_disc};
use super::super::soft::Ray;
use super::super::{Picture, gaussians};
use super::{Hit, Placed};
use crate::camera::Camera;
use crate::points::Points;
use crate::scene::{Discs, GaussianSettings, Kernel};

/// What a ray meets of a splat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// The point's place in the canonical order.
    pub index: u32,
    /// Where it begins on the ray, as a length from the ray's origin, not before near.
    pub start: f64,
    /// Where it ends; a surface ends where it begins.
    pub end: f64,
    /// What it does to light.
    pub matter: Matter,
}

/// What a body does to light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Matter {
    /// Optical depth of a unit of length.
    Density(f64),
    /// Opacity of a surface.
    Surface(f64),
}

impl Body {
    /// The opacity of the whole body.
    pub fn opacity(&self) -> f64 {
        match self.matter {
            Matter::Density(density) => -(-density * (self.end - self.start)).exp_m1(),
            Matter::Surface(opacity) => opacity,
        }
    }
}

/// A chord of this share of its distance is one place: the difference of its ends has too few digits, its half has all.
const THIN: f64 = 1e-9;

/// σ per unit of length for an opacity and the shortest semi-axis. Infinite where nothing is seen through it, or without thickness.
pub fn density(opacity: f64, shortest: f64, settings: &GaussianSettings) -> f64 {
    -(-opacity.min(f64::from(settings.alpha_max))).ln_1p() / (2.0 * shortest)
}

/// The ray through a pixel's centre.
pub fn ray(camera: &Camera, size: [u32; 2], pixel: [u32; 2]) -> Ray {
    Ray::new(camera, size, pixel)
}

/// What a pixel's ray meets of a Gaussian.
pub fn meet(placed: &Placed, settings: &GaussianSettings, pixel: [u32; 2], index: u32) -> Option<Body> {
    let ray = ray(placed.camera, placed.size, pixel);
    let near = placed.camera.near * ray.stretch;
    let lengths = placed.lengths();
    let shortest = lengths.min_element();
    if shortest == 0.0 {
        let at = meet_flat(placed, &ray)?;
        return (at >= near).then_some(Body { index, start: at, end: at, matter: Matter::Surface(placed.opacity) });
    }
    let scaled = |v: DVec3| placed.axes.transpose() * v / (lengths * lengths);
    let (g, h) = (scaled(ray.origin - placed.center), scaled(ray.direction));
    let square = h.length_squared();
    let within = square - g.cross(h).length_squared();
    if within.is_nan() || within < 0.0 {
        return None;
    }
    let (middle, half) = (-g.dot(h) / square, within.sqrt() / square);
    let (start, end) = ((middle - half).max(near), middle + half);
    if end < near {
        return None;
    }
    let density = density(placed.opacity, shortest, settings);
    if density.is_infinite() {
        return Some(Body { index, start, end: start, matter: Matter::Surface(1.0) });
    }
    if end - start < THIN * end.abs() && middle - half >= near {
        let opacity = -(-density * 2.0 * half).exp_m1();
        return Some(Body { index, start, end: start, matter: Matter::Surface(opacity) });
    }
    Some(Body { index, start, end, matter: Matter::Density(density) })
}

/// Where a ray meets a Gaussian of which one axis has no length; none of a needle.
fn meet_flat(placed: &Placed, ray: &Ray) -> Option<f64> {
    let sides: Vec<DVec3> = (0..3).map(|k| placed.axes.col(k)).filter(|axis| *axis != DVec3::ZERO).collect();
    let [a, b] = sides[..] else { return None };
    let normal = a.cross(b).normalize_or_zero();
    let at = normal.dot(placed.center - ray.origin) / normal.dot(ray.direction);
    let from_center = ray.origin + at * ray.direction - placed.center;
    let square = (from_center.dot(a) / a.length_squared()).powi(2) + (from_center.dot(b) / b.length_squared()).powi(2);
    (at.is_finite() && square <= 1.0).then_some(at)
}

/// The pixels that an ellipsoid covers when nothing else is there; key and z are where it is entered.
pub(super) fn footprint(placed: &Placed, settings: &GaussianSettings) -> Vec<Hit> {
    let hit = |[x, y]: [u32; 2]| {
        let body = meet(placed, settings, [x, y], 0)?;
        let z = body.start / ray(placed.camera, placed.size, [x, y]).stretch;
        Some(Hit { x, y, alpha: body.opacity(), key: z, z })
    };
    placed.window(super::ray::bounds(placed, 1.0)).filter_map(hit).collect()
}

/// What the rays of all pixels meet, row by row: Gaussians and discs, by the order of their points.
pub fn bodies(camera: &Camera, size: [u32; 2], points: &Points, discs: &Discs) -> Vec<Vec<Body>> {
    let mut pixels = vec![Vec::new(); size[0] as usize * size[1] as usize];
    for index in 0..points.len() {
        let Some(gaussian) = gaussians::gaussian(points, index) else {
            for (pixel, fragment) in of_disc(camera, size, points, index, discs) {
                let place = [pixel as u32 % size[0], pixel as u32 / size[0]];
                let at = fragment.z * ray(camera, size, place).stretch;
                let matter = Matter::Surface(fragment.alpha);
                pixels[pixel].push(Body { index: index as u32, start: at, end: at, matter });
            }
            continue;
        };
        let Some(placed) = Placed::new(camera, size, &gaussian) else { continue };
        for [x, y] in placed.window(super::ray::bounds(&placed, 1.0)) {
            let body = meet(&placed, &discs.gaussians, [x, y], index as u32);
            pixels[y as usize * size[0] as usize + x as usize].extend(body);
        }
    }
    pixels
}

/// Composes the bodies on a ray. `colors` holds a color for each point, `stretch` is length over depth.
pub fn blend(bodies: &[Body], colors: &[DVec3], stretch: f64) -> Composite {
    let mut places: Vec<f64> = bodies.iter().flat_map(|body| [body.start, body.end]).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut light = Light { color: DVec3::ZERO, log_transmittance: 0.0 };
    for (k, place) in places.iter().enumerate() {
        for body in bodies.iter().filter(|body| body.start == *place) {
            if let Matter::Surface(opacity) = body.matter {
                light.meet(opacity.min(1.0), (-opacity).ln_1p(), colors[body.index as usize]);
            }
        }
        let Some(next) = places.get(k + 1) else { break };
        let open = bodies.iter().filter(|body| body.start <= *place && body.end >= *next);
        let dense = open.filter_map(|body| match body.matter {
            Matter::Density(density) => Some((density, colors[body.index as usize])),
            Matter::Surface(_) => None,
        });
        let (sum, tinted) = dense.fold((0.0, DVec3::ZERO), |(sum, tinted), (d, c)| (sum + d, tinted + d * c));
        if sum > 0.0 {
            let depth = sum * (next - place);
            light.meet(-(-depth).exp_m1(), -depth, tinted / sum);
        }
    }
    let first = bodies.iter().filter(|body| body.opacity() > 0.0).map(|body| body.start / stretch);
    Composite {
        color: light.color,
        // From zero, so that nothing drawn is 0 and not the −0 that −expm1(0) yields.
        alpha: 0.0 - light.log_transmittance.exp_m1(),
        depth: first.fold(f64::INFINITY, f64::min),
    }
}

/// What has been seen so far.
struct Light {
    color: DVec3,
    log_transmittance: f64,
}

impl Light {
    fn meet(&mut self, opacity: f64, log_transmittance: f64, color: DVec3) {
        self.color += color * (opacity * self.log_transmittance.exp());
        self.log_transmittance += log_transmittance;
    }
}

/// True if a picture is made of ellipsoids.
pub fn are_drawn(points: &Points, discs: &Discs) -> bool {
    discs.gaussians.kernel == Kernel::Ellipsoid && (0..points.len()).any(|i| gaussians::gaussian(points, i).is_some())
}

/// The whole image of `abuffer`, with ellipsoids ([`are_drawn`]). `colors` holds a color for each point, shaded and in the space that blending
/// runs in. A count is that of bodies.
pub fn render(camera: &Camera, size: [u32; 2], points: &Points, colors: &[DVec3], discs: &Discs) -> Picture {
    let bodies = bodies(camera, size, points, discs);
    let stretch = |pixel: usize| ray(camera, size, [pixel as u32 % size[0], pixel as u32 / size[0]]).stretch;
    let blended = bodies.iter().enumerate().map(|(pixel, list)| blend(list, colors, stretch(pixel)));
    let pixels: Vec<Composite> = blended.collect();
    Picture {
        width: size[0],
        height: size[1],
        rgba: pixels.iter().map(|p| p.color.extend(p.alpha).to_array()).collect(),
        depth: pixels.iter().map(|p| p.depth).collect(),
        counts: bodies.iter().map(|list| list.len() as u32).collect(),
    }
}
