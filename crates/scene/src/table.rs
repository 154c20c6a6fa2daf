//! Typed reading of a table: every getter checks type and range; its errors name the key, the position and the
//! expectation.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};

use super::error::{Error, Place};
use super::schema::Range;
use super::tree::{Entries, Node, Value};
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
        let Self { entries, context, .. } = *self;
        Self { entries, hidden, name: self.name.clone(), place: self.place.clone(), context }
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
            None => {
                let (hidden, place) = (Vec::new(), self.place.clone());
                Ok(Self { entries: None, hidden, name: self.path(key), place, context: self.context })
            }
        }
    }

    /// Returns an array of tables, `[[key]]`; empty if absent.
    pub fn tables(&self, key: &str) -> Result<Vec<Self>, Error> {
        let Some(node) = self.get(key) else { return Ok(Vec::new()) };
        let Value::Array(items) = &node.value else {
            return Err(self.error(
                key,
                node,
                format!("must be written as [[{}]], found {}", named(&self.path(key)), node.value.describe()),
            ));
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

    pub fn number(&self, key: &str, range: Range) -> Result<Option<f64>, Error> {
        self.get(key).map(|node| self.number_at(key, node, range)).transpose()
    }

    /// Returns a number that is stored as float32.
    pub fn number32(&self, key: &str, range: Range) -> Result<Option<f32>, Error> {
        self.get(key).map(|node| self.number32_at(key, node, range)).transpose()
    }

    fn number32_at(&self, key: &str, node: &Node, range: Range) -> Result<f32, Error> {
        let number = self.number_at(key, node, range)? as f32;
        if number.is_finite() {
            Ok(number)
        } else {
            Err(self.error(key, node, format!("does not fit into float32: {}", node.value.describe())))
        }
    }

    fn number_at(&self, key: &str, node: &Node, range: Range) -> Result<f64, Error> {
        let number = match node.value {
            Value::Integer(i) => Some(i as f64),
            Value::Float(f) => Some(f),
            _ => None,
        };
        number.filter(|x| range.contains(*x)).ok_or_else(|| {
            self.error(key, node, format!("must be a number{}, found {}", range.describe(), node.value.describe()))
        })
    }

    /// Returns an integer from `min` to `max`.
    pub fn integer(&self, key: &str, min: u32, max: u32) -> Result<Option<u32>, Error> {
        self.get(key).map(|node| self.integer_at(key, node, min, max)).transpose()
    }

    fn integer_at(&self, key: &str, node: &Node, min: u32, max: u32) -> Result<u32, Error> {
        let integer = match node.value {
            Value::Integer(i) => u32::try_from(i).ok(),
            _ => None,
        };
        integer.filter(|i| (min..=max).contains(i)).ok_or_else(|| {
            self.error(key, node, format!("must be an integer from {min} to {max}, found {}", node.value.describe()))
        })
    }

    pub fn boolean(&self, key: &str) -> Result<Option<bool>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        match node.value {
            Value::Boolean(value) => Ok(Some(value)),
            _ => Err(self.error(key, node, format!("must be true or false, found {}", node.value.describe()))),
        }
    }

    pub fn string(&self, key: &str) -> Result<Option<&'a str>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        match &node.value {
            Value::String(text) if !text.is_empty() => Ok(Some(text)),
            other => {
                Err(self.error(key, node, format!("must be a string that is not empty, found {}", other.describe())))
            }
        }
    }

    /// Returns a file, from the scene's folder.
    pub fn path_of(&self, key: &str) -> Result<Option<PathBuf>, Error> {
        if let Some(Node { value: Value::Path(path), .. }) = self.get(key) {
            return Ok(Some(path.clone()));
        }
        let from = |path: &str| self.context.folder.map_or_else(|| path.into(), |folder| folder.join(path));
        Ok(self.string(key)?.map(from))
    }

    /// Returns one of a few words, each with its meaning.
    pub fn choice<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<T>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let found = match &node.value {
            Value::String(text) => words.iter().find(|(word, _)| word == text),
            _ => None,
        };
        found.map(|(_, meaning)| Some(*meaning)).ok_or_else(|| {
            let list: Vec<_> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
            self.error(key, node, format!("must be one of {}, found {}", list.join(", "), node.value.describe()))
        })
    }

    fn items<const N: usize>(&self, key: &str, node: &'a Node, what: &str) -> Result<&'a [Node; N], Error> {
        let items = match &node.value {
            Value::Array(items) => <&[Node; N]>::try_from(items.as_slice()).ok(),
            _ => None,
        };
        let found = || node.value.describe();
        items.ok_or_else(|| self.error(key, node, format!("must be an array of {N} {what}, found {}", found())))
    }

    /// Returns three coordinates in float64.
    pub fn vector(&self, key: &str) -> Result<Option<DVec3>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let [x, y, z] = self.items(key, node, "numbers")?;
        let number = |node| self.number_at(key, node, Range::COORDINATE);
        Ok(Some(DVec3::new(number(x)?, number(y)?, number(z)?)))
    }

    /// Two numbers.
    pub fn pair(&self, key: &str) -> Result<Option<[f64; 2]>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let [a, b] = self.items(key, node, "numbers")?;
        let number = |node| self.number_at(key, node, Range::ANY);
        Ok(Some([number(a)?, number(b)?]))
    }

    /// Two numbers, the second at least the first.
    pub fn range(&self, key: &str) -> Result<Option<[f64; 2]>, Error> {
        let pair = self.pair(key)?;
        match (pair, self.get(key)) {
            (Some([low, high]), Some(node)) if low > high => {
                Err(self.error(key, node, format!("must go from low to high, found [{low:?}, {high:?}]")))
            }
            _ => Ok(pair),
        }
    }

    /// Returns a vector with a direction: not zero, and short enough to be normalized.
    pub fn direction(&self, key: &str) -> Result<Option<DVec3>, Error> {
        let vector = self.vector(key)?;
        match (vector, self.get(key)) {
            (Some(v), Some(node)) if v.try_normalize().is_none() => {
                Err(self.error(key, node, format!("must be a direction, found {v}")))
            }
            _ => Ok(vector),
        }
    }

    /// Returns linear RGB, each from 0 to 1; or a color of CSS in a text, which is sRGB.
    pub fn color(&self, key: &str) -> Result<Option<Vec3>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        if let Value::String(text) = &node.value {
            let wanted = "must be [r, g, b] in linear light, or a color such as \"white\" or \"#80c0ff\"";
            let color = pellucid_core::color::named(text)
                .ok_or_else(|| self.error(key, node, format!("{wanted}, found {text:?}")));
            return color.map(Some);
        }
        let [r, g, b] = self.items(key, node, "numbers from 0 to 1")?;
        let number = |node| self.number32_at(key, node, Range::UNIT);
        Ok(Some(Vec3::new(number(r)?, number(g)?, number(b)?)))
    }

    /// Two integers from 1 to `max`.
    pub fn size(&self, key: &str, max: u32) -> Result<Option<[u32; 2]>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let [width, height] = self.items(key, node, "integers (width, height)")?;
        Ok(Some([self.integer_at(key, width, 1, max)?, self.integer_at(key, height, 1, max)?]))
    }

    /// Returns a list of integers from 0 to `max`.
    pub fn integers(&self, key: &str, max: u32) -> Result<Option<Vec<u32>>, Error> {
        let Some(node) = self.get(key) else { return Ok(None) };
        let Value::Array(items) = &node.value else {
            return Err(self.error(
                key,
                node,
                format!("must be an array of integers, found {}", node.value.describe()),
            ));
        };
        items.iter().map(|item| self.integer_at(key, item, 0, max)).collect::<Result<_, _>>().map(Some)
    }
}

fn value_error(node: &Node, key: &str, problem: String) -> Error {
    Error::Value { place: node.place.clone(), key: key.to_owned(), problem }
}

/// A path without the places in arrays, as TOML writes it: `cloud.class` of `cloud.0.class`.
fn named(path: &str) -> String {
    path.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
}
