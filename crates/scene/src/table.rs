//! Typed reading of a table: every getter checks type and range; its errors name the key, the position and the
//! expectation.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};

use super::error::{Error, Place};
use super::range::Range;
use super::tree::{BACKSLASH_HELP, Entries, Node, Value};
use pellucid_core::words::nearest;

/// The context shared by all tables of one scene.
#[derive(Default)]
pub(crate) struct Context<'a> {
    /// The folder that relative paths start from; `None` for the working directory.
    pub folder: Option<&'a Path>,
    /// Warnings about keys without effect, one sentence each.
    pub warnings: RefCell<Vec<String>>,
}

/// A table of the scene and its dotted name.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    entries: Option<&'a Entries>,
    /// Keys that are there but not read.
    hidden: Vec<&'a str>,
    name: String,
    pub place: Place,
    context: &'a Context<'a>,
}

impl<'a> Table<'a> {
    /// Returns the whole document.
    pub fn root(node: &'a Node, context: &'a Context<'a>) -> Result<Self, Error> {
        Self::new(node, String::new(), context)
    }

    fn new(node: &'a Node, name: String, context: &'a Context<'a>) -> Result<Self, Error> {
        let (hidden, place) = (Vec::new(), node.place.clone());
        match &node.value {
            Value::Table(entries) => Ok(Self { entries: Some(entries), hidden, name, place, context }),
            other => Err(value_error(node, &name, format!("must be a table, found {}", other.describe()))),
        }
    }

    fn path(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    pub fn get(&self, key: &str) -> Option<&'a Node> {
        if self.hidden.contains(&key) { None } else { Some(&self.entries?.get(key)?.1) }
    }

    /// Returns the same table as if it didn't have some of its keys.
    pub fn without(&self, hidden: Vec<&'a str>) -> Self {
        Self { hidden, ..self.clone() }
    }

    /// Notes that something has no effect.
    pub fn warn(&self, warning: String) {
        self.context.warnings.borrow_mut().push(warning);
    }

    /// Returns the keys with their places, in alphabetical order.
    pub fn keys(&self) -> impl Iterator<Item = (&'a str, &'a Place)> {
        self.entries.into_iter().flatten().map(|(key, (place, _))| (key.as_str(), place))
    }

    /// Returns a table inside this one; an absent one reads as empty.
    pub fn table(&self, key: &str) -> Result<Self, Error> {
        match self.get(key) {
            Some(node) => Self::new(node, self.path(key), self.context),
            None => Ok(Self { entries: None, name: self.path(key), ..self.without(Vec::new()) }),
        }
    }

    /// Returns an array of tables, `[[key]]`; empty if absent.
    pub fn tables(&self, key: &str) -> Result<Vec<Self>, Error> {
        let Some(node) = self.get(key) else { return Ok(Vec::new()) };
        let Value::Array(items) = &node.value else {
            return Err(self.wrong(key, node, &format!("written as [[{}]]", named(&self.path(key)))));
        };
        let table = |(i, item)| Self::new(item, format!("{}.{i}", self.path(key)), self.context);
        items.iter().enumerate().map(table).collect()
    }

    /// Refuses keys that are not among `known`.
    pub fn refuse_unknown(&self, known: &[&str]) -> Result<(), Error> {
        match self.keys().filter(|(key, _)| !known.contains(key)).min_by_key(|(_, place)| *place) {
            None => Ok(()),
            Some((key, place)) => Err(Error::UnknownKey {
                place: place.clone(),
                key: self.path(key),
                hint: nearest(key, known.iter().copied(), "known here"),
            }),
        }
    }

    /// Returns an error about `key` at the place of `node`.
    pub fn error(&self, key: &str, node: &Node, problem: String) -> Error {
        value_error(node, &self.path(key), problem)
    }

