//! Numbers in text.

/// Returns a number as C, Python or Windows prints it: `-nan(ind)` and `1.#QNAN` are not numbers, but not errors
/// either.
pub(super) fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let lower = word.to_ascii_lowercase();
        (lower.contains("nan") || lower.contains('#')).then_some(f64::NAN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_many_printers() {
        for (word, value) in [("1", 1.0), ("-1.", -1.0), (".5", 0.5), ("+2e3", 2000.0), ("inf", f64::INFINITY)] {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for word in ["nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND"] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        for word in ["", "x", "1,5", "0x10"] {
            assert_eq!(number(word), None, "{word}");
        }
    }
}
