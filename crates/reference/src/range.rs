//! Numbers that roundings of float32 may decide, as the range in which each of them lies.
//!
//! A decision such as "is this point nearer than that one" has two outcomes where its two sides are nearer to each
//! other than roundings move them. The references that return ranges then keep both. So a range is a single number
//! wherever no rounding decides, and a device that computes otherwise falls out of it.

use std::ops::Add;

use super::ReferencePicture;

/// The largest relative error of one rounding to float32: half a unit in the last place of a number just above 1.
pub const ROUNDING: f64 = 1.0 / 16_777_216.0;

/// The error of a depth in float32, over the depth: one rounding. The two-float arithmetic before it (48 bits) and
/// everything of second order leave less than another.
pub const DEPTH_ERROR: f64 = 2.0 * ROUNDING;

/// The error of a place on the screen in two-float arithmetic, in pixels, over one more than its distance from the
/// middle: 48 bits, less a few for some ten operations.
const SCREEN_ERROR: f64 = 1.0 / (1u64 << 42) as f64;

/// Returns the error of a place on the screen in two-float arithmetic, in pixels; `at` in pixels from the corner of an
/// image of `side` pixels. Pixel borders are decided that finely.
pub fn screen_error(at: f64, side: u32) -> f64 {
    SCREEN_ERROR * (1.0 + f64::from(side) + at.abs())
}

/// All numbers from `low` to `high`, both included; infinite ones are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The smallest of them.
    pub low: f64,
    /// The largest of them.
    pub high: f64,
}

impl Range {
    /// Returns a single number.
    pub const fn only(value: f64) -> Self {
        Self { low: value, high: value }
    }

    /// Returns the numbers that differ from one by at most an error.
    pub fn around(value: f64, error: f64) -> Self {
        Self { low: value - error, high: value + error }
    }

    /// Returns a depth as float32 has it.
    pub fn depth(z: f64) -> Self {
        Self::around(z, DEPTH_ERROR * z.abs())
    }

    /// Returns the range from the smallest to the largest of some numbers.
    pub fn spanning(numbers: [f64; 4]) -> Self {
        let low = numbers.into_iter().fold(f64::INFINITY, f64::min);
        Self { low, high: numbers.into_iter().fold(f64::NEG_INFINITY, f64::max) }
    }

    /// Returns the range from the smaller low to the larger high end.
    pub fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Returns the smaller of two numbers.
    pub fn least(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.min(other.high) }
    }

    /// Farther apart by an error on both sides.
    pub fn widened(self, error: f64) -> Self {
        Self { low: self.low - error, high: self.high + error }
    }

    /// Returns the product with a number that is not negative.
    pub fn scaled(self, factor: f64) -> Self {
        Self { low: factor * self.low, high: factor * self.high }
    }

    /// Returns the product of numbers that are not negative.
    pub fn times(self, other: Self) -> Self {
        Self { low: self.low * other.low, high: self.high * other.high }
    }

    /// 1 less the number.
    pub fn complement(self) -> Self {
        Self { low: 1.0 - self.high, high: 1.0 - self.low }
    }

    /// Returns `true` if a number is in the range, or off it by at most `slack`. NaN is in none.
    pub fn covers(self, value: f64, slack: f64) -> bool {
        value >= self.low - slack && value <= self.high + slack
    }

    /// Returns `true` if all numbers are finite.
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
}

impl Add for Range {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }
}

/// The numbers that a color and its alpha may be.
pub type ColorRange = [Range; 4];

/// No color and no alpha: background.
pub const NOTHING: ColorRange = [Range::only(0.0); 4];

/// Returns the hull of each component.
pub fn hull(a: ColorRange, b: ColorRange) -> ColorRange {
    std::array::from_fn(|c| a[c].hull(b[c]))
}

/// An image whose decisions roundings make: the counterpart of [`super::ReferencePicture`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PictureRange {
    /// Width in pixels.
    pub width: u32,
    /// Premultiplied R, G, B and A.
    pub rgba: Vec<ColorRange>,
    /// Depth, +inf where nothing is.
    pub depth: Vec<Range>,
    /// The number that [`super::ReferencePicture::counts`] counts for the method.
    pub counts: Vec<Range>,
}

impl PictureRange {
    /// Returns a picture of which roundings decide nothing: its depths are off by at most this share of themselves.
    pub fn of_picture(picture: &ReferencePicture, depth_error: f64) -> Self {
        let depth = |z: &f64| if z.is_finite() { Range::around(*z, depth_error * z.abs()) } else { Range::only(*z) };
        Self {
            width: picture.width,
            rgba: picture.rgba.iter().map(|rgba| rgba.map(Range::only)).collect(),
            depth: picture.depth.iter().map(depth).collect(),
            counts: picture.counts.iter().map(|count| Range::only(f64::from(*count))).collect(),
        }
    }

    /// Appends a pixel.
    pub fn push(&mut self, rgba: ColorRange, depth: Range, count: Range) {
        self.rgba.push(rgba);
        self.depth.push(depth);
        self.counts.push(count);
    }
}
