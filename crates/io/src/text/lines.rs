//! Lines of a text file, and the fields of a line.

use std::io::{BufRead, Read};

use crate::number::number;
use crate::{Error, InputFile};

/// Longest line that is read: a table of numbers has no longer ones.
pub(super) const MAX_LINE: u64 = 1 << 20;

/// The lines of a text, one at a time.
pub(super) struct Lines<'s> {
    pub source: &'s mut InputFile,
    bytes: Vec<u8>,
    /// Number of the line last read, from 1.
    pub number: u64,
    /// Bytes of the lines read so far.
    pub read: u64,
}

impl<'s> Lines<'s> {
    pub fn new(source: &'s mut InputFile) -> Self {
        Self { source, bytes: Vec::new(), number: 0, read: 0 }
    }

    /// Reads the next line that is not blank into `line`, without white space at its ends; false at the end of the
    /// file.
    pub fn next(&mut self, line: &mut String) -> Result<bool, Error> {
        loop {
            self.bytes.clear();
            let read = self.source.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut self.bytes);
            let read = read.map_err(|e| self.source.read_error(e))? as u64;
            if read == 0 {
                return Ok(false);
            }
            self.number += 1;
            self.read += read;
            if self.bytes.trim_ascii_end().contains(&b'\r') {
                return Err(self.malformed(
                    "a carriage return within the line: old Macs ended lines so; convert them, as in `tr '\\r' '\\n' <in.xyz >out.xyz`",
                ));
            }
            if read == MAX_LINE && !self.bytes.ends_with(b"\n") {
                return Err(self.malformed(format!(
                    "the line is longer than {MAX_LINE} bytes, so this is not a table of numbers"
                )));
            }
            let text = String::from_utf8_lossy(&self.bytes);
            let text = if self.number == 1 { text.trim_start_matches('\u{feff}') } else { &text }.trim();
            if !text.is_empty() {
                line.clear();
                line.push_str(text);
                return Ok(true);
            }
        }
    }

    /// Returns an error about the line last read.
    pub fn malformed(&self, cause: impl Into<String>) -> Error {
        self.source.malformed(format!("line {}", self.number), cause)
    }

    /// Returns an error about a field of the line last read.
    pub fn wrong(&self, fault: Fault) -> Error {
        match fault.column {
            Some(column) => self.source.malformed(format!("line {}, column {column}", self.number), fault.cause),
            None => self.malformed(fault.cause),
        }
    }
}

/// A defect of a line.
pub(super) struct Fault {
    /// The start of the faulty field, in characters from 1, if a field is at fault.
    column: Option<usize>,
    cause: String,
}

/// Returns the text of a comment; `None` for other lines.
pub(super) fn comment(line: &str) -> Option<&str> {
    line.strip_prefix('#').or_else(|| line.strip_prefix("//")).map(str::trim)
}

/// The separator of the fields of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Delimiter {
    /// Blanks or tabs, one or more.
    Blanks,
    /// Exactly one of these.
    Char(char),
}

impl Delimiter {
    /// Returns the first of semicolon, comma and tab that a line has, else blanks. A tab counts if it makes three
    /// fields, a comma if it isn't the decimal mark of fields between tabs or blanks.
    pub fn detect(line: &str) -> Self {
        let tabs = line.matches('\t').count() >= 2 && line.split('\t').all(|field| !field.trim().contains(' '));
        match line {
            _ if line.contains(';') => Self::Char(';'),
            _ if line.contains(',') && !has_decimal_commas(line) => Self::Char(','),
            _ if tabs => Self::Char('\t'),
            _ => Self::Blanks,
        }
    }

    /// Hands the fields of a line over one by one, without white space and quotes around them.
    fn each<'l>(self, line: &'l str, take: impl FnMut(&'l str) -> Result<(), Fault>) -> Result<(), Fault> {
        match self {
            Self::Blanks => line.split_ascii_whitespace().map(bare).try_for_each(take),
            Self::Char(c) => line.split(c).map(bare).try_for_each(take),
        }
    }

    /// Returns the fields of a line of names. In quotes they may have the delimiter in them.
    pub fn names(self, line: &str) -> Vec<String> {
        let mut names = Vec::new();
        if line.contains('"') {
            let delimiter = if let Self::Char(c) = self { c } else { ' ' };
            let line = tidy(line, delimiter);
            let mut builder = csv::ReaderBuilder::new();
            let mut reader = builder.has_headers(false).delimiter(delimiter as u8).from_reader(line.as_bytes());
            let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
            names.extend(record.iter().map(|name| bare(name).to_owned()));
        } else {
            let _ = self.each(line, |name| {
                names.push(name.to_owned());
                Ok(())
            });
        }
        // After a delimiter at the end comes nothing.
        names.pop_if(|name| name.is_empty());
        names
    }
}

/// The fields of a line as numbers: their separator, the columns that aren't read, and the decimal mark.
#[derive(Clone)]
pub(super) struct Fields {
    pub delimiter: Delimiter,
    /// True for a column that may hold anything.
    skipped: Vec<bool>,
    /// Point or comma, once a number had one.
    mark: Option<char>,
}

