//! Numbers in text and in bytes.

use serde::{Deserialize, Serialize};

/// Returns a number as C, Python or Windows prints it: `-nan(ind)` and `1.#QNAN` are not numbers, but not errors
/// either.
pub(super) fn number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| special(&word.to_ascii_lowercase()))
}

/// Returns the value of a lower-case word for what is no finite number: `nan(…)` of C, `1.#inf` and the like of
/// Windows, which a precision fills up with zeros.
fn special(word: &str) -> Option<f64> {
    let unsigned = word.strip_prefix(['+', '-']).unwrap_or(word);
    let payload = |rest: &str| rest.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')).is_some();
    if unsigned.strip_prefix("nan").is_some_and(payload) {
        return Some(f64::NAN);
    }
    match unsigned.strip_prefix("1.#")?.trim_end_matches('0') {
        "inf" => Some(if word.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY }),
        "ind" | "qnan" | "snan" => Some(f64::NAN),
        _ => None,
    }
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NumberType {
    /// −128 to 127.
    Int8,
    /// 16 bits with a sign.
    Int16,
    /// 32 bits with a sign.
    Int32,
    /// 64 bits with a sign.
    Int64,
    /// 0 to 255.
    Uint8,
    /// 16 bits.
    Uint16,
    /// 32 bits.
    Uint32,
    /// 64 bits.
    Uint64,
    /// Float32.
    Float,
    /// Float64.
    Double,
    /// Bytes of which nothing is known.
    Undefined,
}

/// Types of one kind and several sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Class {
    Signed,
    Unsigned,
    Float,
}

impl NumberType {
    /// Returns the type of a class with so many bytes; `None` if there is none.
    pub(crate) fn of(class: Class, bytes: usize) -> Option<Self> {
        let kinds = match class {
            Class::Signed => [Self::Int8, Self::Int16, Self::Int32, Self::Int64],
            Class::Unsigned => [Self::Uint8, Self::Uint16, Self::Uint32, Self::Uint64],
            Class::Float => [Self::Undefined, Self::Undefined, Self::Float, Self::Double],
        };
        kinds.into_iter().find(|kind| kind.bytes() == Some(bytes))
    }

    /// Returns its bytes; `None` if they are not known.
    pub(crate) fn bytes(self) -> Option<usize> {
        match self {
            Self::Int8 | Self::Uint8 => Some(1),
            Self::Int16 | Self::Uint16 => Some(2),
            Self::Int32 | Self::Uint32 | Self::Float => Some(4),
            Self::Int64 | Self::Uint64 | Self::Double => Some(8),
            Self::Undefined => None,
        }
    }

    /// Returns the little-endian number at the start of some bytes, of which there are enough.
    pub(crate) fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::Int8 => i8::from_le_bytes(at(bytes, 0)).into(),
            Self::Int16 => short(bytes, 0).cast_signed().into(),
            Self::Int32 => word(bytes, 0).cast_signed().into(),
            Self::Int64 => long(bytes, 0).cast_signed() as f64,
            Self::Uint8 => u8::from_le_bytes(at(bytes, 0)).into(),
            Self::Uint16 => short(bytes, 0).into(),
            Self::Uint32 => word(bytes, 0).into(),
            Self::Uint64 => long(bytes, 0) as f64,
            Self::Float => float(bytes, 0),
            Self::Double => f64::from_bits(long(bytes, 0)),
            Self::Undefined => 0.0,
        }
    }
}

/// Some bytes at a place. Readers check the length of what they read beforehand; behind the end there are zeros.
#[inline]
pub(crate) fn at<const N: usize>(bytes: &[u8], place: usize) -> [u8; N] {
    bytes.get(place..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

/// Returns a little-endian number of 16 bits.
pub(crate) fn short(bytes: &[u8], place: usize) -> u16 {
    u16::from_le_bytes(at(bytes, place))
}

/// Returns a little-endian number of 32 bits.
pub(crate) fn word(bytes: &[u8], place: usize) -> u32 {
    u32::from_le_bytes(at(bytes, place))
}

/// Returns a little-endian number of 64 bits.
pub(crate) fn long(bytes: &[u8], place: usize) -> u64 {
    u64::from_le_bytes(at(bytes, place))
}

/// Returns a float32.
pub(crate) fn float(bytes: &[u8], place: usize) -> f64 {
    f32::from_le_bytes(at(bytes, place)).into()
}

/// Returns a float16.
pub(crate) fn half(bytes: &[u8], place: usize) -> f64 {
    half::f16::from_le_bytes(at(bytes, place)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_many_printers() {
        for (word, value) in [("1", 1.0), ("-1.", -1.0), (".5", 0.5), ("+2e3", 2000.0), ("inf", f64::INFINITY)] {
            assert_eq!(number(word), Some(value), "{word}");
        }
        for word in ["nan", "NaN", "-NaN", "-nan(ind)", "nan(0x7f)", "1.#QNAN", "-1.#IND00", "+1.#SNAN"] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        assert_eq!(["1.#INF", "-1.#INF00"].map(number), [Some(f64::INFINITY), Some(f64::NEG_INFINITY)]);
    }

    #[test]
    fn words_and_colors_are_not_numbers() {
        for word in ["", "x", "1,5", "0x10", "Banana", "nano", "nan(", "#c8281e", "12#4", "1.#", "2.#INF", "1.#QNAN7"] {
            assert_eq!(number(word), None, "{word}");
        }
    }

    #[test]
    fn numbers_and_what_is_behind_them() {
        let bytes = [0, 0, 0x80, 0x3f, 0, 0x3c, 1, 0];
        assert_eq!((float(&bytes, 0), half(&bytes, 4), short(&bytes, 6), word(&bytes, 4)), (1.0, 1.0, 1, 0x0001_3c00));
        assert_eq!((long(&bytes, 0), short(&bytes, 7), word(&bytes, 99)), (0x0001_3c00_3f80_0000, 0, 0));
    }
}
