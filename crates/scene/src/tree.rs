//! A TOML document in which every key and value knows where it was given, so that options can be laid over a file and
//! the same checks name the line of the one or the other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Error, Place};

/// A table's entries, with the place of each key.
pub(crate) type Entries = BTreeMap<String, (Place, Node)>;

/// A value and where it was given.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub place: Place,
    pub value: Value,
}

/// The TOML types that a scene has use for.
#[derive(Debug, Clone)]
pub(crate) enum Value {
    Table(Entries),
    Array(Vec<Node>),
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    /// A path from the command line, which need not be UTF-8.
    Path(PathBuf),
}

impl Node {
    /// Goes to everything of a path that is there; `*` are all items of an array.
    pub fn visit(&mut self, path: &[impl AsRef<str>], at: &mut impl FnMut(&mut Value)) {
        let Some((key, rest)) = path.split_first() else { return at(&mut self.value) };
        let key = key.as_ref();
        match &mut self.value {
            Value::Table(entries) => entries.get_mut(key).into_iter().for_each(|(_, node)| node.visit(rest, at)),
            Value::Array(items) => {
                let picked = |index: usize| key == "*" || key.parse() == Ok(index);
                let items = items.iter_mut().enumerate().filter(|(index, _)| picked(*index));
                items.for_each(|(_, item)| item.visit(rest, at));
            }
            _ => {}
        }
    }
}

impl Value {
    /// Returns the type and, where it is short, the value, for error messages.
    pub fn describe(&self) -> String {
        match self {
            Self::Table(_) => "a table".into(),
            Self::Array(items) => format!("an array of {}", items.len()),
            Self::String(text) if text.chars().count() <= 40 => format!("the string {text:?}"),
            Self::String(_) => "a long string".into(),
            Self::Integer(i) => i.to_string(),
            Self::Float(f) => f.to_string(),
            Self::Boolean(b) => b.to_string(),
            Self::Path(path) => format!("the path {}", path.display()),
        }
    }

    /// Returns the value as JSON; infinities, which JSON can't express, become null.
    pub fn to_json(&self) -> serde_json::Value {
        match self {
            Self::Table(entries) => {
                entries.iter().map(|(key, (_, node))| (key.clone(), node.value.to_json())).collect()
            }
            Self::Array(items) => items.iter().map(|node| node.value.to_json()).collect(),
            Self::String(text) => text.as_str().into(),
            Self::Integer(i) => (*i).into(),
            Self::Float(f) => (*f).into(),
            Self::Boolean(b) => (*b).into(),
            Self::Path(path) => path.to_string_lossy().into(),
        }
    }
}

/// Bytes between two places of a text before which the characters are counted beforehand.
const STRIDE: usize = 64;

/// Turns byte offsets of one text into places.
struct SourceText<'a> {
    path: String,
    text: &'a str,
    line_starts: Vec<usize>,
    /// The number of characters before each multiple of [`STRIDE`]. Counting them for each value of a long line would
    /// take quadratic time.
    characters: Vec<usize>,
}

impl<'a> SourceText<'a> {
    fn new(text: &'a str, path: &Path) -> Self {
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let count = |sum: &mut usize, bytes: &[u8]| Some(std::mem::replace(sum, *sum + begun(bytes)));
        let characters = text.as_bytes().chunks(STRIDE).scan(0, count).collect();
        Self { path: path.display().to_string(), text, line_starts, characters }
    }

    /// Characters that begin before a byte of the text.
    fn characters_before(&self, offset: usize) -> usize {
        let block = (offset / STRIDE).min(self.characters.len().saturating_sub(1));
        let rest = self.text.as_bytes().get(block * STRIDE..offset).unwrap_or_default();
        self.characters.get(block).copied().unwrap_or_default() + begun(rest)
    }

    fn place(&self, offset: usize) -> Place {
        let line = self.line_starts.partition_point(|start| *start <= offset);
        let start = self.line_starts.get(line.saturating_sub(1)).copied().unwrap_or(0);
        let column = 1 + self.characters_before(offset).saturating_sub(self.characters_before(start));
        Place::File { path: self.path.clone(), line, column }
    }
}

/// Characters that begin in some bytes of a text.
fn begun(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte & 0xc0 != 0x80).count()
}

/// Parses a whole document; `path` is only named in places.
pub(crate) fn parse(text: &str, path: &Path) -> Result<Node, Error> {
    let source = SourceText::new(text, path);
    let place = |offset| source.place(offset);
    let document = DeTable::parse(text).map_err(|error| Error::Syntax {
        place: source.place(error.span().map_or(0, |span| span.start)),
        message: format!("{}{}", error.message(), backslash_help(text, error.span())),
    })?;
    let start = document.span().start;
    Ok(Node { place: place(start), value: Value::Table(entries(document.into_inner(), &place)?) })
}

/// Advice about paths of Windows, if an error is about the escape that a backslash begins.
fn backslash_help(text: &str, span: Option<std::ops::Range<usize>>) -> &'static str {
    let before = |at: usize| text.as_bytes().get(at.saturating_sub(BEFORE_ESCAPE)..=at).unwrap_or_default();
    let near = |at: usize| before(at).rsplit(|byte| *byte == b'\n').next().is_some_and(|line| line.contains(&b'\\'));
    if span.is_some_and(|span| near(span.start)) { BACKSLASH_HELP } else { "" }
}

/// Bytes from the backslash of a wrong escape to where the parser stops, at most: `\U` and eight digits.
const BEFORE_ESCAPE: usize = 9;

/// Advice about a backslash in a text between double quotes.
pub(crate) const BACKSLASH_HELP: &str = "; between double quotes a backslash begins an escape, so write a path between single \
     quotes ('C:\\scans\\a.las') or with slashes (\"C:/scans/a.las\")";

