//! The kernel `ellipsoid`: constant density within the semi-axes s (Mai et al. 2025, "EVER: Exact Volumetric Ellipsoid
//! Rendering").
//!
//! The density per unit of length is σ = −ln(1 − min(o, `alpha_max`)) / (2·min s), so that a ray along the shortest
//! axis meets the opacity of the splat. Between the places where a ray enters or leaves an ellipsoid, or meets a disc,
//! densities add up: over a length Δ the opacity is 1 − exp(−Δ·Σσ), and the color Σσc / Σσ. A Gaussian without
//! thickness is a disc of opacity o; of infinite density it is opaque where it is entered. Rays are cut at near, and
//! not at far.
//!
//! In coordinates y of the ellipsoid, x = μ + M y, a ray is y = g + s·h, and |y|² ≤ 1 for s within √(|h|² − |g × h|²) /
//! |h|² of −g·h / |h|².

use glam::DVec3;

use super::super::fragments::{Composite, of_disc};
use super::super::soft::Ray;
use super::super::{ReferencePicture, gaussians};
use super::{Hit, PlacedGaussian};
use crate::View;
use pellucid_core::points::Points;
use pellucid_scene::{Discs, GaussianSettings, Kernel};

/// The part of a splat on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// The point's place in the canonical order.
    pub index: u32,
    /// Beginning on the ray, as a length from the ray's origin, not before near.
    pub start: f64,
    /// End on the ray; a surface ends where it begins.
    pub end: f64,
    /// Effect of the ellipsoid on light.
    pub matter: Matter,
}

/// The effect of a body on light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Matter {
    /// Optical depth of a unit of length.
    Density(f64),
    /// Opacity of a surface.
    Surface(f64),
}

impl Body {
    /// Returns the opacity of the whole body.
    pub fn opacity(&self) -> f64 {
        match self.matter {
            Matter::Density(density) => -(-density * (self.end - self.start)).exp_m1(),
            Matter::Surface(opacity) => opacity,
        }
    }
}

/// A chord of this share of its distance is one place: the difference of its ends has too few digits, its half has all.
const THIN: f64 = 1e-9;

/// σ per unit of length for an opacity and the shortest semi-axis. Infinite where nothing is seen through it, or
/// without thickness.
pub fn density(opacity: f64, shortest: f64, settings: &GaussianSettings) -> f64 {
    -(-opacity.min(f64::from(settings.alpha_max))).ln_1p() / (2.0 * shortest)
}

/// Returns the part of a Gaussian on a pixel's ray; `None` where the ray misses it.
pub fn meet(placed: &PlacedGaussian, settings: &GaussianSettings, pixel: [u32; 2], index: u32) -> Option<Body> {
    let ray = Ray::new(placed.view, pixel);
    let near = placed.view.camera.near * ray.stretch;
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

/// Returns where a ray meets a Gaussian of which one axis has no length; none of a needle.
fn meet_flat(placed: &PlacedGaussian, ray: &Ray) -> Option<f64> {
    let sides: Vec<DVec3> = (0..3).map(|k| placed.axes.col(k)).filter(|axis| *axis != DVec3::ZERO).collect();
    let [a, b] = sides[..] else { return None };
    let normal = a.cross(b).normalize_or_zero();
    let at = normal.dot(placed.center - ray.origin) / normal.dot(ray.direction);
    let from_center = ray.origin + at * ray.direction - placed.center;
    let square = (from_center.dot(a) / a.length_squared()).powi(2) + (from_center.dot(b) / b.length_squared()).powi(2);
    (at.is_finite() && square <= 1.0).then_some(at)
}

/// Returns the pixels that an ellipsoid covers when nothing else is there; key and z are where it is entered.
pub(super) fn footprint(placed: &PlacedGaussian, settings: &GaussianSettings) -> Vec<Hit> {
    let hit = |[x, y]: [u32; 2]| {
        let body = meet(placed, settings, [x, y], 0)?;
        let z = body.start / Ray::new(placed.view, [x, y]).stretch;
        Some(Hit { x, y, alpha: body.opacity(), key: z, z })
    };
    placed.window(super::ray::bounds(placed, 1.0)).filter_map(hit).collect()
}

/// Returns the bodies on the rays of all pixels, row by row: Gaussians and discs, by the order of their points.
pub fn bodies(view: View, points: &Points, discs: &Discs) -> Vec<Vec<Body>> {
    let mut pixels = vec![Vec::new(); view.pixels()];
    for index in 0..points.len() {
        let Some(gaussian) = gaussians::gaussian(points, index) else {
            for (pixel, fragment) in of_disc(view, points, index, discs) {
                let at = fragment.z * Ray::new(view, view.place(pixel)).stretch;
                let matter = Matter::Surface(fragment.alpha);
                pixels[pixel].push(Body { index: index as u32, start: at, end: at, matter });
            }
            continue;
        };
        let Some(placed) = PlacedGaussian::new(view, &gaussian) else { continue };
        for [x, y] in placed.window(super::ray::bounds(&placed, 1.0)) {
            let body = meet(&placed, &discs.gaussians, [x, y], index as u32);
            pixels[view.index(x, y)].extend(body);
        }
    }
    pixels
}

/// A piece of a ray, from near to far.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Piece {
    /// Segment of a length, with the sum of the densities and their mean color.
    Dense { start: f64, length: f64, density: f64, color: DVec3 },
    /// A surface.
    Surface { at: f64, opacity: f64, color: DVec3 },
}