    /// Returns an error about a value that is not what it must be, in words.
    pub fn wrong(&self, key: &str, node: &Node, wanted: &str) -> Error {
        self.error(key, node, format!("must be {wanted}, found {}", node.value.describe()))
    }

    /// Returns an error about keys that contradict each other, or lack one, at the place of one of them; at that of the
    /// table if it is not there.
    pub fn conflict(&self, key: &str, problem: impl Into<String>) -> Error {
        let place = self.get(key).map_or(&self.place, |node| &node.place).clone();
        Error::Conflict { place, problem: problem.into() }
    }

    /// Reads the value of a key, if it has one.
    fn read<T>(&self, key: &str, read: impl FnOnce(&'a Node) -> Result<T, Error>) -> Result<Option<T>, Error> {
        self.get(key).map(read).transpose()
    }

    pub fn number(&self, key: &str, range: Range) -> Result<Option<f64>, Error> {
        self.read(key, |node| self.number_at(key, node, range))
    }

    /// Returns a number that is stored as float32.
    pub fn number32(&self, key: &str, range: Range) -> Result<Option<f32>, Error> {
        self.read(key, |node| self.number32_at(key, node, range))
    }

    fn number32_at(&self, key: &str, node: &Node, range: Range) -> Result<f32, Error> {
        let number = Some(self.number_at(key, node, range)? as f32).filter(|number| number.is_finite());
        let found = || format!("does not fit into float32: {}", node.value.describe());
        number.ok_or_else(|| self.error(key, node, found()))
    }

    fn number_at(&self, key: &str, node: &Node, range: Range) -> Result<f64, Error> {
        let number = match node.value {
            Value::Integer(i) => Some(i as f64),
            Value::Float(f) => Some(f),
            _ => None,
        };
        let number = number.filter(|x| range.contains(*x));
        number.ok_or_else(|| self.wrong(key, node, &format!("a number{}", range.describe())))
    }

    /// Returns an integer from `min` to `max`.
    pub fn integer(&self, key: &str, min: u32, max: u32) -> Result<Option<u32>, Error> {
        self.read(key, |node| self.integer_at(key, node, min, max))
    }

    fn integer_at(&self, key: &str, node: &Node, min: u32, max: u32) -> Result<u32, Error> {
        let integer = if let Value::Integer(i) = node.value { u32::try_from(i).ok() } else { None };
        let integer = integer.filter(|i| (min..=max).contains(i));
        integer.ok_or_else(|| self.wrong(key, node, &format!("an integer from {min} to {max}")))
    }

    pub fn boolean(&self, key: &str) -> Result<Option<bool>, Error> {
        self.read(key, |node| match node.value {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.wrong(key, node, "true or false")),
        })
    }

