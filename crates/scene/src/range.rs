//! Ranges of numbers.

/// The values a number may have. NaN and infinities are outside every range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    min: f64,
    max: f64,
    /// `true` if the lower and the upper end themselves are allowed.
    closed: [bool; 2],
}

/// Coordinates up to here can be squared twice and summed in float64, as a camera needs it.
pub(crate) const MAX_COORDINATE: f64 = 1e75;

impl Range {
    /// Range from 0 to 1, both included.
    pub const UNIT: Self = Self { min: 0.0, max: 1.0, closed: [true; 2] };
    /// Range above 0.
    pub const POSITIVE: Self = Self { min: 0.0, max: f64::INFINITY, closed: [false; 2] };
    /// 0 and above.
    pub const NOT_NEGATIVE: Self = Self { min: 0.0, max: f64::INFINITY, closed: [true; 2] };
    /// Every coordinate that a camera can be computed for.
    pub const COORDINATE: Self = Self { min: -MAX_COORDINATE, max: MAX_COORDINATE, closed: [true; 2] };

    /// Every number.
    pub const ANY: Self = Self { min: f64::NEG_INFINITY, max: f64::INFINITY, closed: [true; 2] };

    /// Makes the range between two numbers, both excluded.
    pub const fn open(min: f64, max: f64) -> Self {
        Self { min, max, closed: [false; 2] }
    }

    /// Makes the range between two numbers, both included.
    pub const fn closed(min: f64, max: f64) -> Self {
        Self { min, max, closed: [true; 2] }
    }

    /// Makes the range from one number to another, which is excluded.
    pub const fn below(min: f64, max: f64) -> Self {
        Self { min, max, closed: [true, false] }
    }

    /// Returns `true` if a number lies within.
    pub fn contains(self, x: f64) -> bool {
        let [from, to] = self.closed;
        x.is_finite() && (self.min < x || (from && x == self.min)) && (x < self.max || (to && x == self.max))
    }

    /// Returns a phrase that follows "must be a number".
    pub fn describe(self) -> String {
        let Self { min, max, closed } = self;
        match (min.is_finite(), max.is_finite(), closed) {
            (false, false, _) => String::new(),
            (true, false, [true, _]) => format!(" of at least {min}"),
            (true, false, [false, _]) => format!(" above {min}"),
            (_, _, [true, true]) => format!(" from {min:?} to {max:?}"),
            (_, _, [true, false]) => format!(" of at least {min} and below {max}"),
            (_, _, [false, _]) => format!(" between {min} and {max}, both excluded"),
        }
    }
}
