//! Round numbers beside a color bar, with labels of as few digits as tell them apart.

use super::scale::Scale;

/// The most characters of a label that is written out though an exponent would be shorter.
const PLAIN: usize = 7;

/// Powers of ten within a logarithmic scale from which on they stand alone, without 2 and 5 between them.
const ENOUGH_POWERS: usize = 3;

/// A number beside a color bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// The number: the float64 value that is nearest to the label.
    pub value: f64,
    /// Place on the scale: 0 at its low end, 1 at the high one.
    pub place: f64,
    /// The number as text.
    pub label: String,
}

/// digits · 10^exponent, exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Decimal {
    digits: i64,
    exponent: i32,
}

impl Decimal {
    /// The nearest float64 value.
    fn value(self) -> f64 {
        // Reading a number rounds once; a product with a power of ten would do so twice.
        format!("{}e{}", self.digits, self.exponent).parse().unwrap_or(f64::NAN)
    }

    /// The exponent of its first digit.
    fn magnitude(self) -> i32 {
        self.digits.unsigned_abs().checked_ilog10().map_or(i32::MIN, |digits| digits as i32 + self.exponent)
    }

    /// Written out, with as many decimals as the exponent says.
    fn plain(self) -> String {
        let (sign, digits) = (if self.digits < 0 { "-" } else { "" }, self.digits.unsigned_abs());
        match usize::try_from(-self.exponent) {
            Ok(0) => format!("{sign}{digits}"),
            Ok(decimals) => {
                let text = format!("{digits:0>width$}", width = decimals + 1);
                let (whole, rest) = text.split_at(text.len() - decimals);
                format!("{sign}{whole}.{rest}")
            }
            Err(_) if digits == 0 => "0".to_owned(),
            Err(_) => format!("{sign}{digits}{}", "0".repeat(self.exponent as usize)),
        }
    }

    /// Writes the number with a power of ten behind it.
    fn with_power(self, power: i32) -> String {
        if self.digits == 0 {
            return "0".to_owned();
        }
        format!("{}e{power}", Self { exponent: self.exponent - power, ..self }.plain())
    }
}

impl Scale {
    /// Chooses about `most` numbers within the scale, at least 5: 1, 2 or 5 times a power of ten apart; with a
    /// logarithm powers of ten, with 2 and 5 between them if there are few. Of a scale without width its one value, and
    /// where float64 has no round number between the ends, the ends. With `whole` they are whole numbers if two of them
    /// fit.
    pub fn ticks(&self, most: usize, whole: bool) -> Vec<Tick> {
        let [low, high] = self.ends();
        let tick = |value: f64, label: String| Some(Tick { value, place: self.place(value)?, label });
        if low == high {
            return tick(low, shortest(low)).into_iter().collect();
        }
        let found = if self.log { logarithmic(low, high, most) } else { Vec::new() };
        let (labels, found) = if found.len() >= 2 {
            (each_labeled(&found), found)
        } else {
            let found = if whole { linear(low, high, most, 0) } else { Vec::new() };
            let found = if found.len() < 2 { linear(low, high, most, i32::MIN) } else { found };
            (labeled_alike(&found), found)
        };
        if found.len() < 2 {
            return [low, high].into_iter().filter_map(|end| tick(end, shortest(end))).collect();
        }
        found.iter().zip(labels).filter_map(|(number, label)| tick(number.value(), label)).collect()
    }
}

/// The multiples of the smallest step that has no more than `most` of them from low to high. None where float64 can't
/// tell them apart.
fn linear(low: f64, high: f64, most: usize, least_exponent: i32) -> Vec<Decimal> {
    let share = high / most as f64 - low / most as f64;
    if share <= 16.0 * f64::EPSILON * low.abs().max(high.abs()) {
        return Vec::new();
    }
    // The step is larger than half of the share, and at most 5 times as large.
    let first = share.log10().floor() as i32 - 1;
    let mut before = Vec::new();
    for exponent in (first..=first + 4).filter(|exponent| *exponent >= least_exponent) {
        for factor in [1, 2, 5] {
            let found = multiples(low, high, Decimal { digits: factor, exponent }, 3 * most);
            match found {
                Some(found) if found.len() <= most => return if found.len() < 2 { before } else { found },
                found => before = found.unwrap_or_default(),
            }
        }
    }
    before
}