    pub fn string(&self, key: &str) -> Result<Option<&'a str>, Error> {
        self.read(key, |node| match &node.value {
            Value::String(text) if !text.is_empty() => Ok(text.as_str()),
            _ => Err(self.wrong(key, node, "a string that is not empty")),
        })
    }

    /// Returns a file, from the scene's folder.
    pub fn path_of(&self, key: &str) -> Result<Option<PathBuf>, Error> {
        if let Some(Node { value: Value::Path(path), .. }) = self.get(key) {
            return Ok(Some(path.clone()));
        }
        let from = |path: &str| self.context.folder.map_or_else(|| path.into(), |folder| folder.join(path));
        let path = self.string(key)?.map(|text| (text, from(text)));
        if let (Some((text, path)), Some(node)) = (&path, self.get(key))
            && text.contains(char::is_control)
            && !path.exists()
        {
            return Err(self.error(
                key,
                node,
                format!("names no file: {text:?} has a control character{BACKSLASH_HELP}"),
            ));
        }
        Ok(path.map(|(_, path)| path))
    }

    /// Returns one of a few words, each with its meaning.
    pub fn choice<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<T>, Error> {
        self.read(key, |node| {
            let is_found = |word: &str| matches!(&node.value, Value::String(text) if word == text);
            let found = words.iter().find(|(word, _)| is_found(word));
            found.map(|(_, meaning)| *meaning).ok_or_else(|| {
                let list: Vec<_> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
                self.wrong(key, node, &format!("one of {}", list.join(", ")))
            })
        })
    }

    fn items<const N: usize>(&self, key: &str, node: &'a Node, what: &str) -> Result<&'a [Node; N], Error> {
        let items = if let Value::Array(items) = &node.value { items.as_slice().try_into().ok() } else { None };
        items.ok_or_else(|| self.wrong(key, node, &format!("an array of {N} {what}")))
    }

    fn vector_at(&self, key: &str, node: &'a Node) -> Result<DVec3, Error> {
        let [x, y, z] = self.items(key, node, "numbers")?;
        let number = |node| self.number_at(key, node, Range::COORDINATE);
        Ok(DVec3::new(number(x)?, number(y)?, number(z)?))
    }

    /// Returns three coordinates in float64.
    pub fn vector(&self, key: &str) -> Result<Option<DVec3>, Error> {
        self.read(key, |node| self.vector_at(key, node))
    }

    /// Two numbers, the second at least the first.
    pub fn range(&self, key: &str) -> Result<Option<[f64; 2]>, Error> {
        self.read(key, |node| {
            let [low, high] = self.items(key, node, "numbers")?;
            let number = |node| self.number_at(key, node, Range::ANY);
            match [number(low)?, number(high)?] {
                [low, high] if low > high => {
                    Err(self.error(key, node, format!("must go from low to high, found [{low:?}, {high:?}]")))
                }
                range => Ok(range),
            }
        })
    }

    /// Returns a vector with a direction: not zero, and short enough to be normalized.
    pub fn direction(&self, key: &str) -> Result<Option<DVec3>, Error> {
        self.read(key, |node| match self.vector_at(key, node)? {
            v if v.try_normalize().is_none() => Err(self.error(key, node, format!("must be a direction, found {v}"))),
            v => Ok(v),
        })
    }

    /// Returns linear RGB, each from 0 to 1; or a color of CSS in a text, which is sRGB.
    pub fn color(&self, key: &str) -> Result<Option<Vec3>, Error> {
        self.read(key, |node| {
            if let Value::String(text) = &node.value {
                let wanted = "must be [r, g, b] in linear light, or a color such as \"white\" or \"#80c0ff\"";
                let color = pellucid_core::color::named(text);
                return color.ok_or_else(|| self.error(key, node, format!("{wanted}, found {text:?}")));
            }
            let [r, g, b] = self.items(key, node, "numbers from 0 to 1")?;
            let number = |node| self.number32_at(key, node, Range::UNIT);
            Ok(Vec3::new(number(r)?, number(g)?, number(b)?))
        })
    }

    /// Two integers from 1 to `max`.
    pub fn size(&self, key: &str, max: u32) -> Result<Option<[u32; 2]>, Error> {
        self.read(key, |node| {
            let [width, height] = self.items(key, node, "integers (width, height)")?;
            Ok([self.integer_at(key, width, 1, max)?, self.integer_at(key, height, 1, max)?])
        })
    }

    /// Returns a list of integers from 0 to `max`.
    pub fn integers(&self, key: &str, max: u32) -> Result<Option<Vec<u32>>, Error> {
        self.read(key, |node| match &node.value {
            Value::Array(items) => items.iter().map(|item| self.integer_at(key, item, 0, max)).collect(),
            _ => Err(self.wrong(key, node, "an array of integers")),
        })
    }
}

fn value_error(node: &Node, key: &str, problem: String) -> Error {
    Error::Value { place: node.place.clone(), key: key.to_owned(), problem }
}

/// A path without the places in arrays, as TOML writes it: `cloud.class` of `cloud.0.class`.
fn named(path: &str) -> String {
    path.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
}
