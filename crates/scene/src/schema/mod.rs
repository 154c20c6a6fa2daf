//! Declaration of the keys of the scene file: once, beside the field that they set.
//!
//! [`settings!`] declares a struct whose fields are keys, [`words!`] an enum that a file spells as words, [`value!`]
//! how a file writes another type. The struct, its defaults, its reader and the list of its keys ([`Key`]) all follow
//! from that one declaration; the reference of the scene file, the controls of the window and the ladders of
//! comparisons follow from the list.

mod key;
mod macros;
mod value;

pub use super::range::Range;
pub use key::{Key, Ladder, Slider, ValueKind, Word};
pub(crate) use macros::{allowed, keys, settings, value, words};
pub use value::rounded;
pub(crate) use value::{SettingsField, Value, Vectors};

use std::any::Any;

use super::error::Error;
use super::table::Table;

/// Settings whose fields are keys of one table.
pub(crate) trait Settings {
    /// The keys with the values in force, in the order of their declaration.
    fn keys(&self) -> Vec<Key>;

    /// Adds these settings, and those inside.
    fn parts<'a>(&'a self, all: &mut Vec<&'a dyn Any>);

    /// Takes the values that the table gives. What it doesn't give stays.
    ///
    /// # Errors
    /// A value of another type or outside its range, keys that contradict each other.
    fn read(&mut self, table: &Table<'_>) -> Result<(), Error>;
}
