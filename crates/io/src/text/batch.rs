//! Many lines of a table at a time, parsed on all cores as long as nothing is odd about them.

use std::io::{BufRead, Read, Seek, SeekFrom};

use super::lines::{Fields, Lines, MAX_LINE, comment};
use crate::Error;
use pellucid_core::parallel;

/// Bytes of a batch, but for the rest of its last line.
const BATCH: u64 = 8 << 20;
/// Bytes of the part of a batch that a thread parses, about.
const PART: usize = 256 << 10;

/// Whole lines of a file, which are read but not yet parsed.
pub(super) struct Batch {
    bytes: Vec<u8>,
}

/// The rows of a batch.
pub(super) struct Parsed<P> {
    /// Results for the rows of each part.
    pub parts: Vec<P>,
    pub rows: u64,
    fields: Fields,
    lines: u64,
}

impl Batch {
    /// Returns the next lines; `None` at the end of the file.
    pub fn read(lines: &mut Lines) -> Result<Option<Self>, Error> {
        let mut bytes = Vec::new();
        let reader = &mut lines.source.reader;
        let read = reader.by_ref().take(BATCH).read_to_end(&mut bytes);
        let whole = read.and_then(|_| reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes));
        whole.map_err(|e| lines.source.read_error(e))?;
        Ok((!bytes.is_empty()).then_some(Self { bytes }))
    }

    /// Returns the rows of all lines, of which each thread makes something; `None` if a line is no row of so many
    /// numbers, or if decimal marks differ.
    pub fn parse<P: Send>(
        &self,
        fields: &Fields,
        columns: usize,
        make: impl Fn(Vec<f64>) -> P + Sync,
    ) -> Option<Parsed<P>> {
        let parse = |part| {
            let (values, fields, lines) = parse(part, fields.clone(), columns)?;
            let rows = (values.len() / columns) as u64;
            Some((make(values), rows, fields, lines))
        };
        let parts = parallel::try_map_each(&self.parts(), |part| parse(part).ok_or(())).ok()?;
        let mut all = Parsed { parts: Vec::with_capacity(parts.len()), rows: 0, fields: fields.clone(), lines: 0 };
        for (part, rows, fields, lines) in parts {
            if !all.fields.agree(&fields) {
                return None;
            }
            all.parts.push(part);
            all.rows += rows;
            all.lines += lines;
        }
        Some(all)
    }

    /// Runs of whole lines.
    fn parts(&self) -> Vec<&[u8]> {
        let mut parts = Vec::new();
        let mut rest = &*self.bytes;
        while !rest.is_empty() {
            let from = PART.min(rest.len());
            let end = rest[from..].iter().position(|&byte| byte == b'\n').map_or(rest.len(), |at| from + at + 1);
            let (part, behind) = rest.split_at(end);
            parts.push(part);
            rest = behind;
        }
        parts
    }

    /// Counts the lines as read, whose rows and fields these are.
    pub fn pass<P>(self, lines: &mut Lines, parsed: &Parsed<P>, fields: &mut Fields) {
        fields.clone_from(&parsed.fields);
        lines.number += parsed.lines;
        lines.read += self.bytes.len() as u64;
    }

    /// Puts the lines back to be read one by one; returns the byte behind them.
    pub fn put_back(self, lines: &mut Lines) -> Result<u64, Error> {
        let sought = lines.source.reader.seek(SeekFrom::Start(lines.read));
        sought.map_err(|e| lines.source.read_error(e))?;
        Ok(lines.read + self.bytes.len() as u64)
    }
}

/// Values of all rows of a part of a batch, one behind the other, their fields, and how many lines they are.
fn parse(part: &[u8], mut fields: Fields, columns: usize) -> Option<(Vec<f64>, Fields, u64)> {
    // A row for each line at most; the last one needs no end. Its shortest value takes two bytes.
    let most = (part.iter().filter(|&&byte| byte == b'\n').count() + 1).saturating_mul(columns).min(part.len());
    let (mut values, mut row, mut lines) = (Vec::with_capacity(most), Vec::new(), 0);
    for line in part.split_inclusive(|&byte| byte == b'\n') {
        lines += 1;
        if line.len() as u64 > MAX_LINE {
            return None;
        }
        let text = String::from_utf8_lossy(line);
        let text = text.trim();
        if !text.is_empty() && comment(text).is_none() {
            fields.row(text, columns, &mut row).ok()?;
            values.extend_from_slice(&row);
        }
    }
    Some((values, fields, lines))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::InputFile;

    #[test]
    fn odd_lines_are_left_to_others() {
        let rows = |text: &str| {
            let batch = Batch { bytes: text.as_bytes().to_vec() };
            let parsed = batch.parse(&Fields::detect("1;2;3", vec![]), 3, |values| values)?;
            let values = parsed.parts.concat();
            assert_eq!(parsed.rows, values.len() as u64 / 3);
            Some((values, parsed.lines))
        };
        assert_eq!(rows("1;2;3\n\n# 4\n 4;5;6"), Some((vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 4)));
        for odd in ["1;2;3\n4;5\n", "1;2;3\n4\n", "1;x;3\n", "1,5;2;3\n1.5;2;3\n"] {
            assert_eq!(rows(odd), None, "{odd}");
        }
        // Marks of different parts.
        let many = "1,5;2;3\n".repeat(PART / 4);
        assert_eq!(
            rows(&many).map(|(values, lines)| (values.len() as u64, lines)),
            Some((3 * (PART as u64 / 4), PART as u64 / 4))
        );
        assert_eq!(rows(&format!("{many}1.5;2;3\n")), None);
        assert_eq!(rows(&format!("1;2;3{}\n", " ".repeat(MAX_LINE as usize))), None);
    }

    #[test]
    fn lines_that_are_put_back_are_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines");
        std::fs::write(&path, "a\nb\n\nc").unwrap();
        let mut source = InputFile::open(&path).unwrap();
        let (mut lines, mut line) = (Lines::new(&mut source), String::new());
        assert!(lines.next(&mut line).unwrap());
        let batch = Batch::read(&mut lines).unwrap().unwrap();
        assert_eq!(batch.bytes, b"b\n\nc");
        assert_eq!(batch.put_back(&mut lines).unwrap(), 6);
        assert!(lines.next(&mut line).unwrap() && line == "b");
        assert!(lines.next(&mut line).unwrap() && line == "c" && (lines.number, lines.read) == (4, 6));
        assert!(Batch::read(&mut lines).unwrap().is_none());
    }
}
