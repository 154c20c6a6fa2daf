//! The camera's axes between knots.

use glam::{DMat3, DQuat, DVec3};

use super::cubic::{Spans, hermite};
use super::knot::Knot;

/// Axes as a function of the curve's parameter.
#[derive(Debug, Clone)]
pub enum Direction {
    /// All keys have a target and the same `up`: azimuth around it and elevation above its horizon, which stays level.
    Level {
        /// Two horizontal axes and `up`.
        base: DMat3,
        /// Azimuth, not wrapped, at both ends of each piece; elevation.
        turns: Vec<[f64; 2]>,
        elevations: Vec<f64>,
        /// Derivatives of azimuth and elevation at each knot.
        rates: Vec<[f64; 2]>,
    },
    /// Any orientations: cubic curves of quaternions (Kim, Kim and Shin 1995, Eq. 14).
    Free {
        turns: Vec<DQuat>,
        /// Angular velocity at each knot in world axes.
        rates: Vec<DVec3>,
    },
}

impl Direction {
    pub fn new(knots: &[Knot], spans: &Spans) -> Self {
        match common_up(knots) {
            Some(up) => Self::level(knots, spans, up),
            None => Self::free(knots, spans),
        }
    }

    fn level(knots: &[Knot], spans: &Spans, up: DVec3) -> Self {
        let (x, y) = up.any_orthonormal_pair();
        // Right-handed, so that azimuths ascend counter-clockwise seen from above.
        let base = if x.cross(y).dot(up) > 0.0 { DMat3::from_cols(x, y, up) } else { DMat3::from_cols(y, x, up) };
        let local = |knot: &Knot| base.transpose() * knot.forward();
        let azimuths: Vec<f64> = knots.iter().map(local).map(|f| f.y.atan2(f.x)).collect();
        let elevations: Vec<f64> = knots.iter().map(local).map(|f| f.z.atan2(f.x.hypot(f.y))).collect();
        let count = knots.len();
        let turn = |span: usize| wrapped(azimuths[(span + 1) % count] - azimuths[span]);
        let rise = |span: usize| elevations[(span + 1) % count] - elevations[span];
        let rate = |knot| [spans.slope(knot, &turn).unwrap_or(0.0), spans.monotone_slope(knot, &rise)];
        let turns = (0..spans.count()).map(|span| [azimuths[span], azimuths[span] + turn(span)]).collect();
        let rates = (0..count).map(rate).collect();
        Self::Level { base, turns, elevations, rates }
    }

    fn free(knots: &[Knot], spans: &Spans) -> Self {
        let turns: Vec<DQuat> = knots.iter().map(|knot| knot.turn).collect();
        let turn = |span: usize| log(turns[(span + 1) % turns.len()] * turns[span].conjugate());
        let rates = (0..knots.len()).map(|knot| spans.slope(knot, &turn).unwrap_or(DVec3::ZERO)).collect();
        Self::Free { turns, rates }
    }

    /// Right, up and forward on a piece of this length between knots `a` and `b`, at `s` in [0, 1].
    pub fn axes(&self, span: usize, [a, b]: [usize; 2], length: f64, s: f64) -> [DVec3; 3] {
        match self {
            Self::Level { base, turns, elevations, rates } => {
                let azimuth = hermite(turns[span], [rates[a][0], rates[b][0]], length, s);
                let elevation = hermite([elevations[a], elevations[b]], [rates[a][1], rates[b][1]], length, s);
                let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth.sin_cos(), elevation.sin_cos());
                let right = DVec3::new(sin_a, -cos_a, 0.0);
                let up = DVec3::new(-sin_e * cos_a, -sin_e * sin_a, cos_e);
                let forward = DVec3::new(cos_e * cos_a, cos_e * sin_a, sin_e);
                [right, up, forward].map(|axis| *base * axis)
            }
            Self::Free { turns, rates } => {
                let turn = turned([turns[a], turns[b]], [rates[a], rates[b]].map(|rate| rate * length), s);
                [DVec3::X, DVec3::Y, DVec3::NEG_Z].map(|axis| turn * axis)
            }
        }
    }

    /// Derivative of the viewing direction at a knot; `forward` is the direction.
    pub fn forward_rate(&self, knot: usize, forward: DVec3) -> DVec3 {
        match self {
            Self::Level { base, rates, .. } => {
                let [turn, rise] = rates[knot];
                let up = base.z_axis;
                let level = forward - up * forward.dot(up);
                let top = up * level.length() - level.normalize_or_zero() * forward.dot(up);
                up.cross(forward) * turn + top * rise
            }
            Self::Free { rates, .. } => rates[knot].cross(forward),
        }
    }
}

/// The `up` of all keys, if they have one.
fn common_up(knots: &[Knot]) -> Option<DVec3> {
    let first = knots.first()?.up?;
    knots.iter().all(|knot| knot.up.is_some_and(|up| (up - first).length() < 1e-9)).then_some(first)
}

/// The cubic of quaternions from `q` to `r` with these angular velocities at its ends, over a piece of length 1.
///
/// Cumulative Bernstein polynomials 1 − (1 − s)³, 3s² − 2s³ and s³ weight three rotations. The first and the last have
/// a third of the velocities, like the legs of a Bézier curve, and the second is the remaining rotation from q to r.
/// Turns around one axis commute and add up: the angle is then the Hermite cubic, and with equal velocities it is
/// linear.
fn turned([q, r]: [DQuat; 2], [start, end]: [DVec3; 2], s: f64) -> DQuat {
    let (first, last) = (start / 3.0, end / 3.0);
    let middle = log(exp(-last) * r * q.conjugate() * exp(-first));
    let t = 1.0 - s;
    let [a, b, c] = [1.0 - t * t * t, s * s * (3.0 - 2.0 * s), s * s * s];
    (exp(last * c) * exp(middle * b) * exp(first * a) * q).normalize()
}

/// The rotation by the vector's length around it.
fn exp(rotation: DVec3) -> DQuat {
    DQuat::from_scaled_axis(rotation)
}

/// The rotation vector of the shorter way, of length at most π.
fn log(turn: DQuat) -> DVec3 {
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let axis = DVec3::new(turn.x, turn.y, turn.z);
    let sine = axis.length();
    // For a small angle the sine is half of it, so the quotient tends to 2.
    let factor = if sine > 1e-300 { 2.0 * sine.atan2(turn.w) / sine } else { 2.0 };
    axis * factor
}

/// Returns the angle of a unit quaternion's rotation, in [0, π].
pub fn angle(turn: DQuat) -> f64 {
    log(turn).length()
}

/// Returns the same angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let turn = angle.rem_euclid(TAU);
    if turn > PI { turn - TAU } else { turn }
}
