//! Scales that map values to places in a color map.

use super::percentiles::percentiles;

/// The shares of values below and above which colors stay the same.
const ENDS: [f64; 2] = [0.01, 0.99];

/// The values that get the first and the last color, and how those between them are spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    /// The ends, or their logarithms.
    scaled: [f64; 2],
    /// `true` if logarithms are spread evenly rather than values.
    pub log: bool,
}

impl Scale {
    /// Makes the scale from `low` to `high`; above 0 with `log`.
    pub fn between([low, high]: [f64; 2], log: bool) -> Self {
        let scaled = [low, high].map(|value| if log { value.ln() } else { value });
        Self { low, high, scaled, log }
    }

    /// Makes a scale with a range of the values' own where none is given: their percentiles 1 and 99.
    pub fn of(values: &[f64], range: Option<[f64; 2]>, log: bool) -> Self {
        let own = || {
            let counted = values.iter().copied().filter(|value| !log || *value > 0.0);
            percentiles(counted.collect(), ENDS).unwrap_or([if log { 1.0 } else { 0.0 }; 2])
        };
        Self::between(range.unwrap_or_else(own), log)
    }

    /// Returns the values at the two ends.
    pub fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// t from 0 to 1; `None` for values that are not finite, and with a logarithm for those up to 0.
    pub fn place(&self, value: f64) -> Option<f64> {
        // Of values up to 0 the logarithm is infinite or none.
        let value = if self.log { value.ln() } else { value };
        let [low, high] = self.scaled;
        if !value.is_finite() {
            None
        } else if value <= low {
            Some(0.0)
        } else if value >= high {
            Some(1.0)
        } else if high - low <= f64::MAX {
            Some(((value - low) / (high - low)).clamp(0.0, 1.0))
        } else {
            // Halved, as the difference of the largest float64 values overflows.
            Some(((0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low)).clamp(0.0, 1.0))
        }
    }
}
