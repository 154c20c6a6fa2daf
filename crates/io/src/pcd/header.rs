//! The header of a PCD file: fields of a point, how many points, and how they are stored.

use std::io::{BufRead, Read};

use glam::{DQuat, DVec3};

use crate::columns::ScalarType;
use crate::number::{Class, NumberType};
use crate::{Error, InputFile};

/// Longest header that is read; a file without `DATA` is not read to its end for nothing.
const MAX_HEADER: u64 = 1 << 20;

/// The storage of the points.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

/// A named group of numbers of a point.
pub(super) struct Field {
    pub name: String,
    pub kind: NumberType,
    /// Bytes of each number: 1, 2, 4 or 8.
    pub size: usize,
    /// The number of values.
    pub count: u64,
}

impl Field {
    /// Returns the type that determines a channel's range; types unknown to PLY read as float64.
    pub fn scalar(&self) -> ScalarType {
        match self.kind {
            NumberType::Float => ScalarType::Float,
            NumberType::Uint8 => ScalarType::UChar,
            NumberType::Int8 => ScalarType::Char,
            NumberType::Uint16 => ScalarType::UShort,
            NumberType::Int16 => ScalarType::Short,
            NumberType::Uint32 => ScalarType::UInt,
            NumberType::Int32 => ScalarType::Int,
            _ => ScalarType::Double,
        }
    }

    /// Returns the number of bytes of the field in a point.
    pub fn bytes(&self) -> u64 {
        (self.size as u64).saturating_mul(self.count)
    }
}

/// The parsed header.
pub(super) struct Header {
    pub fields: Vec<Field>,
    pub points: u64,
    /// Columns of an organized cloud: an image, row by row.
    pub columns: Option<u64>,
    /// Place and rotation of the sensor; `None` if the file has a line about them that can't be used.
    pub viewpoint: Option<(DVec3, DQuat)>,
    pub encoding: Encoding,
    /// Bytes up to and including the line `DATA`.
    pub len: u64,
    /// Lines of the header.
    pub lines: u64,
}

impl Header {
    /// Returns the number of bytes of a point in binary files.
    pub fn record_len(&self) -> u64 {
        self.fields.iter().fold(0, |sum: u64, field| sum.saturating_add(field.bytes()))
    }

    /// Returns the number of numbers of a point.
    pub fn numbers(&self) -> u64 {
        self.fields.iter().fold(0, |sum: u64, field| sum.saturating_add(field.count))
    }
}

/// The lines of a header as they come.
#[derive(Default)]
struct Lines {
    names: Option<Vec<String>>,
    sizes: Option<Vec<usize>>,
    classes: Option<Vec<Class>>,
    counts: Option<Vec<u64>>,
    width: Option<u64>,
    height: Option<u64>,
    points: Option<u64>,
    viewpoint: Option<Option<(DVec3, DQuat)>>,
    encoding: Option<Encoding>,
}

/// Reads the header and leaves the source at the first byte after it.
pub(super) fn read(source: &mut InputFile) -> Result<Header, Error> {
    let mut lines = Lines::default();
    let (mut len, mut number) = (0, 0);
    let mut line = Vec::new();
    while lines.encoding.is_none() {
        line.clear();
        let read = source.reader.by_ref().take(MAX_HEADER - len).read_until(b'\n', &mut line);
        let bytes = read.map_err(|e| source.read_error(e))? as u64;
        if bytes == 0 {
            let cause = format!("no line `DATA` in the first {len} bytes");
            return Err(source.malformed(format!("line {}", number + 1), cause));
        }
        len += bytes;
        number += 1;
        let text = String::from_utf8_lossy(&line);
        lines.add(text.trim()).map_err(|cause| source.malformed(format!("line {number}"), cause))?;
    }
    lines.finish(len, number).map_err(|cause| source.malformed("header", cause))
}

