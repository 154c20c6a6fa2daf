//! Options that stand for keys of the scene file: `--set KEY=VALUE` and the short forms.
//!
//! They are merged into the file's tree before any check, so that one set of checks serves both.

use super::error::{Error, Place};
use super::keys;
use super::tree::{self, Entries, Node, Value};

/// The largest number of segments of a key. Keys of a scene have fewer, and each is a recursion step.
const MAX_SEGMENTS: usize = 32;

/// Keys given by options, in the order in which they win over the file and over each other.
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    entries: Vec<Entry>,
}

/// A key and its value.
#[derive(Debug, Clone)]
struct Entry {
    path: Vec<String>,
    node: Node,
    /// `true` if the value becomes the last one of an array.
    appended: bool,
}

impl Overrides {
    /// Sets a dotted key from the text of an option. The text is read as TOML, else taken as a string. A segment that
    /// is a number picks a table of an array (`cloud.0.opacity`), `*` takes all of them. `option` names the option in
    /// errors, as typed.
    ///
    /// # Errors
    /// A key with an empty segment, or with very many.
    pub fn set(&mut self, option: impl Into<String>, key: &str, text: &str) -> Result<(), Error> {
        self.add(option.into(), key, text, false)
    }

    /// Appends a value: like [`Overrides::set`], but the value becomes the last one of the array that the key has.
    ///
    /// # Errors
    /// Returns the errors of [`Overrides::set`].
    pub fn append(&mut self, option: impl Into<String>, key: &str, text: &str) -> Result<(), Error> {
        self.add(option.into(), key, text, true)
    }

    fn add(&mut self, option: String, key: &str, text: &str, appended: bool) -> Result<(), Error> {
        let place = Place::Option(option);
        let path: Vec<_> = key.split('.').map(|segment| segment.trim().to_owned()).collect();
        if path.len() > MAX_SEGMENTS {
            let problem = format!("a key with {} segments (at most {MAX_SEGMENTS})", path.len());
            return Err(Error::Conflict { place, problem });
        }
        if path.iter().any(String::is_empty) {
            let problem = format!("{key:?} is not a key; write it as in method.shape or cloud.0.opacity");
            return Err(Error::Conflict { place, problem });
        }
        self.entries.push(Entry { path, node: tree::parse_value(text, &place)?, appended });
        Ok(())
    }

    /// Sets a dotted key to a value.
    pub(super) fn put(&mut self, key: &str, value: Node) {
        self.entries.push(Entry { path: key.split('.').map(str::to_owned).collect(), node: value, appended: false });
    }

    /// Sets a key like [`Overrides::set`], from `KEY=VALUE`.
    ///
    /// # Errors
    /// A text without `=`, or a key with an empty segment or very many.
    pub fn set_pair(&mut self, pair: &str) -> Result<(), Error> {
        match pair.split_once('=') {
            Some((key, value)) => self.set(format!("--set {pair}"), key.trim(), value.trim()),
            None => Err(Error::Conflict {
                place: Place::Option(format!("--set {pair}")),
                problem: "expected KEY=VALUE, as in method.shape=oriented".into(),
            }),
        }
    }

    pub(super) fn apply(&self, root: &mut Node) -> Result<(), Error> {
        self.entries.iter().try_for_each(|entry| {
            drop_rival(root, &entry.path);
            insert(root, &entry.path, entry)
        })
    }
}

/// Takes out the file's key that excludes the one an option gives: the option wins.
fn drop_rival(root: &mut Node, path: &[String]) {
    let Some((key, table)) = path.split_last() else { return };
    let numbered = |segment: &String| segment.parse::<usize>().is_ok();
    let owner: Vec<&str> = table.iter().map(|segment| if numbered(segment) { "*" } else { segment.as_str() }).collect();
    for [of, own, rival] in keys::rivals() {
        if owner.join(".") == of && key == own {
            root.visit(table, &mut |value| {
                if let Value::Table(entries) = value {
                    entries.retain(|key, (place, _)| key != rival || !matches!(place, Place::File { .. }));
                }
            });
        }
    }
}

fn insert(at: &mut Node, rest: &[String], entry: &Entry) -> Result<(), Error> {
    let node = &entry.node;
    let Some((segment, rest)) = rest.split_first() else {
        put(at, entry);
        return Ok(());
    };
    let key = entry.path.join(".");
    match &mut at.value {
        Value::Table(entries) => {
            let new = || (node.place.clone(), Node { place: node.place.clone(), value: Value::Table(Entries::new()) });
            let (place, child) = entries.entry(segment.clone()).or_insert_with(new);
            if rest.is_empty() {
                *place = node.place.clone();
            }
            insert(child, rest, entry)
        }
        Value::Array(items) if segment == "*" => items.iter_mut().try_for_each(|item| insert(item, rest, entry)),
        Value::Array(items) => {
            let count = items.len();
            match segment.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
                Some(item) => insert(item, rest, entry),
                None => {
                    let problem =
                        format!("needs a number below {count} in place of `{segment}` (or * for all of them)");
                    Err(Error::Value { place: node.place.clone(), key, problem })
                }
            }
        }
        other => {
            let problem = format!("goes through {}, which has no keys", other.describe());
            Err(Error::Value { place: node.place.clone(), key, problem })
        }
    }
}

/// Puts a value in place of another, or behind those of an array. What is neither an array nor new stays, for the
/// reader to refuse.
fn put(at: &mut Node, entry: &Entry) {
    match &mut at.value {
        _ if !entry.appended => *at = entry.node.clone(),
        Value::Array(items) => items.push(entry.node.clone()),
        Value::Table(entries) if entries.is_empty() => at.value = Value::Array(vec![entry.node.clone()]),
        _ => {}
    }
}
