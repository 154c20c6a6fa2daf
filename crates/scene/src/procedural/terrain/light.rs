//! Light baked into the colors, in encoded values: a sun, and a sky that is brighter overhead.

use glam::DVec3;

use super::super::builder::Rgb;

/// An sRGB-encoded color, 0 to 255.
pub(super) type Tone = DVec3;

/// Meters along the ground, in x and y, over which a shadow of something one meter high reaches: away from the sun.
pub(super) const TO_SUN: [f64; 2] = [-0.85, -0.62];

/// Direction toward the sun.
pub(super) fn sun() -> DVec3 {
    DVec3::new(TO_SUN[0], TO_SUN[1], 1.0).normalize()
}

/// Returns the factor on an encoded color whose surface has this normal; `lit` is the share of the sun that reaches it.
pub(super) fn shade(normal: DVec3, sun: DVec3, lit: f64) -> f64 {
    let direct = 0.95 * normal.dot(sun).max(0.0) * lit;
    let sky = 0.34 + 0.12 * normal.z;
    // The encoding is nearly a square root.
    (direct + sky).sqrt()
}

/// Returns the bytes of a color.
pub(super) fn bytes(tone: Tone) -> Rgb {
    tone.clamp(DVec3::ZERO, DVec3::splat(255.0)).to_array().map(|value| value.round() as u8)
}
