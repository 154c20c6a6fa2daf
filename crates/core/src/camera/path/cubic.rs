//! Cubic pieces through values at knots: derivatives at the knots, and the pieces between them.

use std::ops::{Add, Mul, Sub};

/// Types that can be interpolated: numbers and vectors.
pub trait Value: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>> Value for T {}

/// The pieces between knots: their lengths in the curve's parameter, and if the last one leads back to knot 0.
#[derive(Debug, Clone)]
pub struct Spans {
    lengths: Vec<f64>,
    closed: bool,
}

impl Spans {
    /// Lengths are finite and at least 0. A piece of length 0 is a rest: the curve stops there and restarts.
    pub fn new(lengths: Vec<f64>, closed: bool) -> Self {
        Self { lengths, closed }
    }

    /// Returns the number of pieces.
    pub fn count(&self) -> usize {
        self.lengths.len()
    }

    /// Returns the length of a piece.
    pub fn length(&self, span: usize) -> f64 {
        self.lengths[span]
    }

    /// Returns the pieces before and after a knot, where they exist and have a length above 0.
    pub fn around(&self, knot: usize) -> [Option<usize>; 2] {
        let count = self.count();
        let before = match knot {
            0 if self.closed => count.checked_sub(1),
            _ => knot.checked_sub(1),
        };
        let after = if self.closed && knot == count { Some(0) } else { Some(knot) };
        [before, after].map(|span| span.filter(|span| self.lengths.get(*span).is_some_and(|length| *length > 0.0)))
    }

    /// Returns the derivative at a knot, from the differences over the pieces: that of the parabola through the knot
    /// and its two neighbors, which equals that of Catmull and Rom's spline over any parameter (Barry and Goldman
    /// 1988). At an end it is chosen to make the second derivative 0 there, so that two knots make a straight line.
    pub fn slope<T: Value>(&self, knot: usize, difference: &dyn Fn(usize) -> T) -> Option<T> {
        let rate = |span: usize| difference(span) * (1.0 / self.lengths[span]);
        match self.around(knot) {
            [Some(before), Some(after)] => {
                let (a, b) = (self.lengths[before], self.lengths[after]);
                Some(rate(before) * (b / (a + b)) + rate(after) * (a / (a + b)))
            }
            [None, Some(after)] => Some(self.end(after, after + 1, difference)),
            [Some(before), None] => Some(self.end(before, before, difference)),
            [None, None] => None,
        }
    }

    /// The derivative at the free end of a piece; `knot` is its other end.
    fn end<T: Value>(&self, span: usize, knot: usize, difference: &dyn Fn(usize) -> T) -> T {
        let rate = difference(span) * (1.0 / self.lengths[span]);
        match self.around(knot) {
            [Some(_), Some(_)] => match self.slope(knot, difference) {
                Some(inner) => rate * 1.5 - inner * 0.5,
                None => rate,
            },
            _ => rate,
        }
    }

    /// Returns the derivative at a knot that keeps each piece between the values at its ends: the weighted harmonic
    /// mean of the adjacent rates (Fritsch and Butland 1984), 0 at an extreme, and at an end the adjacent rate.
    pub fn monotone_slope(&self, knot: usize, difference: &dyn Fn(usize) -> f64) -> f64 {
        let rate = |span: usize| difference(span) / self.lengths[span];
        match self.around(knot) {
            [Some(before), Some(after)] => {
                let (a, b) = (rate(before), rate(after));
                // Compare signs, since the product of small rates underflows to 0.
                if a == 0.0 || b == 0.0 || (a > 0.0) != (b > 0.0) {
                    return 0.0;
                }
                let (ha, hb) = (self.lengths[before], self.lengths[after]);
                let (wa, wb) = (2.0 * hb + ha, hb + 2.0 * ha);
                (wa + wb) / (wa / a + wb / b)
            }
            [Some(only), None] | [None, Some(only)] => rate(only),
            [None, None] => 0.0,
        }
    }
}

/// Returns the cubic over [0, 1] with these values and derivatives, these over the piece's own length, at `s`.
pub fn hermite<T: Value>([a, b]: [T; 2], slopes: [T; 2], length: f64, s: f64) -> T {
    let (s2, s3) = (s * s, s * s * s);
    let rise = 3.0 * s2 - 2.0 * s3;
    a + (b - a) * rise + slopes[0] * (length * (s3 - 2.0 * s2 + s)) + slopes[1] * (length * (s3 - s2))
}
