//! The records of a PLY file, one at a time, every scalar as float64 (which holds all eight types exactly).

use std::io::{BufRead, ErrorKind, Read};

use super::header::{Element, PlyHeader, PlyType, ScalarType, size};
use crate::number::number;
use crate::{Error, InputFile};

/// Reader of binary records.
pub(super) struct Binary {
    pub little_endian: bool,
}

impl Binary {
    /// Reads the scalars of a record; its lists are skipped.
    pub fn read(&self, source: &mut InputFile, element: &Element, index: u64, row: &mut Vec<f64>) -> Result<(), Error> {
        row.clear();
        for property in &element.properties {
            let read = match &property.kind {
                PlyType::Scalar(scalar) => self.scalar(&mut source.reader, scalar).map(|value| row.push(value)),
                PlyType::List { count, item } => self.skip_list(&mut source.reader, count, item),
            };
            read.map_err(|e| self.error(source, e, element, index))?;
        }
        Ok(())
    }

    /// Skips all records of an element.
    pub fn skip(&self, source: &mut InputFile, element: &Element) -> Result<(), Error> {
        if element.properties.iter().all(|p| p.kind.scalar().is_some()) {
            let bytes = element.least_bytes() * element.count;
            let skipped = skip_bytes(&mut source.reader, bytes);
            return skipped.map_err(|e| self.error(source, e, element, 0));
        }
        let mut row = Vec::new();
        (0..element.count).try_for_each(|index| self.read(source, element, index, &mut row))
    }

    fn scalar(&self, reader: &mut impl Read, scalar: &ScalarType) -> std::io::Result<f64> {
        let mut bytes = [0; 8];
        reader.read_exact(&mut bytes[..size(scalar) as usize])?;
        let mut value = [0.0];
        column(&bytes, bytes.len(), 0, scalar, self.little_endian, &mut value);
        Ok(value[0])
    }

    fn skip_list(&self, reader: &mut impl Read, count: &ScalarType, item: &ScalarType) -> std::io::Result<()> {
        let length = self.scalar(reader, count)?;
        if !(0.0..=f64::from(u32::MAX)).contains(&length) {
            return Err(std::io::Error::new(ErrorKind::InvalidData, format!("a list can't have {length} items")));
        }
        skip_bytes(reader, length as u64 * size(item))
    }

    fn error(&self, source: &InputFile, e: std::io::Error, element: &Element, index: u64) -> Error {
        match e.kind() {
            ErrorKind::UnexpectedEof => self.ends_early(source, element, index),
            ErrorKind::InvalidData => {
                source.malformed(format!("element `{}`, record {index}", element.name), e.to_string())
            }
            _ => source.read_error(e),
        }
    }

    /// Returns the error of a file that ends in this record of an element.
    pub fn ends_early(&self, source: &InputFile, element: &Element, index: u64) -> Error {
        source.truncated(format!(
            "the file ends at byte {} in record {index} of element `{}`, of which the header announces {}",
            source.len, element.name, element.count
        ))
    }
}

/// The scalars at a byte of each of some records of one size.
pub(super) fn column(records: &[u8], len: usize, at: usize, scalar: &ScalarType, little_endian: bool, to: &mut [f64]) {
    let each = Each { records, len, at, little_endian };
    match scalar {
        ScalarType::Char => each.convert(to, |bytes| i8::from_le_bytes(bytes).into()),
        ScalarType::UChar => each.convert(to, |bytes| u8::from_le_bytes(bytes).into()),
        ScalarType::Short => each.convert(to, |bytes| i16::from_le_bytes(bytes).into()),
        ScalarType::UShort => each.convert(to, |bytes| u16::from_le_bytes(bytes).into()),
        ScalarType::Int => each.convert(to, |bytes| i32::from_le_bytes(bytes).into()),
        ScalarType::UInt => each.convert(to, |bytes| u32::from_le_bytes(bytes).into()),
        ScalarType::Float => each.convert(to, |bytes| f32::from_le_bytes(bytes).into()),
        ScalarType::Double => each.convert(to, f64::from_le_bytes),
    }
}