impl Fields {
    /// Returns the fields of lines like this one. Columns that are `skipped` may hold text.
    pub fn detect(line: &str, skipped: Vec<bool>) -> Self {
        Self { delimiter: Delimiter::detect(line), skipped, mark: None }
    }

    /// The numbers of a line; an empty field is not a number, nor is one of a skipped column.
    pub fn numbers(&mut self, line: &str, row: &mut Vec<f64>) -> Result<(), Fault> {
        row.clear();
        let mut last_empty = false;
        self.delimiter.each(line, |field| {
            last_empty = field.is_empty();
            let skipped = last_empty || self.skipped.get(row.len()) == Some(&true);
            row.push(if skipped { f64::NAN } else { marked(line, field, &mut self.mark)? });
            Ok(())
        })?;
        if last_empty {
            row.pop();
        }
        Ok(())
    }

    /// Takes over the decimal mark of other lines of the same table; false if these have another one.
    pub fn agree(&mut self, others: &Self) -> bool {
        let mark = self.mark.or(others.mark);
        self.mark = mark;
        others.mark.is_none() || others.mark == mark
    }

    /// Reads the numbers of a line like [`Fields::numbers`], for lines that must have `columns` fields.
    pub fn row(&mut self, line: &str, columns: usize, row: &mut Vec<f64>) -> Result<(), Fault> {
        self.numbers(line, row)?;
        if row.len() + 1 == columns && matches!(self.delimiter, Delimiter::Char(c) if line.ends_with(c)) {
            row.push(f64::NAN);
        }
        // Blanks at the end of a line of tabs are gone, and with them the tabs of its empty fields.
        if self.delimiter == Delimiter::Char('\t') && (3..columns).contains(&row.len()) {
            row.resize(columns, f64::NAN);
        }
        if row.len() == columns {
            return Ok(());
        }
        Err(Fault { column: None, cause: format!("expected {columns} values, found {}", row.len()) })
    }
}

/// A number with a decimal point or comma, as all before it have: 1,500 after 0.5 may be 1500, and is refused.
fn marked(line: &str, field: &str, mark: &mut Option<char>) -> Result<f64, Fault> {
    let Some(value) = any_number(field) else { return Err(fault(line, field, "is not a number")) };
    if let Some(found) = field.chars().find(|&c| c == '.' || c == ',').filter(|_| value.is_finite())
        && *mark.get_or_insert(found) != found
    {
        let [has, others] = if found == ',' { ["comma", "point"] } else { ["point", "comma"] };
        return Err(fault(
            line,
            field,
            &format!("has a decimal {has}, where numbers before it have a decimal {others}"),
        ));
    }
    Ok(value)
}

/// Returns a number with a decimal point or comma.
pub(super) fn any_number(field: &str) -> Option<f64> {
    number(field).or_else(|| decimal_comma(field))
}

/// True for three or more numbers between blanks or tabs, at least one with a decimal comma: "1,5 2,5 3". Cut at its
/// commas it has a field with a blank between numbers.
fn has_decimal_commas(line: &str) -> bool {
    let fields: Vec<&str> = line.split_ascii_whitespace().map(bare).collect();
    let decimals = fields.iter().filter(|field| decimal_comma(field).is_some()).count();
    let numbers = fields.iter().filter(|field| number(field).is_some()).count();
    decimals > 0 && decimals + numbers >= 3 && line.split(',').any(|field| field.trim().contains([' ', '\t']))
}

/// A number like 1,5. Where commas separate fields, no field has one.
fn decimal_comma(field: &str) -> Option<f64> {
    let (whole, rest) = field.split_once(',')?;
    let beside = |byte: Option<u8>| byte.is_some_and(|byte| byte.is_ascii_digit());
    let decimal = beside(whole.bytes().last()) && beside(rest.bytes().next()) && !rest.contains(',');
    decimal.then(|| field.replace(',', ".").parse().ok())?
}

/// A line with quotes as the CSV reader likes it: outside of quotes no white space after a delimiter, since a quote
/// begins a field only right behind it; and white space that delimits is a single blank.
fn tidy(line: &str, delimiter: char) -> String {
    let mut quoted = false;
    let mut tidy = String::with_capacity(line.len());
    for c in line.chars() {
        quoted ^= c == '"';
        let c = if !quoted && c.is_whitespace() && delimiter == ' ' { ' ' } else { c };
        let redundant = c.is_whitespace() && c != delimiter || c == ' ' && delimiter == ' ';
        if quoted || !(redundant && tidy.ends_with(delimiter)) {
            tidy.push(c);
        }
    }
    tidy
}

fn bare(field: &str) -> &str {
    let field = field.trim();
    field.strip_prefix('"').and_then(|field| field.strip_suffix('"')).unwrap_or(field).trim()
}