/// Parses the value of an option: TOML if it is any, else the text itself as a string.
pub(crate) fn parse_value(text: &str, place: &Place) -> Result<Node, Error> {
    match DeValue::parse(text) {
        Ok(value) => convert(value, &|_| place.clone()),
        // TOML knows neither .5 nor 5. but shells are full of them.
        Err(_) => Ok(Node {
            place: place.clone(),
            value: text.parse().map_or_else(|_| Value::String(text.to_owned()), Value::Float),
        }),
    }
}

fn entries(table: DeTable<'_>, place: &dyn Fn(usize) -> Place) -> Result<Entries, Error> {
    let entry = |(key, value): (Spanned<_>, Spanned<DeValue<'_>>)| {
        let at = place(key.span().start);
        let key: std::borrow::Cow<'_, str> = key.into_inner();
        Ok((key.into_owned(), (at, convert(value, place)?)))
    };
    table.into_iter().map(entry).collect()
}

fn convert(node: Spanned<DeValue<'_>>, place: &dyn Fn(usize) -> Place) -> Result<Node, Error> {
    let at = place(node.span().start);
    let bad = |message: String| Error::Syntax { place: at.clone(), message };
    let value = match node.into_inner() {
        DeValue::String(text) => Value::String(text.into_owned()),
        DeValue::Integer(number) => Value::Integer(
            i64::from_str_radix(number.as_str(), number.radix())
                .map_err(|_| bad(format!("the integer {number} does not fit into 64 bits")))?,
        ),
        DeValue::Float(number) => {
            Value::Float(number.as_str().parse().map_err(|_| bad(format!("{number} is not a number")))?)
        }
        DeValue::Boolean(value) => Value::Boolean(value),
        DeValue::Datetime(date) => return Err(bad(format!("no key takes a date, found {date}"))),
        DeValue::Array(items) => {
            Value::Array(items.into_iter().map(|item| convert(item, place)).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => Value::Table(entries(table, place)?),
    };
    Ok(Node { place: at, value })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(line: usize, column: usize) -> Place {
        Place::File { path: "s.toml".into(), line, column }
    }

    #[test]
    fn keys_and_values_know_their_line_and_column() {
        let node = parse("# ä\n[image]\n size = [1, 22]\n", Path::new("s.toml")).unwrap();
        let Value::Table(root) = node.value else { panic!("a document is a table") };
        let Value::Table(image) = &root["image"].1.value else { panic!("[image] is a table") };
        let (key, value) = &image["size"];
        assert_eq!((key, &value.place), (&at(3, 2), &at(3, 9)));
        let Value::Array(items) = &value.value else { panic!("size is an array") };
        assert_eq!(items[1].place, at(3, 13));
    }

    #[test]
    fn columns_are_characters_however_long_the_line() {
        let long = format!("a = [\"{}\", 1, \"{}\", 2]\nb = [\"\u{e9}\", 3]", "\u{e9}".repeat(500), "x".repeat(500));
        let node = parse(&long, Path::new("s.toml")).unwrap();
        let Value::Table(root) = node.value else { panic!("a document is a table") };
        let columns = |key: &str| {
            let Value::Array(items) = &root[key].1.value else { panic!("an array") };
            items.iter().map(|item| item.place.clone()).collect::<Vec<_>>()
        };
        // `a = [`, a string of 500 and its quotes, comma and blank, and so on.
        assert_eq!(columns("a"), [at(1, 6), at(1, 510), at(1, 513), at(1, 1017)]);
        assert_eq!(columns("b"), [at(2, 6), at(2, 11)]);
    }

    #[test]
    fn a_long_line_of_values_takes_time_that_grows_with_its_length() {
        // Counted from the line's start for each value, these would be 10¹² characters: hours.
        let text = format!("a = [{}]", "1,".repeat(1 << 20));
        let node = parse(&text, Path::new("s.toml")).unwrap();
        let Value::Table(root) = node.value else { panic!("a document is a table") };
        let Value::Array(items) = &root["a"].1.value else { panic!("an array") };
        assert_eq!(items.last().unwrap().place, at(1, text.len() - 2));
    }

    #[test]
    fn syntax_errors_have_a_place() {
        let error = parse("[image]\nsize = [1,\n[x", Path::new("s.toml")).unwrap_err();
        let Error::Syntax { place: Place::File { line, .. }, .. } = error else { panic!("{error:?}") };
        assert!(line >= 2, "line {line}");
    }

    #[test]
    fn a_path_of_windows_gets_advice() {
        for path in [r"C:\scans\a.las", r"C:\Users\a.las", r"C:\x.las"] {
            let text = format!("[[cloud]]\npath = \"{path}\"\n");
            let error = parse(&text, Path::new("s.toml")).unwrap_err().to_string();
            assert!(error.starts_with("s.toml:2:") && error.contains("single quotes ('C:\\scans"), "{path}: {error}");
            parse(&text.replace('"', "'"), Path::new("s.toml")).unwrap();
        }
        let other = parse("[[cloud]]\npath = \"a.las\n", Path::new("s.toml")).unwrap_err().to_string();
        assert!(!other.contains("backslash"), "{other}");
    }

    #[test]
    fn text_that_is_no_toml_value_is_a_string() {
        let place = Place::Option("--set".into());
        assert!(matches!(parse_value("abuffer", &place).unwrap().value, Value::String(s) if s == "abuffer"));
        assert!(matches!(parse_value(".5", &place).unwrap().value, Value::Float(f) if f == 0.5));
        assert!(matches!(parse_value("-0.5", &place).unwrap().value, Value::Float(f) if f == -0.5));
        assert!(matches!(parse_value("[1, 2]", &place).unwrap().value, Value::Array(a) if a.len() == 2));
    }
}
