//! A pixel's ray through spheres: spans of constant density, and their effect on the light.

use glam::DVec3;

use super::density::{antiderivative, density_factor};
use super::ray::{Chord, Ray};
use super::{Behind, Model, Pixel, Sphere};
use pellucid_scene::SoftLayout;

/// A piece of a ray inside one sphere, or one shell of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// s where it begins, not before the near plane.
    pub start: f64,
    /// s where it ends, not behind the solid; more than `start`.
    pub end: f64,
    /// 1 − d/r: the weight of its color.
    pub weight: f64,
    /// Color of the span.
    pub color: DVec3,
    /// The medium that absorbs its light.
    pub medium: Medium,
}

/// A density along a span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Medium {
    /// λ·(r − √((s − s_m)² + d²)), Eq. 5.
    Falling {
        /// λ, modulated.
        lambda: f64,
        /// r.
        radius: f64,
        /// d.
        distance: f64,
        /// s_m.
        middle: f64,
    },
    /// Constant density: λμ (Eq. 13), or λμ′ (Eq. 15).
    Constant(f64),
}

impl Span {
    /// Returns the optical depth from s₀ to s₁, both within the span.
    pub fn depth(&self, s0: f64, s1: f64) -> f64 {
        match self.medium {
            Medium::Falling { lambda, radius, distance, middle } => {
                // No density is negative: where d was rounded up, its chord is shorter than the span.
                let half = ((radius - distance) * (radius + distance)).sqrt();
                let from_middle = |s: f64| antiderivative(radius, distance, (s - middle).clamp(-half, half));
                // Rounding must not make light.
                lambda * (from_middle(s1) - from_middle(s0)).max(0.0)
            }
            Medium::Constant(density) => density * (s1 - s0),
        }
    }
}

/// The part of a ray that is looked at: from the near plane to the solid behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// s of the near plane.
    pub near: f64,
    /// s of the solid, +inf without one.
    pub solid: f64,
}

impl Limits {
    fn cut(&self, chord: &Chord) -> Option<(f64, f64)> {
        let (start, end) = (chord.middle - chord.half, chord.middle + chord.half);
        let (start, end) = (start.max(self.near), end.min(self.solid));
        (start < end).then_some((start, end))
    }
}

/// Appends the part of a sphere within the limits. Returns true if any part is.
pub fn append(spans: &mut Vec<Span>, model: &Model, sphere: &Sphere, ray: &Ray, limits: &Limits) -> bool {
    let Some(chord) = ray.meet(sphere.center, sphere.radius) else { return false };
    if limits.cut(&chord).is_none() {
        return false;
    }
    match sphere.shells {
        None => spans.extend(whole(model, sphere, &chord, limits)),
        Some(shells) => spans.extend(concentric(model, sphere, shells, &chord, ray, limits)),
    }
    true
}

/// `soft-base`: one span.
fn whole(model: &Model, sphere: &Sphere, chord: &Chord, limits: &Limits) -> Option<Span> {
    let (start, end) = limits.cut(chord)?;
    let (radius, distance) = (sphere.radius, chord.distance);
    let optical_depth = model.strength.lambda * 2.0 * antiderivative(radius, distance, chord.half);
    let rho = distance / radius;
    let factor = density_factor(optical_depth, rho, sphere.modulation, model.strength.peak);
    let lambda = model.strength.lambda * factor;
    // The stored precision of d and the color; ends and middle are those of the sphere itself.
    let (rho, color) = match model.soft.layout {
        SoftLayout::Precise => (rho, sphere.color),
        SoftLayout::Paper => (in_8_bits(rho), sphere.color.map(in_8_bits)),
    };
    let medium = Medium::Falling { lambda, radius, distance: rho * radius, middle: chord.middle };
    Some(Span { start, end, weight: 1.0 - rho, color, medium })
}

/// Returns the nearest multiple of 1/255.
pub fn in_8_bits(value: f64) -> f64 {
    (value.clamp(0.0, 1.0) * 255.0).round() / 255.0
}

/// `soft-concentric`: one span for each shell that the ray meets. Densities of shells add up.
fn concentric(model: &Model, sphere: &Sphere, shells: u32, chord: &Chord, ray: &Ray, limits: &Limits) -> Vec<Span> {
    let n = f64::from(shells);
    // Eq. 13: chord, weight and μ of each shell; or μ′, Eq. 15.
    let met: Vec<(Chord, f64, f64)> = (0..shells)
        .map_while(|i| {
            let radius = sphere.radius - f64::from(i) * sphere.radius / n;
            let chord = ray.meet(sphere.center, radius)?;
            let weight = 1.0 - chord.distance / radius;
            let mu = sphere.radius / (n * radius);
            Some((chord, weight, if model.soft.equalize { mu * weight } else { mu }))
        })
        .collect();
    let optical_depth: f64 = met.iter().map(|(chord, _, mu)| model.strength.lambda * mu * 2.0 * chord.half).sum();
    let rho = chord.distance / sphere.radius;
    let factor = density_factor(optical_depth, rho, sphere.modulation, model.strength.peak);
    let span = |(chord, weight, mu): &(Chord, f64, f64)| {
        let (start, end) = limits.cut(chord)?;
        let medium = Medium::Constant(model.strength.lambda * factor * mu);
        Some(Span { start, end, weight: *weight, color: sphere.color, medium })
    };
    met.iter().filter_map(span).collect()
}

/// Composes the segments between successive ends of spans (Section 3.1), before what is behind. `stretch` is s over z,
/// `count` how many spheres these are.
pub fn blend(mut spans: Vec<Span>, stretch: f64, count: u32, behind: &Behind) -> Pixel {
    spans.sort_by(|a, b| a.start.total_cmp(&b.start));
    let mut events: Vec<f64> = spans.iter().flat_map(|span| [span.start, span.end]).collect();
    events.sort_by(f64::total_cmp);
    events.dedup();

    let mut to_come = spans.iter().peekable();
    let mut open: Vec<&Span> = Vec::new();
    let mut optical_depth = 0.0f64;
    let mut color = DVec3::ZERO;
    for segment in events.windows(2) {
        let [s0, s1] = [segment[0], segment[1]];
        open.retain(|span| span.end > s0);
        while let Some(span) = to_come.next_if(|span| span.start <= s0) {
            open.push(span);
        }
        let weights: f64 = open.iter().map(|span| span.weight).sum();
        if open.is_empty() || weights == 0.0 {
            continue;
        }
        let segment_depth: f64 = open.iter().map(|span| span.depth(s0, s1)).sum();
        // Eq. 11.
        let mean = open.iter().map(|span| span.weight * span.color).sum::<DVec3>() / weights;
        color += mean * ((-optical_depth).exp() * -(-segment_depth).exp_m1());
        optical_depth += segment_depth;
    }
    let first = spans.iter().find(|span| span.depth(span.start, span.end) > 0.0).map(|span| span.start / stretch);
    Pixel::before(color, -optical_depth, first, count, behind)
}
