//! Properties of a key that are known without reading a scene.

use super::Range;
use crate::setting::Setting;

/// A key of the scene file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Key {
    /// Name of the key inside its table; dotted if it stands in a table of its own there, as `axis.point`.
    pub name: &'static str,
    /// Description of the key, in a sentence.
    pub about: &'static str,
    /// Kind of values that the key takes.
    pub kind: ValueKind,
    /// The unit of its numbers; empty if they have none.
    pub unit: &'static str,
    /// The value in force; `None` if none was given and none stands for it.
    pub value: Option<Setting>,
    /// The behavior without a value, in a few words; empty for a key that always has one.
    pub without: &'static str,
    /// Value at which a control begins when it is switched on, of a key that may have no value. For [`Slider::Lengths`]
    /// it is a share of the scene's diagonal.
    pub start: f64,
    /// The part of its range that a control goes through.
    pub slider: Slider,
    /// The key in whose place it stands: a scene has at most one of the two.
    pub rival: Option<&'static str>,
    /// The methods that use it, of those that share these settings, `auto` among them; empty: all of them.
    pub only: &'static [&'static str],
    /// `true` if larger numbers only make the image better and slower, so that a draft may use fewer.
    pub refines: bool,
    /// The values that `tradeoff` and `--max-error` try.
    pub tried: Option<Ladder>,
}

impl Key {
    pub(crate) fn new(name: &'static str, about: &'static str) -> Self {
        Self {
            name,
            about: about.trim_start(),
            kind: ValueKind::Flag,
            unit: "",
            value: None,
            without: "",
            start: 0.0,
            slider: Slider::Whole,
            rival: None,
            only: &[],
            refines: false,
            tried: None,
        }
    }
}

/// The values that a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ValueKind {
    /// A number.
    Number(Range),
    /// A whole number from the first to the second.
    Integer(u32, u32),
    /// Choice from some whole numbers.
    OneOf(&'static [u32]),
    /// True or false.
    Flag,
    /// Choice from some words.
    Words(&'static [Word]),
    /// Choice from some words, or another string, described by a phrase.
    WordsOr(&'static [Word], &'static str),
    /// A word, or else a value of another kind.
    WordOr(&'static str, &'static ValueKind),
    /// Linear R, G, B, each from 0 to 1.
    Color,
    /// Three coordinates.
    Vector,
    /// Three coordinates, not all of them 0.
    Direction,
    /// Two whole numbers from 1 to this.
    Size(u32),
    /// Whole numbers from 0 to this.
    Integers(u32),
    /// A string that is not empty.
    Text,
    /// Something else, in words.
    Other(&'static str),
}

impl std::fmt::Display for ValueKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(range) if *range == Range::COORDINATE => f.write_str("number"),
            Self::Number(range) if *range == Range::UNIT => f.write_str("number from 0 to 1"),
            Self::Number(range) => write!(f, "number{}", range.describe()),
            Self::Integer(min, max) => write!(f, "integer from {min} to {max}"),
            Self::OneOf(numbers) => f.write_str(&one_of(numbers)),
            Self::Flag => f.write_str("`true` or `false`"),
            Self::Words(words) => f.write_str(&listed(words)),
            Self::WordsOr(words, other) => write!(f, "{}, or {other}", listed(words)),
            Self::WordOr(word, other) => write!(f, "`\"{word}\"` or {other}"),
            Self::Color => f.write_str("`[r, g, b]`, linear, each from 0 to 1, or a CSS color in quotes"),
            Self::Vector => f.write_str("`[x, y, z]`"),
            Self::Direction => f.write_str("`[x, y, z]`, not zero"),
            Self::Size(max) => write!(f, "`[width, height]`, integers from 1 to {max}"),
            Self::Integers(max) => write!(f, "array of integers from 0 to {max}"),
            Self::Text => f.write_str("string"),
            Self::Other(text) => f.write_str(text),
        }
    }
}

/// Words as a file has them, with commas between.
fn listed(words: &[Word]) -> String {
    let words: Vec<_> = words.iter().map(|word| format!("`\"{}\"`", word.name)).collect();
    words.join(", ")
}

/// Numbers in a sentence.
fn one_of(numbers: &[u32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|number| format!("`{number}`")).collect();
    match &numbers[..] {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => numbers.concat(),
    }
}

/// A word that a key takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// Name as the file spells it.
    pub name: &'static str,
    /// Meaning of the word, in a sentence.
    pub about: &'static str,
}

/// The part of a key's range that a control goes through. A file may give any other value of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slider {
    /// All of it.
    Whole,
    /// Numbers from the first to the second, evenly.
    Linear(f64, f64),
    /// Numbers from the first to the second, by powers of ten.
    Powers(f64, f64),
    /// Lengths from the first to the second, as shares of the scene's diagonal, by powers of ten.
    Lengths(f64, f64),
    /// Whole numbers from the first to the second.
    Count(u32, u32),
    /// Opacities by powers of ten, from 0.001 to 1: where layers overlap, the small ones differ the most. Its lower end
    /// is 0.
    Opacity,
}

/// Values of a key that are compared, ascending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ladder {
    /// The steps of a report.
    pub full: &'static [u32],
    /// Values for a first look and for CI.
    pub quick: &'static [u32],
    /// The steps that a choice considers.
    pub fine: &'static [u32],
    /// `true` if a step as large as the longest list of fragments draws all of them, so that larger ones draw the same.
    pub ends_at_longest_list: bool,
    /// Number of those done at once, which take the time of one.
    pub at_once: u32,
    /// The methods that differ by the key, of those that have it; empty: all of them.
    pub only: &'static [&'static str],
}

impl Ladder {
    /// Returns values that are done one by one, all of which a choice considers.
    pub(crate) const fn new(full: &'static [u32], quick: &'static [u32]) -> Self {
        Self { full, quick, fine: full, ends_at_longest_list: false, at_once: 1, only: &[] }
    }
}
