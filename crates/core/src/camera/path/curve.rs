//! The motion through all keys of a path.

use glam::DVec3;

use super::cubic::{Spans, hermite};
use super::direction::{Direction, angle};
use super::knot::{Knot, Lens};
use super::{CameraPath, Defaults, Pose, Problem};

/// A smooth motion that passes through every key exactly; docs/camera-paths.md derives it.
///
/// Its parameter is centripetal (Lee 1989; no cusps between keys, Yuksel et al. 2011), and a monotone cubic maps time
/// to the parameter, so that every key is reached at its time. On each piece a point on the line of sight carries the
/// eye. It is the target if the target rests (an orbit: the eye stays at its distance), the eye if the eye rests (a
/// look around), and otherwise a point between them.
#[derive(Debug, Clone)]
pub struct Curve {
    knots: Vec<Knot>,
    /// Times of the knots; a closed path adds the return to the first.
    times: Vec<f64>,
    /// The parameter at these times, and its derivative.
    places: Vec<[f64; 2]>,
    spans: Spans,
    direction: Direction,
    /// Derivative of the eye at each knot.
    eye_rates: Vec<DVec3>,
    /// Rate of change of the distance to the target.
    reach_rates: Vec<f64>,
    closed: bool,
}

impl Curve {
    /// Returns the motion along a path.
    ///
    /// # Errors
    /// Returns the errors of [`CameraPath::check`], and an error for an `up` along the view, perspective and
    /// orthographic keys in one path.
    pub fn new(path: &CameraPath, defaults: &Defaults) -> Result<Self, Problem> {
        path.check()?;
        let knots = path.keys.iter().enumerate().map(|(number, key)| Knot::new(number, key, defaults));
        let knots = knots.collect::<Result<Vec<_>, _>>()?;
        if let Some(number) = knots.iter().position(|knot| knot.lens.orthographic != knots[0].lens.orthographic) {
            return Err(Problem::of_key(number, "", "is orthographic, but others are not; a path can't mix them"));
        }
        // A single key has nothing to return from.
        let closed = path.closed && knots.len() > 1;
        let times = times(path, closed);
        let spans = Spans::new(lengths(&knots, closed), closed);
        let direction = Direction::new(&knots, &spans);
        let places = places(&times, &spans, closed);
        let mut curve =
            Self { knots, times, places, spans, direction, eye_rates: Vec::new(), reach_rates: Vec::new(), closed };
        let count = curve.knots.len();
        curve.reach_rates = (0..count).map(|knot| curve.monotone_rate(knot, |knot| knot.reach)).collect();
        curve.eye_rates = (0..count).map(|knot| curve.eye_rate(knot)).collect();
        Ok(curve)
    }

    /// Returns the number of keys.
    pub fn keys(&self) -> usize {
        self.knots.len()
    }

