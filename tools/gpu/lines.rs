//! Lines of JSON on standard output.

use std::time::Duration;

use serde_json::{Value, json};

/// Prints a line of a kind, at once: the process may be ended at any time.
pub fn put(kind: &str, mut line: Value) {
    line["kind"] = kind.into();
    println!("{line}");
}

/// Prints a line of a kind for something that was not measured, and why.
pub fn put_missing(kind: &str, mut line: Value, word: &str, why: &str) {
    line[word] = why.into();
    put(kind, line);
}

/// A time in milliseconds, of four digits.
pub fn ms(time: Duration) -> Value {
    rounded(time.as_secs_f64() * 1e3)
}

/// Four significant digits: times have no more.
pub fn rounded(value: f64) -> Value {
    if !value.is_finite() {
        return Value::Null;
    }
    json!(format!("{value:.3e}").parse::<f64>().unwrap_or(value))
}

/// Numbers of an object or a list, rounded.
pub fn all_rounded(value: Value) -> Value {
    match value {
        Value::Number(number) if number.is_f64() => rounded(number.as_f64().unwrap_or(f64::NAN)),
        Value::Array(values) => values.into_iter().map(all_rounded).collect(),
        Value::Object(map) => map.into_iter().map(|(key, value)| (key, all_rounded(value))).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_are_kept_and_whole_numbers_whole() {
        assert_eq!(rounded(1234.56), json!(1235.0));
        assert_eq!(rounded(0.000_123_449), json!(0.000_123_4));
        assert_eq!(rounded(f64::INFINITY), Value::Null);
        assert_eq!(ms(Duration::from_micros(1500)), json!(1.5));
        let line = json!({ "n": 123_456, "ms": [1.000_04, { "deep": 9.999_96 }], "name": "a" });
        assert_eq!(all_rounded(line), json!({ "n": 123_456, "ms": [1.0, { "deep": 10.0 }], "name": "a" }));
    }
}
