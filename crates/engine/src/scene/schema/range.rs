//! Ranges of numbers.

/// The values a number may have. NaN and infinities are outside every range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    min: f64,
    max: f64,
    /// True if the ends themselves are allowed.
    closed: bool,
}

/// Coordinates up to here can be squared twice and summed in float64, as a camera needs it.
pub(crate) const MAX_COORDINATE: f64 = 1e75;

impl Range {
    /// From 0 to 1.
    pub const UNIT: Self = Self { min: 0.0, max: 1.0, closed: true };
    /// Above 0.
    pub const POSITIVE: Self = Self { min: 0.0, max: f64::INFINITY, closed: false };
    /// 0 and above.
    pub const NOT_NEGATIVE: Self = Self { min: 0.0, max: f64::INFINITY, closed: true };
    /// Every coordinate that a camera can be computed for.
    pub const COORDINATE: Self = Self { min: -MAX_COORDINATE, max: MAX_COORDINATE, closed: true };

    /// Every number.
    pub const ANY: Self = Self { min: f64::NEG_INFINITY, max: f64::INFINITY, closed: true };

    /// Between two numbers, both excluded.
    pub const fn open(min: f64, max: f64) -> Self {
        Self { min, max, closed: false }
    }

    /// Between two numbers, both included.
    pub const fn closed(min: f64, max: f64) -> Self {
        Self { min, max, closed: true }
    }

    /// True if a number lies within.
    pub fn contains(self, x: f64) -> bool {
        x.is_finite() && if self.closed { self.min <= x && x <= self.max } else { self.min < x && x < self.max }
    }

    /// A phrase that follows "must be a number".
    pub fn describe(self) -> String {
        let Self { min, max, closed } = self;
        match (min.is_finite(), max.is_finite(), closed) {
            (false, false, _) => String::new(),
            (true, false, true) => format!(" of at least {min}"),
            (true, false, false) => format!(" above {min}"),
            (_, _, true) => format!(" from {min:?} to {max:?}"),
            (_, _, false) => format!(" between {min} and {max}, both excluded"),
        }
    }
}