/// A place in each of some records.
struct Each<'a> {
    records: &'a [u8],
    len: usize,
    at: usize,
    little_endian: bool,
}

impl Each<'_> {
    fn convert<const N: usize>(&self, to: &mut [f64], value: impl Fn([u8; N]) -> f64) {
        for (record, to) in self.records.chunks_exact(self.len).zip(to) {
            if let Some(mut bytes) = record[self.at..].first_chunk().copied() {
                if !self.little_endian {
                    bytes.reverse();
                }
                *to = value(bytes);
            }
        }
    }
}

/// Reads past some bytes; unlike a seek it notices the end of the file.
fn skip_bytes(reader: &mut impl Read, bytes: u64) -> std::io::Result<()> {
    let skipped = std::io::copy(&mut reader.take(bytes), &mut std::io::sink())?;
    if skipped == bytes { Ok(()) } else { Err(ErrorKind::UnexpectedEof.into()) }
}

/// Reader of text records: one per line, blank lines don't count.
pub(super) struct Lines {
    line: Vec<u8>,
    /// Number of the line last read, from 1.
    number: u64,
}

impl Lines {
    /// Starts at the line after the header.
    pub fn after_header(header: &PlyHeader) -> Self {
        Self { line: Vec::new(), number: header.lines }
    }

    /// Skips all records of an element.
    pub fn skip(&mut self, source: &mut InputFile, element: &Element) -> Result<(), Error> {
        if element.properties.is_empty() {
            return Ok(());
        }
        (0..element.count).try_for_each(|index| self.next(source, element, index))
    }

    /// Reads the scalars of a record; its lists are skipped.
    pub fn read(
        &mut self,
        source: &mut InputFile,
        element: &Element,
        index: u64,
        row: &mut Vec<f64>,
    ) -> Result<(), Error> {
        self.next(source, element, index)?;
        let line = String::from_utf8_lossy(&self.line);
        parse(&line, element, row).map_err(|cause| {
            if line.ends_with('\n') {
                return source.malformed(format!("line {}", self.number), cause);
            }
            source.truncated(format!(
                "the file ends in line {}, after {index} of the {} records of element `{}` that the header announces ({cause})",
                self.number, element.count, element.name
            ))
        })
    }

    fn next(&mut self, source: &mut InputFile, element: &Element, index: u64) -> Result<(), Error> {
        loop {
            self.line.clear();
            self.number += 1;
            let read = source.reader.read_until(b'\n', &mut self.line);
            if read.map_err(|e| source.read_error(e))? == 0 {
                return Err(source.truncated(format!(
                    "the file ends at line {} after {index} of the {} records of element `{}` that the header announces",
                    self.number - 1,
                    element.count,
                    element.name
                )));
            }
            if !self.line.trim_ascii().is_empty() {
                return Ok(());
            }
        }
    }
}

/// Splits a line into the values of a record.
fn parse(line: &str, element: &Element, row: &mut Vec<f64>) -> Result<(), String> {
    row.clear();
    let mut words = line.split_ascii_whitespace();
    for property in &element.properties {
        let word = words.next().ok_or_else(|| {
            let (values, name) = (line.split_ascii_whitespace().count(), &property.name);
            format!("expected {} values, found {values}: there is none for property `{name}`", element.properties.len())
        })?;
        let value = number(word).ok_or_else(|| format!("property `{}`: `{word}` is not a number", property.name))?;
        match property.kind {
            PlyType::Scalar(_) => row.push(value),
            PlyType::List { .. } => {
                // A missing item shows up as a missing value of the next property, or not at all.
                for _ in 0..value as u64 {
                    if words.next().is_none() {
                        break;
                    }
                }
            }
        }
    }
    match words.count() {
        0 => Ok(()),
        more => Err(format!("{more} more values than the {} properties", element.properties.len())),
    }
}