/// The multiples of a step from low to high; `None` if there are more than `most`.
fn multiples(low: f64, high: f64, step: Decimal, most: usize) -> Option<Vec<Decimal>> {
    let size = step.value();
    // One more at each end, since a quotient may be rounded past a whole number.
    let (first, last) = ((low / size).floor() - 1.0, (high / size).ceil() + 1.0);
    if !(last - first <= (most + 4) as f64 && first.abs().max(last.abs()) < 1e15) {
        return None;
    }
    let all = (first as i64..=last as i64).map(|n| Decimal { digits: n * step.digits, ..step });
    Some(all.filter(|number| (low..=high).contains(&number.value())).collect())
}

/// Powers of ten from low to high, which are above 0; with 2 and 5 if there are few.
fn logarithmic(low: f64, high: f64, most: usize) -> Vec<Decimal> {
    let exponents = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
    let within = |factors: &'static [i64]| {
        let numbers = exponents.clone().flat_map(move |exponent| factors.iter().map(move |f| (*f, exponent)));
        let numbers = numbers.map(|(digits, exponent)| Decimal { digits, exponent });
        numbers.filter(|number| (low..=high).contains(&number.value())).collect::<Vec<_>>()
    };
    let powers = within(&[1]);
    if powers.len() < ENOUGH_POWERS {
        return within(&[1, 2, 5]);
    }
    let stride = powers.len().div_ceil(most) as i32;
    powers.into_iter().filter(|power| power.exponent.rem_euclid(stride) == 0).collect()
}

/// Labels of numbers with one exponent: all written out, or all with the same power of ten.
fn labeled_alike(numbers: &[Decimal]) -> Vec<String> {
    let power = numbers.iter().map(|number| number.magnitude()).max().unwrap_or(0);
    let plain: Vec<String> = numbers.iter().map(|number| number.plain()).collect();
    let short: Vec<String> = numbers.iter().map(|number| number.with_power(power)).collect();
    let longest = |labels: &[String]| labels.iter().map(String::len).max().unwrap_or(0);
    if longest(&plain) <= longest(&short).max(PLAIN) { plain } else { short }
}

/// Labels of numbers of any exponents: all written out, or each with its power of ten.
fn each_labeled(numbers: &[Decimal]) -> Vec<String> {
    let plain: Vec<String> = numbers.iter().map(|number| number.plain()).collect();
    if plain.iter().all(|label| label.len() <= PLAIN) {
        return plain;
    }
    numbers.iter().map(|number| number.with_power(number.magnitude())).collect()
}

/// A number by the fewest digits that stand for it alone.
fn shortest(value: f64) -> String {
    let narrow = value as f32;
    // Most values were float32 in their file: 0.1 there is 0.10000000149 here.
    let (plain, short) = if f64::from(narrow) == value {
        (narrow.to_string(), format!("{narrow:e}"))
    } else {
        (value.to_string(), format!("{value:e}"))
    };
    if plain.len() <= short.len().max(PLAIN) { plain } else { short }
}

/// Returns the largest of 1, 2 and 5 times a power of ten that is at most so much, with its label. `None` if this is
/// not above 0.
pub fn round_below(most: f64) -> Option<(f64, String)> {
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let exponent = most.log10().floor() as i32;
    let mut candidates =
        (exponent - 1..=exponent + 1).flat_map(|exponent| [1, 2, 5].map(|digits| Decimal { digits, exponent }));
    let found = candidates.rfind(|number| number.value() > 0.0 && number.value() <= most)?;
    Some((found.value(), labeled_alike(&[found]).pop()?))
}

#[cfg(test)]
mod tests;
