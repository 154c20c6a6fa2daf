//! A value for a key of a scene, as options and controls give it.

use super::error::Place;
use super::tree::{Node, Value};

/// A value for a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Setting {
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(u32),
    /// True or false.
    Flag(bool),
    /// A string.
    Word(String),
    /// Some numbers.
    Numbers(Vec<f64>),
    /// Some whole numbers.
    Integers(Vec<u32>),
}

/// Implements the conversion of a type, of any length `N`, to the variant that holds it.
macro_rules! from {
    ($($From:ty => $Variant:ident $(, const $N:ident)?;)+) => {
        $(impl $(<const $N: usize>)? From<$From> for Setting {
            fn from(value: $From) -> Self {
                Self::$Variant(value.into())
            }
        })+
    };
}

from! {
    f64 => Number;
    u32 => Integer;
    bool => Flag;
    &str => Word;
    [f64; N] => Numbers, const N;
    [u32; N] => Integers, const N;
}

/// The notation of a scene file.
impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x:?}"),
            Self::Integer(i) => write!(f, "{i}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Word(word) => write!(f, "{word:?}"),
            Self::Numbers(list) => write!(f, "{list:?}"),
            Self::Integers(list) => write!(f, "{list:?}"),
        }
    }
}

impl Setting {
    pub(super) fn into_value(self, place: &Place) -> Value {
        let node = |value| Node { place: place.clone(), value };
        match self {
            Self::Number(x) => Value::Float(x),
            Self::Integer(i) => Value::Integer(i.into()),
            Self::Flag(flag) => Value::Boolean(flag),
            Self::Word(word) => Value::String(word),
            Self::Numbers(list) => Value::Array(list.into_iter().map(|x| node(Value::Float(x))).collect()),
            Self::Integers(list) => Value::Array(list.into_iter().map(|i| node(Value::Integer(i.into()))).collect()),
        }
    }
}
