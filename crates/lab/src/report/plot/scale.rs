//! The scale of an axis: its range, its ticks and their labels.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::{Axis, Steps};

/// An axis over some values. Its units are powers of the base; without one they are the values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisScale {
    pub(super) base: f64,
    is_even: bool,
    floor: f64,
    pub(super) range: Range<f64>,
    /// Labeled ticks.
    ticks: Vec<f64>,
    /// Ticks without a label.
    minor: Vec<f64>,
    /// True if values below the floor are drawn at the floor.
    is_floored: bool,
}

impl AxisScale {
    /// Returns a scale from the round number (a power of the base; for base 10 also twice and five times one) below all
    /// values to the one above, and over one power at least.
    pub(super) fn new(axis: Axis, values: impl Iterator<Item = f64>) -> Self {
        let binary = match axis.steps {
            Steps::Even => return Self::even(values),
            steps => steps == Steps::Twos,
        };
        let base: f64 = if binary { 2.0 } else { 10.0 };
        let floor = axis.floor;
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let is_floored = values.iter().any(|v| *v < floor);
        let logs = values.iter().map(|v| v.max(floor).log10() / base.log10());
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (low.min(log), high.max(log)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let powers = (low.floor() as i32 - 1..=high.ceil() as i32 + 2).map(f64::from);
        let times = |digits: &[f64]| -> Vec<f64> {
            powers.clone().flat_map(|p| digits.iter().map(move |d| p + d.log10()).collect::<Vec<_>>()).collect()
        };
        let round = times(if binary { &[1.0] } else { &[1.0, 2.0, 5.0] });
        // Rounding must not cost a whole step.
        let start = round.iter().copied().filter(|v| *v <= low + 1e-9).fold(low - 1.0, f64::max);
        let end =
            round.iter().copied().filter(|v| *v >= (high - 1e-9).max(start + 1.0 - 1e-9)).fold(high + 2.0, f64::min);
        let within = |v: &f64| *v >= start - 1e-9 && *v <= end + 1e-9;
        // Every round number gets a label if they are few, else every second power.
        let whole: Vec<f64> = powers.clone().filter(within).collect();
        let stride = if whole.len() > 9 { 2 } else { 1 };
        let few: Vec<f64> = round.iter().copied().filter(within).collect();
        let ticks = if few.len() <= 9 { few } else { whole.iter().copied().step_by(stride).collect() };
        let digits: Vec<f64> = (1..=9).map(f64::from).collect();
        let minor = times(if binary { &[1.0] } else { &digits }).into_iter().filter(within).collect();
        // The data keep off the frame.
        let margin = 0.03 * (end - start);
        Self { base, is_even: false, floor, range: start - margin..end + margin, ticks, minor, is_floored }
    }

    /// Returns a scale from 0, or the least value, to the greatest, in at most ten round steps.
    fn even(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.filter(|v| v.is_finite()).fold((0f64, 0f64), |(l, h), v| (l.min(v), h.max(v)));
        let span = if high > low { high - low } else { 1.0 };
        let power = 10f64.powf((span / 10.0).log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power).into_iter().find(|step| *step >= span / 10.0);
        let step = step.unwrap_or(10.0 * power);
        let (first, last) = ((low / step).floor() as i64, ((low + span) / step).ceil() as i64);
        let ticks: Vec<f64> = (first..=last).map(|tick| tick as f64 * step).collect();
        let (start, end) = (first as f64 * step, last as f64 * step);
        let margin = 0.03 * (end - start);
        let (range, minor) = (start - margin..end + margin, ticks.clone());
        Self { base: 10.0, is_even: true, floor: 0.0, range, ticks, minor, is_floored: false }
    }

    pub(super) fn position(&self, value: f64) -> f64 {
        if self.is_even {
            return value;
        }
        let lowest = if self.floor > 0.0 { self.floor } else { f64::MIN_POSITIVE };
        value.max(lowest).log10() / self.base.log10()
    }

    fn label(&self, at: f64) -> String {
        let number = self.number(at);
        if self.is_floored && (at - self.position(self.floor)).abs() < 1e-9 { format!("≤ {number}") } else { number }
    }

    fn number(&self, at: f64) -> String {
        if self.is_even {
            // Round to nine digits, which removes the rounding errors of the steps.
            return format!("{}", (at * 1e9).round() / 1e9);
        }
        let value = self.base.powf(at);
        if (1e-3..1e6).contains(&value) {
            // Round to three digits, which removes the rounding errors of the logarithm.
            let digits = (2 - value.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.digits$}");
            return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
        }
        let exponent = (at * self.base.log10() + 1e-9).floor();
        let mantissa = (value / 10f64.powf(exponent)).round();
        let power = format!("10{}", superscript(exponent as i32));
        if mantissa == 1.0 { power } else { format!("{mantissa}·{power}") }
    }
}

impl Ranged for AxisScale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        from + (share * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.minor.clone() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for AxisScale {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

fn superscript(number: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The others follow one another in Unicode.
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    number.to_string().chars().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{TEN, TWO};
    use super::*;

    fn labels(axis: Axis, values: &[f64]) -> Vec<String> {
        let scale = AxisScale::new(axis, values.iter().copied());
        scale.ticks.iter().map(|tick| scale.label(*tick)).collect()
    }

    #[test]
    fn axes_reach_around_their_values_in_whole_powers() {
        assert_eq!(labels(TEN, &[0.02, 70_000.0, 3.0]), ["0.1", "1", "10", "100", "1000", "10000", "100000"]);
        assert_eq!(labels(TWO, &[1.0, 64.0]), ["1", "2", "4", "8", "16", "32", "64"]);
        assert_eq!(labels(TWO, &[1.0, 4096.0]), ["1", "4", "16", "64", "256", "1024", "4096"]);
        assert_eq!(labels(TEN, &[8.0, 143.0]), ["5", "10", "20", "50", "100", "200"]);
        assert_eq!(labels(TEN, &[3.0]), ["2", "5", "10", "20"]);
        assert_eq!(labels(TEN, &[]), ["1", "2", "5", "10"]);
        assert_eq!(labels(Axis::tens("", 1e-8), &[0.0, 1e-5]), ["≤ 10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        assert_eq!(labels(Axis::tens("", 1e-8), &[1e-8, 1e-5]), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        let even = Axis::even("");
        assert_eq!(labels(even, &[3.0, 59.0]), ["0", "10", "20", "30", "40", "50", "60"]);
        assert_eq!(labels(even, &[0.25]), ["0", "0.05", "0.1", "0.15", "0.2", "0.25"]);
        assert_eq!(labels(even, &[]), ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1"]);
        assert_eq!(labels(TEN, &[2e-7]), ["2·10⁻⁷", "5·10⁻⁷", "10⁻⁶", "2·10⁻⁶"]);
        assert_eq!(superscript(-10), "⁻¹⁰");
    }
}
