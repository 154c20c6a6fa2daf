//! Thin upright things: trunks and lamps.

use glam::DVec3;

use super::super::random::{Random, unit_circle};
use super::light::Tone;

/// A cylinder, with a ball on it if it is a lamp. Lengths in meters.
#[derive(Debug, Clone)]
pub(super) struct Post {
    pub(super) foot: DVec3,
    pub(super) height: f64,
    pub(super) radius: f64,
    pub(super) tone: Tone,
    /// Radius and color of the ball.
    pub(super) head: Option<(f64, Tone)>,
    /// LAS class.
    pub(super) class: u8,
}

impl Post {
    /// Square meters.
    pub(super) fn area(&self) -> f64 {
        let head = self.head.map_or(0.0, |(radius, _)| 2.0 * radius * radius);
        std::f64::consts::TAU * (self.radius * self.height + head)
    }

    /// Returns a position on it with its normal and color.
    pub(super) fn at(&self, random: &mut Random) -> (DVec3, DVec3, Tone) {
        if let Some((radius, tone)) = self.head.filter(|_| random.unit() < 0.4) {
            let out = random.direction();
            return (self.foot + self.height * DVec3::Z + radius * out, out, tone);
        }
        let (cos, sin) = unit_circle(random.unit());
        let out = DVec3::new(cos, sin, 0.0);
        (self.foot + self.radius * out + self.height * random.unit() * DVec3::Z, out, self.tone)
    }
}