/// The error about a field, which is a part of the line.
fn fault(line: &str, field: &str, cause: &str) -> Fault {
    let bytes = (field.as_ptr() as usize).saturating_sub(line.as_ptr() as usize);
    let column = line.get(..bytes).map_or(0, |before| before.chars().count()) + 1;
    let shown: String = field.chars().take(40).collect();
    Fault { column: Some(column), cause: format!("`{shown}` {cause}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiters() {
        for (line, delimiter) in [
            ("1 2 3", Delimiter::Blanks),
            ("1\t2 3", Delimiter::Blanks),
            ("1 \t2 \t3", Delimiter::Char('\t')),
            ("1\t2\t\t4", Delimiter::Char('\t')),
            ("1, 2, 3", Delimiter::Char(',')),
            ("1;2,5;3", Delimiter::Char(';')),
            ("1,5 2,5 3,5", Delimiter::Blanks),
            ("P1 1,5 2 3,5", Delimiter::Blanks),
            ("1,5\t2,5\t3,5", Delimiter::Char('\t')),
            ("1,2,3 ", Delimiter::Char(',')),
            ("1, 2, 3, 4", Delimiter::Char(',')),
            ("1,5 2,5", Delimiter::Char(',')),
        ] {
            assert_eq!(Delimiter::detect(line), delimiter, "{line}");
        }
    }

    fn numbers(line: &str, columns: usize) -> Result<String, (Option<usize>, String)> {
        let mut row = Vec::new();
        let read = Fields::detect(line, vec![]).row(line, columns, &mut row);
        read.map(|()| format!("{row:?}")).map_err(|fault| (fault.column, fault.cause))
    }

    #[test]
    fn fields() {
        assert_eq!(numbers("1   2\t3", 3).unwrap(), "[1.0, 2.0, 3.0]");
        assert_eq!(numbers("\"1\", 2 ,3e2,", 3).unwrap(), "[1.0, 2.0, 300.0]");
        assert_eq!(numbers("1,,3", 3).unwrap(), "[1.0, NaN, 3.0]");
        assert_eq!(numbers("1,2,3,", 4).unwrap(), "[1.0, 2.0, 3.0, NaN]");
        assert_eq!(numbers("1\t2\t3", 5).unwrap(), "[1.0, 2.0, 3.0, NaN, NaN]");
        assert_eq!(numbers("1 2", 3), Err((None, "expected 3 values, found 2".into())));
        assert_eq!(numbers("1,2,3,4,", 3), Err((None, "expected 3 values, found 4".into())));
        assert_eq!(numbers("µ 2 3", 3), Err((Some(1), "`µ` is not a number".into())));
        assert_eq!(numbers("1;2; 3m", 3), Err((Some(6), "`3m` is not a number".into())));
    }

    #[test]
    fn decimal_commas() {
        assert_eq!(numbers("1,5 -2,25 3e2", 3).unwrap(), "[1.5, -2.25, 300.0]");
        assert_eq!(numbers("1,5\t2\t3,5", 3).unwrap(), "[1.5, 2.0, 3.5]");
        assert_eq!(numbers("\"1,5\"; 2;3,5e1", 3).unwrap(), "[1.5, 2.0, 35.0]");
        let mixed = "`2,500` has a decimal comma, where numbers before it have a decimal point";
        assert_eq!(numbers("1.5;2,500;3", 3), Err((Some(5), mixed.into())));
        let mixed = "`2.5` has a decimal point, where numbers before it have a decimal comma";
        assert_eq!(numbers("1,5;2.5;3", 3), Err((Some(5), mixed.into())));
        for wrong in ["1,234.5", "1,234,567", ",", "1,", ",5", "1,e5"] {
            let cause = format!("`{wrong}` is not a number");
            assert_eq!(numbers(&format!("1;{wrong};3"), 3), Err((Some(3), cause)));
        }
        // The mark is that of the file, not of a line.
        let mut fields = Fields::detect("1;2,5;3", vec![]);
        let mut row = Vec::new();
        assert!(fields.numbers("1;2,5;3", &mut row).is_ok() && fields.numbers("1;2.5;3", &mut row).is_err());
    }

    #[test]
    fn skipped_columns_hold_anything() {
        let mut fields = Fields::detect("P1;1;2.5;3", vec![true]);
        let mut row = Vec::new();
        for id in ["P1", "a,b", "1,5", "1.5", ""] {
            assert!(fields.numbers(&format!("{id};1;2.5;3"), &mut row).is_ok(), "{id}");
            assert!(row[0].is_nan() && row[1..] == [1.0, 2.5, 3.0], "{row:?}");
        }
        assert!(fields.numbers("P1;P1;2.5;3", &mut row).is_err());
    }

    #[test]
    fn names() {
        let names = |line: &str| Delimiter::detect(line).names(line);
        assert_eq!(names("X Y  Z"), ["X", "Y", "Z"]);
        assert_eq!(names("\"X\", \"y,z\" ,\"\","), ["X", "y,z", ""]);
        assert_eq!(names("\"a b\"  \t\"c\" d"), ["a b", "c", "d"]);
        assert_eq!(names("\"a\"\t\t \"c\""), ["a", "", "c"]);
        assert_eq!(names("a,,c,"), ["a", "", "c"]);
    }
}