    /// Returns the times of the first and the last key; of a closed path of the return to the first.
    pub fn time_range(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// Returns the keys themselves.
    pub fn key_poses(&self) -> Vec<Pose> {
        (0..self.knots.len()).map(|knot| self.at_knot(knot)).collect()
    }

    /// Returns poses of equally spaced times: of an open path from the first key to the last one (only the first if
    /// `count` is 1), of a closed one from the first key to a step before it.
    pub fn frames(&self, count: usize) -> Vec<Pose> {
        let [start, end] = self.time_range();
        let steps = if self.closed { count } else { count.saturating_sub(1) }.max(1);
        (0..count).map(|i| self.at(start + (end - start) * (i as f64 / steps as f64))).collect()
    }

    /// Returns the pose at a time; times beyond the path's ends count as these.
    pub fn at(&self, time: f64) -> Pose {
        let last = self.times.len() - 1;
        let after = self.times.partition_point(|t| *t <= time);
        // A key is met exactly, without the rounding of what leads there.
        match after.checked_sub(1) {
            None => return self.at_knot(0),
            Some(knot) if knot == last || self.times[knot] == time => return self.at_knot(knot % self.knots.len()),
            Some(_) => {}
        }
        let span = after - 1;
        let ([a, a_rate], [b, b_rate]) = (self.places[span], self.places[span + 1]);
        let length = self.times[span + 1] - self.times[span];
        let place = hermite([a, b], [a_rate, b_rate], length, (time - self.times[span]) / length);
        if b > a { self.between(span, ((place - a) / (b - a)).clamp(0.0, 1.0)) } else { self.at_knot(span) }
    }

    fn at_knot(&self, knot: usize) -> Pose {
        let Knot { eye, axes: [right, up, forward], projection, near, far, stated, .. } = self.knots[knot];
        Pose { eye, right, up, forward, projection, near, far, stated }
    }

    /// The pose on a piece that has some length, at `s` in [0, 1].
    fn between(&self, span: usize, s: f64) -> Pose {
        let ends = self.ends(span);
        let length = self.spans.length(span);
        let [right, up, forward] = self.direction.axes(span, ends, length, s);
        let share = self.share([span]);
        let pivots = ends.map(|knot| self.pivot(knot, share));
        let rates = ends.map(|knot| self.eye_rates[knot] + self.arm_rate(knot) * share);
        let reach =
            hermite(ends.map(|knot| self.knots[knot].reach), ends.map(|knot| self.reach_rates[knot]), length, s);
        let eye = hermite(pivots, rates, length, s) - forward * (share * reach);
        let [lens, near, far] = [
            self.monotone(ends, length, s, |knot| knot.lens.log),
            self.monotone(ends, length, s, |knot| knot.near.unwrap_or(0.0)),
            self.monotone(ends, length, s, |knot| knot.far.unwrap_or(0.0)),
        ];
        let knot = &self.knots[ends[0]];
        let projection = Lens { log: lens, ..knot.lens }.projection();
        let [near, far] = [knot.near.map(|_| near), knot.far.map(|_| far)];
        Pose { eye, right, up, forward, projection, near, far, stated: None }
    }

    fn ends(&self, span: usize) -> [usize; 2] {
        [span, (span + 1) % self.knots.len()]
    }

    /// The point on a key's line of sight at this share of the distance from the eye to the target.
    fn pivot(&self, knot: usize, share: f64) -> DVec3 {
        let knot = &self.knots[knot];
        knot.eye + knot.forward() * (share * knot.reach)
    }

    /// Returns how far toward the target the point lies that moves least on these pieces: |Δeye| / (|Δeye| +
    /// |Δtarget|).
    fn share(&self, spans: impl IntoIterator<Item = usize>) -> f64 {
        let moved = |share: f64, span: usize| {
            let [a, b] = self.ends(span).map(|knot| self.pivot(knot, share));
            (b - a).length()
        };
        let (mut eye, mut target) = (0.0, 0.0);
        for span in spans {
            eye += moved(0.0, span);
            // Movements as small as rounding errors count as rest.
            let scale = self.ends(span).map(|knot| self.knots[knot].eye.length() + self.knots[knot].reach);
            target += Some(moved(1.0, span)).filter(|moved| *moved > 1e-13 * (scale[0] + scale[1])).unwrap_or(0.0);
        }
        if eye > 0.0 { eye / (eye + target) } else { 0.0 }
    }

    /// Derivative of the arm from eye to target at a knot.
    fn arm_rate(&self, knot: usize) -> DVec3 {
        let (at, forward) = (&self.knots[knot], self.knots[knot].forward());
        forward * self.reach_rates[knot] + self.direction.forward_rate(knot, forward) * at.reach
    }

    /// Derivative of the eye at a knot that makes the carrying point there a Catmull-Rom spline.
    fn eye_rate(&self, knot: usize) -> DVec3 {
        let share = self.share(self.spans.around(knot).into_iter().flatten());
        let moved = |span: usize| {
            let [a, b] = self.ends(span);
            self.pivot(b, share) - self.pivot(a, share)
        };
        match self.spans.slope(knot, &moved) {
            Some(rate) => rate - self.arm_rate(knot) * share,
            None => DVec3::ZERO,
        }
    }

    fn monotone_rate(&self, knot: usize, value: fn(&Knot) -> f64) -> f64 {
        let difference = |span: usize| {
            let [a, b] = self.ends(span).map(|knot| value(&self.knots[knot]));
            b - a
        };
        self.spans.monotone_slope(knot, &difference)
    }

    fn monotone(&self, ends: [usize; 2], length: f64, s: f64, value: fn(&Knot) -> f64) -> f64 {
        let rates = ends.map(|knot| self.monotone_rate(knot, value));
        hermite(ends.map(|knot| value(&self.knots[knot])), rates, length, s)
    }
}

/// Times of the keys; a closed path takes from the last to the first as long as between two others on average.
fn times(path: &CameraPath, closed: bool) -> Vec<f64> {
    let given = path.keys.iter().enumerate().map(|(i, key)| key.time.unwrap_or(i as f64));
    let mut times: Vec<f64> = given.collect();
    if closed {
        let (first, last) = (times[0], times[times.len() - 1]);
        times.push(last + (last - first) / (times.len() - 1) as f64);
    }
    times
}

/// Centripetal lengths of the pieces: the root of how far the camera moves, turns and zooms. Angles count as the path
/// of an eye that orbits at the mean distance of the targets, or, without targets, at the mean distance between two
/// keys.
fn lengths(knots: &[Knot], closed: bool) -> Vec<f64> {
    let pieces = if closed { knots.len() } else { knots.len() - 1 };
    let pair = |i: usize| (&knots[i], &knots[(i + 1) % knots.len()]);
    let way = |i: usize| (pair(i).1.eye - pair(i).0.eye).length();
    let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
    let reach = mean(knots.iter().map(|knot| knot.reach).sum(), knots.len());
    let arm = [reach, mean((0..pieces).map(way).sum(), pieces), 1.0].into_iter().find(|x| *x > 0.0).unwrap_or(1.0);
    let length = |i: usize| {
        let (a, b) = pair(i);
        let turned = angle(b.turn * a.turn.conjugate());
        // Turns as small as rounding errors count as rest.
        let turned = if turned < 1e-14 { 0.0 } else { turned };
        // Depth limits are hardly visible; including them only prevents jumps where nothing else changes.
        let depths = |knot: &Knot| [knot.near, knot.far].map(|depth| depth.unwrap_or(1.0).ln());
        let ([a_near, a_far], [b_near, b_far]) = (depths(a), depths(b));
        let cut = 1e-6 * ((b_near - a_near).abs() + (b_far - a_far).abs());
        (way(i) + arm * (turned + (b.lens.log - a.lens.log).abs() + cut)).sqrt()
    };
    (0..pieces).map(length).collect()
}

/// The parameter at each time and its derivative.
fn places(times: &[f64], spans: &Spans, closed: bool) -> Vec<[f64; 2]> {
    let waits = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let time = Spans::new(waits, closed);
    let mut place = 0.0;
    let mut places = vec![0.0];
    for span in 0..spans.count() {
        place += spans.length(span);
        places.push(place);
    }
    let rate = |knot: usize| time.monotone_slope(knot, &|span| spans.length(span));
    places.iter().enumerate().map(|(knot, place)| [*place, rate(knot)]).collect()
}
