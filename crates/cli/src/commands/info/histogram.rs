//! Histograms of a cloud's values, as numbers and as a line of text.

use pellucid_core::color::percentiles::percentiles;
use serde_json::{Value, json};

/// Bins of a histogram.
const BINS: usize = 16;

/// The shares of values between which a histogram lies: outliers would leave all others in one bin.
const ENDS: [f64; 2] = [0.01, 0.99];

/// Characters for bars, from the lowest to the highest.
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Number of values in equal bins between percentiles 1 and 99; the few values outside are not counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Percentile 1.
    min: f64,
    /// Percentile 99.
    max: f64,
    /// Values in each bin; a border belongs to the bin above it, `max` to the last one.
    counts: [usize; BINS],
}

impl Histogram {
    /// Returns the histogram of the finite values; `None` if there are none.
    pub fn of(values: Vec<f64>) -> Option<Self> {
        let [min, max] = percentiles(values.clone(), ENDS)?;
        let mut counts = [0; BINS];
        for value in values.into_iter().filter(|value| (min..=max).contains(value)) {
            counts[bin(value, min, max)] += 1;
        }
        Some(Self { min, max, counts })
    }

    pub fn json(&self) -> Value {
        json!({ "min": self.min, "max": self.max, "counts": self.counts })
    }

    /// Formats the histogram like `20.1 ▂▄▇█▇▅▃▂▁▁ 38.2`; a bin without values is blank.
    pub fn text(&self) -> String {
        let most = self.counts.into_iter().max().unwrap_or_default();
        let bar = |count: &usize| match (count * BARS.len()).div_ceil(most.max(1)) {
            0 => ' ',
            level => BARS[level.min(BARS.len()) - 1],
        };
        let bars: String = self.counts.iter().map(bar).collect();
        if self.min == self.max {
            return format!("{} (nearly all)", short(self.min));
        }
        format!("{} {bars} {}", short(self.min), short(self.max))
    }
}

/// The bin of a value within the ends.
fn bin(value: f64, min: f64, max: f64) -> usize {
    // Halved, as the difference of the largest float64 values overflows; equal ends give NaN, which becomes bin 0.
    let share = (0.5 * value - 0.5 * min) / (0.5 * max - 0.5 * min);
    ((share * BINS as f64) as usize).min(BINS - 1)
}

/// A number to four significant digits, in full where it has more before the point.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e9).contains(&size) {
        return format!("{value:.3e}");
    }
    // Digits behind the point: as many as the four lack before it.
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_by_hand() {
        // 0 to 1600: percentiles 16 and 1584, so that bins are 98 wide.
        let histogram = Histogram::of((0..=1600).map(f64::from).collect()).unwrap();
        assert_eq!((histogram.min, histogram.max), (16.0, 1584.0));
        assert_eq!(histogram.counts, [98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 98, 99]);
        assert_eq!(Histogram::of(vec![f64::NAN]), None);
        let same = Histogram::of(vec![2.5; 10]).unwrap();
        assert_eq!((same.counts[0], same.text().as_str()), (10, "2.5 (nearly all)"));
    }

    #[test]
    fn bars_follow_the_counts() {
        let mut counts = [0; BINS];
        counts[..5].copy_from_slice(&[1, 2, 8, 16, 9]);
        let histogram = Histogram { min: -1.0, max: 12_345.678, counts };
        assert_eq!(histogram.text(), "-1 ▁▁▄█▅            12346");
    }

    #[test]
    fn numbers_are_short() {
        for (value, wanted) in [
            (0.0, "0"),
            (1.0, "1"),
            (20.25, "20.25"),
            (-0.012_346, "-0.01235"),
            (123_456.7, "123457"),
            (1e-7, "1.000e-7"),
            (0.1, "0.1"),
            (100.0, "100"),
            (6_277_500.4, "6277500"),
        ] {
            assert_eq!(short(value), wanted);
        }
    }
}