/// The pieces that the bodies on a ray divide it into, without those that are clear.
fn pieces(bodies: &[Body], colors: &[DVec3]) -> Vec<Piece> {
    let color = |body: &Body| colors[body.index as usize];
    let mut places: Vec<f64> = bodies.iter().flat_map(|body| [body.start, body.end]).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut pieces = Vec::new();
    for (k, place) in places.iter().enumerate() {
        pieces.extend(bodies.iter().filter(|body| body.start == *place).filter_map(|body| match body.matter {
            Matter::Surface(opacity) => Some(Piece::Surface { at: *place, opacity, color: color(body) }),
            Matter::Density(_) => None,
        }));
        let Some(next) = places.get(k + 1) else { break };
        let open = bodies.iter().filter(|body| body.start <= *place && body.end >= *next);
        let dense = open.filter_map(|body| match body.matter {
            Matter::Density(density) => Some((density, color(body))),
            Matter::Surface(_) => None,
        });
        let (density, tinted) = dense.fold((0.0, DVec3::ZERO), |(sum, tinted), (d, c)| (sum + d, tinted + d * c));
        if density > 0.0 {
            pieces.push(Piece::Dense { start: *place, length: next - place, density, color: tinted / density });
        }
    }
    pieces
}

impl Piece {
    /// ln of what it lets through.
    fn log_transmittance(&self) -> f64 {
        match *self {
            Self::Dense { length, density, .. } => -length * density,
            Self::Surface { opacity, .. } => (-opacity).ln_1p(),
        }
    }

    fn color(&self) -> DVec3 {
        match *self {
            Self::Dense { color, .. } | Self::Surface { color, .. } => color,
        }
    }

    /// Returns where so much of the light that reaches it is left, if it doesn't let more through.
    fn place_of(&self, left: f64) -> f64 {
        match *self {
            Self::Dense { start, length, density, .. } => start + (-left.ln() / density).clamp(0.0, length),
            Self::Surface { at, .. } => at,
        }
    }

    /// ∫ s dA over it, for light of 1 that reaches it.
    fn moment(&self) -> f64 {
        let opacity = -self.log_transmittance().exp_m1();
        match *self {
            Self::Surface { at, .. } => at * opacity,
            Self::Dense { start, length, density, .. } => {
                let x = length * density;
                // x exp(-x) is nearly 1 - exp(-x) where there is little of either.
                let beyond = if x < 1e-4 { length * x * (0.5 - x / 3.0) } else { (opacity - x * (-x).exp()) / density };
                start * opacity + beyond
            }
        }
    }
}

/// Composes the bodies on a ray. `colors` holds a color for each point, `stretch` is length over depth.
pub fn blend(bodies: &[Body], colors: &[DVec3], stretch: f64) -> Composite {
    let (mut color, mut log_transmittance) = (DVec3::ZERO, 0.0f64);
    for piece in pieces(bodies, colors) {
        let own = piece.log_transmittance();
        color -= piece.color() * (own.exp_m1() * log_transmittance.exp());
        log_transmittance += own;
    }
    let first = bodies.iter().filter(|body| body.opacity() > 0.0).map(|body| body.start / stretch);
    // From zero, so that nothing drawn is 0 and not the −0 that −expm1(0) yields.
    let alpha = 0.0 - log_transmittance.exp_m1();
    Composite { color, alpha, depth: first.fold(f64::INFINITY, f64::min) }
}

/// Returns the depth along the viewing axis at which `share` of the light or less is first left; +inf if more is left
/// behind all bodies.
pub fn median(bodies: &[Body], stretch: f64, share: f64) -> f64 {
    let mut transmittance = 1.0f64;
    for piece in pieces(bodies, &colorless(bodies)) {
        let behind = transmittance * piece.log_transmittance().exp();
        if behind <= share {
            return piece.place_of(share / transmittance) / stretch;
        }
        transmittance = behind;
    }
    f64::INFINITY
}

/// Returns the mean depth, ∫ z dA / A; +inf where A is 0.
pub fn mean_depth(bodies: &[Body], stretch: f64) -> f64 {
    let (mut sum, mut log_transmittance) = (0.0, 0.0f64);
    for piece in pieces(bodies, &colorless(bodies)) {
        sum += piece.moment() * log_transmittance.exp();
        log_transmittance += piece.log_transmittance();
    }
    let alpha = -log_transmittance.exp_m1();
    if alpha > 0.0 { sum / alpha / stretch } else { f64::INFINITY }
}

/// A color for each point, of no effect.
fn colorless(bodies: &[Body]) -> Vec<DVec3> {
    vec![DVec3::ZERO; bodies.iter().map(|body| body.index as usize + 1).max().unwrap_or(0)]
}

/// Returns `true` if a picture is made of ellipsoids.
pub fn are_drawn(points: &Points, discs: &Discs) -> bool {
    discs.gaussians.kernel == Kernel::Ellipsoid && (0..points.len()).any(|i| gaussians::gaussian(points, i).is_some())
}

/// Returns the whole image of `abuffer`, with ellipsoids ([`are_drawn`]). `colors` holds a color for each point, shaded
/// and in the space that blending runs in. A count is that of bodies.
pub fn render(view: View, points: &Points, colors: &[DVec3], discs: &Discs) -> ReferencePicture {
    let bodies = bodies(view, points, discs);
    let stretch = |pixel: usize| Ray::new(view, view.place(pixel)).stretch;
    let blended = |(pixel, list): (usize, &Vec<Body>)| (blend(list, colors, stretch(pixel)), list.len() as u32);
    ReferencePicture::of(view.size, bodies.iter().enumerate().map(blended))
}