impl Lines {
    fn add(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        let Some(key) = words.next().filter(|key| !key.starts_with('#')) else { return Ok(()) };
        let words: Vec<&str> = words.collect();
        match key.to_ascii_uppercase().as_str() {
            "VERSION" => {}
            "VIEWPOINT" => self.viewpoint = Some(viewpoint(&words)),
            "FIELDS" | "COLUMNS" => self.names = Some(words.iter().map(|&name| name.to_owned()).collect()),
            "SIZE" => self.sizes = Some(all(&words, "1, 2, 4 or 8 for each field", size)?),
            "TYPE" => self.classes = Some(all(&words, "F, I or U for each field", class)?),
            "COUNT" => {
                self.counts = Some(all(&words, "a number, 0 or more, for each field", |word| word.parse().ok())?);
            }
            "WIDTH" => self.width = Some(one(key, &words)?),
            "HEIGHT" => self.height = Some(one(key, &words)?),
            "POINTS" => self.points = Some(one(key, &words)?),
            "DATA" => {
                let name = words.first().map(|word| word.to_ascii_lowercase()).unwrap_or_default();
                self.encoding = Some(match name.as_str() {
                    "ascii" => Encoding::Ascii,
                    "binary" => Encoding::Binary,
                    "binary_compressed" => Encoding::Compressed,
                    _ => return Err(format!("DATA {name:?} (known: ascii, binary, binary_compressed)")),
                });
            }
            _ => {
                return Err(format!("`{}` does not belong in a PCD header", line.chars().take(40).collect::<String>()));
            }
        }
        Ok(())
    }

    fn finish(self, len: u64, lines: u64) -> Result<Header, String> {
        let names = self.names.filter(|names| !names.is_empty()).ok_or("no line `FIELDS`")?;
        let of_each = |key: &str, found: usize| {
            let same = found == names.len();
            if same { Ok(()) } else { Err(format!("{key} has {found} values for {} FIELDS", names.len())) }
        };
        let sizes = self.sizes.unwrap_or_else(|| vec![4; names.len()]);
        let classes = self.classes.unwrap_or_else(|| vec![Class::Float; names.len()]);
        let counts = self.counts.unwrap_or_else(|| vec![1; names.len()]);
        of_each("SIZE", sizes.len())?;
        of_each("TYPE", classes.len())?;
        of_each("COUNT", counts.len())?;
        let area = match (self.width, self.height) {
            (Some(width), Some(height)) => {
                Some(width.checked_mul(height).ok_or_else(|| format!("WIDTH {width} × HEIGHT {height} is too large"))?)
            }
            (width, _) => width,
        };
        let points = match (self.points, area) {
            (Some(points), Some(area)) if points != area => {
                return Err(format!("POINTS is {points}, but WIDTH × HEIGHT is {area}"));
            }
            (points, area) => points.or(area).ok_or("there is neither POINTS nor WIDTH")?,
        };
        let fields = names.into_iter().zip(classes).zip(sizes).zip(counts);
        let field = |(((name, class), size), count)| match NumberType::of(class, size) {
            None => Err(format!("field `{name}` is a float of {size} bytes (known: 4 and 8)")),
            Some(kind) => Ok(Field { name, kind, size, count }),
        };
        let fields = fields.map(field).collect::<Result<_, _>>()?;
        let columns = self.width.filter(|_| self.height.is_some_and(|height| height > 1));
        let viewpoint = self.viewpoint.unwrap_or(Some((DVec3::ZERO, DQuat::IDENTITY)));
        let encoding = self.encoding.unwrap_or(Encoding::Ascii);
        Ok(Header { fields, points, columns, viewpoint, encoding, len, lines })
    }
}

/// The sensor's place and rotation, three numbers and w, x, y, z of a quaternion; `None` of anything else.
fn viewpoint(words: &[&str]) -> Option<(DVec3, DQuat)> {
    let numbers: Vec<f64> = words.iter().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let [tx, ty, tz, w, x, y, z] = numbers.try_into().ok()?;
    let (place, rotation) = (DVec3::new(tx, ty, tz), DQuat::from_xyzw(x, y, z, w));
    let length = rotation.length();
    (place.is_finite() && length.is_normal()).then_some((place, rotation / length))
}

fn all<T>(words: &[&str], expected: &str, parse: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, String> {
    words.iter().map(|word| parse(word).ok_or_else(|| format!("expected {expected}, found `{word}`"))).collect()
}

fn one(key: &str, words: &[&str]) -> Result<u64, String> {
    let word = words.first().copied().unwrap_or_default();
    word.parse().map_err(|_| format!("expected {key} and a number of points, found `{word}`"))
}

fn size(word: &str) -> Option<usize> {
    word.parse().ok().filter(|size| [1, 2, 4, 8].contains(size))
}

fn class(word: &str) -> Option<Class> {
    match word {
        "F" | "f" => Some(Class::Float),
        "I" | "i" => Some(Class::Signed),
        "U" | "u" => Some(Class::Unsigned),
        _ => None,
    }
}
