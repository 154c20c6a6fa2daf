//! The header of a PLY file: encoding, elements and their properties in order.

use std::io::{BufRead, Read};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{self, DefaultElement, Encoding, PropertyType};

use crate::{Error, InputFile};

pub(super) use ply_rs_bw::ply::ScalarType;

/// Longest header that is read; a file without `end_header` is not read to its end for nothing.
const MAX_HEADER: u64 = 1 << 20;

/// The parsed header.
pub(super) struct PlyHeader {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Bytes up to and including the line `end_header`.
    pub len: u64,
    /// Lines of the header.
    pub lines: u64,
    /// The text after the word `comment`, with the number of the line from 1.
    pub comments: Vec<(u64, String)>,
}

/// A kind of record, and the number of records.
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A named value or list of a record.
pub(super) struct Property {
    pub name: String,
    pub kind: PlyType,
}

/// Type of a property.
pub(super) enum PlyType {
    Scalar(ScalarType),
    List { count: ScalarType, item: ScalarType },
}

/// Returns the number of bytes of a scalar in binary files.
pub(super) fn size(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Reads the header and leaves the source at the first byte after it.
pub(super) fn read(source: &mut InputFile) -> Result<PlyHeader, Error> {
    let mut tidy = Tidy::default();
    let mut len = 0;
    let mut line = Vec::new();
    loop {
        line.clear();
        let left = MAX_HEADER - len;
        let read = source.reader.by_ref().take(left).read_until(b'\n', &mut line);
        let bytes = read.map_err(|e| source.read_error(e))? as u64;
        len += bytes;
        let whole = line.ends_with(b"\n") || len == source.len;
        if bytes == 0 || !whole {
            let cause = format!("no line `end_header` in the first {len} bytes");
            return Err(source.malformed(format!("line {}", tidy.lines + 1), cause));
        }
        if tidy.add(String::from_utf8_lossy(&line).trim()) {
            break;
        }
    }
    let parsed = Parser::<DefaultElement>::new().read_header(&mut Reader::new(tidy.text.as_bytes()));
    let parsed = parsed.map_err(|e| {
        let place = e.line().map_or_else(|| "header".to_owned(), |line| format!("line {line}"));
        let message = e.to_string();
        let message = message.lines().next().unwrap_or_default();
        let message = message.split_once(": ").map_or(message, |(_, cause)| cause).to_owned();
        let found = e.line().and_then(|line| tidy.original.get(line - 1));
        source.malformed(place, found.map_or(message.clone(), |found| format!("{message} Found `{found}`")))
    })?;
    let Tidy { names, lines, comments, .. } = tidy;
    Ok(PlyHeader { encoding: parsed.encoding, elements: names.restore(parsed), len, lines, comments })
}

/// The header as the parser likes it, line by line the same.
///
/// The parser takes only identifiers for names and keeps one of two equal ones, while files have names such as
/// `scalar_Coord._Z`; so it gets numbers for names, and the file's names are put back afterwards. It also trips over
/// blank lines and comments in other encodings, which mean nothing.
#[derive(Default)]
struct Tidy {
    text: String,
    original: Vec<String>,
    names: Names,
    lines: u64,
    comments: Vec<(u64, String)>,
}

impl Tidy {
    /// Adds a trimmed line; true if it is the last one.
    fn add(&mut self, line: &str) -> bool {
        if let Some(comment) = line.strip_prefix("comment ") {
            self.comments.push((self.lines + 1, comment.trim().to_owned()));
        }
        let mut words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        match (words.first().map(String::as_str), words.len()) {
            (None | Some("comment" | "obj_info"), _) => words = vec!["comment".to_owned()],
            (Some("element"), 3) => words[1] = self.names.element(&words[1]),
            (Some("property"), 3 | 5) => {
                let last = words.len() - 1;
                words[last] = self.names.property(&words[last]);
            }
            _ => {}
        }
        self.text.push_str(&words.join(" "));
        self.text.push('\n');
        self.original.push(line.to_owned());
        self.lines += 1;
        words.first().is_some_and(|word| word == "end_header")
    }
}

/// The names of elements and their properties in the order of the file.
#[derive(Default)]
struct Names(Vec<(String, Vec<String>)>);

impl Names {
    fn element(&mut self, name: &str) -> String {
        self.0.push((name.to_owned(), Vec::new()));
        format!("e{}", self.0.len())
    }

    fn property(&mut self, name: &str) -> String {
        // Before the first element the parser refuses the property.
        let Some((_, properties)) = self.0.last_mut() else { return name.to_owned() };
        properties.push(name.to_owned());
        format!("p{}", properties.len())
    }

    fn restore(self, parsed: ply::Header) -> Vec<Element> {
        let element = |(definition, (name, names)): (ply::ElementDef, (String, Vec<String>))| Element {
            name,
            count: definition.count as u64,
            properties: definition.properties.into_values().zip(names).map(property).collect(),
        };
        parsed.elements.into_values().zip(self.0).map(element).collect()
    }
}

fn property((definition, name): (ply::PropertyDef, String)) -> Property {
    let kind = match definition.data_type {
        PropertyType::Scalar(scalar) => PlyType::Scalar(scalar),
        PropertyType::List(count, item) => PlyType::List { count, item },
    };
    Property { name, kind }
}
