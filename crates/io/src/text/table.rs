//! Tables of numbers: XYZ, CSV, TXT and their like, and PTS, which announces how many points follow.

use rayon::prelude::*;

use pellucid_core::progress::Progress;

use super::batch::Batch;
use super::lines::{Delimiter, Fields, Lines, any_number, comment};
use super::names::{ColumnNames, UsedColumns, by_values, of_pts};
use crate::columns;
use crate::{Error, InputFile};
use pellucid_core::cloud::Cloud;

/// Bytes of the shortest line of a point: three digits, each with something behind it.
pub(super) const LEAST_LINE: u64 = 6;

/// Reads a table. `pts`: columns without names are those of a PTS file.
pub(super) fn read(
    source: &mut InputFile,
    pts: bool,
    given: Option<&ColumnNames>,
    progress: &Progress,
) -> Result<Cloud, Error> {
    let mut lines = Lines::new(source);
    let mut line = String::new();
    let Some(mut head) = Head::read(&mut lines, &mut line, given)? else { return Ok(Cloud::default()) };
    progress.set_length(lines.source.len / (line.len() as u64 + 1));
    let mut table = TextTable {
        rows: TextRows::new(&lines, head.names.as_deref())?,
        block: head.block.take(),
        points: 0,
        row: Vec::new(),
    };
    table.take(&lines, &mut head, &line)?;
    while let Some(batch) = Batch::read(&mut lines)? {
        let before = table.points;
        let parsed = batch.parse(&head.fields, head.columns, |values| table.rows.part(values, head.columns));
        if let Some(parsed) = parsed {
            batch.pass(&mut lines, &parsed, &mut head.fields);
            table.points += parsed.rows;
            table.rows.extend(parsed.parts);
        } else {
            let end = batch.put_back(&mut lines)?;
            while lines.read < end && lines.next(&mut line)? {
                table.take(&lines, &mut head, &line)?;
            }
        }
        progress.inc(table.points - before);
    }
    let warning = table.check_block(&lines)?;
    progress.set_length(table.points);
    progress.set_position(table.points);
    let mut cloud = table.rows.finish(&lines, head.columns, pts)?;
    cloud.warnings.extend(warning);
    Ok(cloud)
}

/// The lines before the first point.
struct Head {
    fields: Fields,
    columns: usize,
    names: Option<Vec<String>>,
    block: Option<AnnouncedBlock>,
}

/// A number of points that a line announces.
struct AnnouncedBlock {
    line: u64,
    announced: u64,
    /// Points before it.
    start: u64,
}

impl Head {
    /// Reads up to the first line of numbers and leaves it in `line`; `None` if the file has none.
    fn read(lines: &mut Lines, line: &mut String, given: Option<&ColumnNames>) -> Result<Option<Self>, Error> {
        let (mut remark, mut header, mut block) = (None, None, None);
        let mut header_delimiter = None;
        let skipped = given.map(ColumnNames::skipped).unwrap_or_default();
        loop {
            if !lines.next(line)? {
                return Ok(None);
            }
            if let Some(text) = comment(line) {
                remark = Some(text.to_owned());
            } else if let (None, None, Some(announced)) = (&block, &header, count(line)) {
                block = Some(AnnouncedBlock::new(lines, announced)?);
            } else if header.is_none() && !is_numbers(line, &skipped) {
                let delimiter = Delimiter::detect(line);
                header_delimiter = Some(delimiter);
                header = Some((lines.number, delimiter.names(line)));
                check_names(lines, header.as_ref(), given)?;
            } else {
                break;
            }
        }
        let mut fields = Fields::detect(line, skipped);
        if let (Some(Delimiter::Char(of_names)), Delimiter::Char(of_values)) = (header_delimiter, fields.delimiter)
            && of_names != of_values
        {
            return Err(lines.malformed(format!(
                "the values are separated by {of_values:?}, but the names before them by {of_names:?}; write one of them throughout"
            )));
        }
        let mut row = Vec::new();
        fields.numbers(line, &mut row).map_err(|fault| lines.wrong(fault))?;
        let columns = match (given, &header) {
            (Some(given), _) => {
                expect(lines, row.len(), given.as_slice().len(), "names are given for", " (name a column to skip `-`)")?
            }
            (None, Some((number, names))) => {
                expect(lines, row.len(), names.len(), &format!("line {number} names"), "")?
            }
            (None, None) => row.len(),
        };
        if columns < 3 {
            return Err(lines.malformed(format!("expected at least 3 values (x y z), found {columns}")));
        }
        let names = given.map(|given| given.as_slice().to_vec());
        let names = names.or(header.map(|(_, names)| names)).or_else(|| of_remark(&remark?, columns));
        Ok(Some(Self { fields, columns, names, block }))
    }
}

/// Checks that a header has the coordinates, unless the user names the columns.
fn check_names(lines: &Lines, header: Option<&(u64, Vec<String>)>, given: Option<&ColumnNames>) -> Result<(), Error> {
    let Some((_, names)) = header.filter(|_| given.is_none()) else { return Ok(()) };
    let has = |wanted: &str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
    match ["x", "y", "z"].into_iter().find(|name| !has(name)) {
        None => Ok(()),
        Some(missing) => {
            let found: String = names.join(", ").chars().take(100).collect();
            Err(lines.malformed(format!("no column `{missing}`, only [{found}]; --columns names them")))
        }
    }
}

/// Checks the number of values; a name may be there for values that are missing at the end of a line.
fn expect(lines: &Lines, found: usize, wanted: usize, who: &str, help: &str) -> Result<usize, Error> {
    if found == wanted || (3..wanted).contains(&found) && found + 1 == wanted {
        return Ok(wanted);
    }
    Err(lines.malformed(format!("{found} values, but {who} {wanted} columns{help}")))
}

/// The columns that a comment before the first line names, if it does.
fn of_remark(remark: &str, columns: usize) -> Option<Vec<String>> {
    let names = Delimiter::detect(remark).names(remark);
    let has = |wanted: &str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
    (names.len() == columns && ["x", "y", "z"].iter().all(|name| has(name))).then_some(names)
}

/// The number of a line that has nothing else.
fn count(line: &str) -> Option<u64> {
    line.parse().ok()
}

fn is_numbers(line: &str, skipped: &[bool]) -> bool {
    Fields::detect(line, skipped.to_vec()).numbers(line, &mut Vec::new()).is_ok()
}

impl AnnouncedBlock {
    fn new(lines: &Lines, announced: u64) -> Result<Self, Error> {
        // The last line needs no end.
        let left = lines.source.len.saturating_sub(lines.read) + 1;
        if announced > left / LEAST_LINE {
            return Err(lines.source.truncated(format!(
                "line {} announces {announced} points, but the {} bytes after it hold at most {}",
                lines.number,
                left - 1,
                left / LEAST_LINE
            )));
        }
        Ok(Self { line: lines.number, announced, start: 0 })
    }
}

/// The points read so far, and the announced number of points.
struct TextTable {
    rows: TextRows,
    block: Option<AnnouncedBlock>,
    points: u64,
    /// The numbers of the line last taken.
    row: Vec<f64>,
}

impl TextTable {
    /// Takes a line: a point, a comment, or the number of the points of another scan.
    fn take(&mut self, lines: &Lines, head: &mut Head, line: &str) -> Result<(), Error> {
        if comment(line).is_none() && !self.begins_block(lines, line)? {
            head.fields.row(line, head.columns, &mut self.row).map_err(|fault| lines.wrong(fault))?;
            self.rows.push(&self.row);
            self.points += 1;
        }
        Ok(())
    }

    /// Returns `true` if a line announces the points of another scan; only valid after all points of the previous one.
    fn begins_block(&mut self, lines: &Lines, line: &str) -> Result<bool, Error> {
        let Some(block) = &self.block else { return Ok(false) };
        if self.points - block.start != block.announced {
            return Ok(false);
        }
        let Some(announced) = count(line) else { return Ok(false) };
        self.block = Some(AnnouncedBlock { start: self.points, ..AnnouncedBlock::new(lines, announced)? });
        Ok(true)
    }

    /// Fails if points are missing; returns a warning if there are more than announced.
    fn check_block(&self, lines: &Lines) -> Result<Option<String>, Error> {
        let Some(AnnouncedBlock { line, announced, start }) = self.block else { return Ok(None) };
        let found = self.points - start;
        if found < announced {
            let what = format!(
                "the file ends at line {} after {found} of the {announced} points that line {line} announces",
                lines.number
            );
            return Err(lines.source.truncated(what));
        }
        let more = format!("line {line} announces {announced} points, but {found} follow; all of them are read");
        Ok((found > announced).then_some(more))
    }
}

/// Rows as they come, in parts: in columns if these are known, else kept until all values are.
struct TextRows {
    places: Option<Places>,
    tables: Vec<columns::PointTable>,
    kept: Vec<Vec<f64>>,
    /// The values of a row in the order of its columns.
    row: Vec<f64>,
}

/// Some of the rows: in columns, or their values.
type ParsedRows = (Option<columns::PointTable>, Vec<f64>);

/// Roles of the values of a line.
struct Places {
    layout: columns::RowLayout,
    /// The value of a line that each column of the layout takes.
    at: Vec<usize>,
}

impl Places {
    fn new(lines: &Lines, names: &[String]) -> Result<Self, Error> {
        let UsedColumns { columns, at } = UsedColumns::from_names(names);
        let layout = columns::RowLayout::new(&columns)
            .map_err(|missing| lines.malformed(format!("no column `{missing}`, only [{}]", names.join(", "))))?;
        Ok(Self { layout, at })
    }

    fn push(&self, table: &mut columns::PointTable, values: &[f64], row: &mut Vec<f64>) {
        row.clear();
        row.extend(self.at.iter().map(|&at| values[at]));
        table.push(&self.layout, row);
    }

    /// The columns of rows of so many values.
    fn table(&self, values: &[f64], columns: usize) -> columns::PointTable {
        let mut table = columns::PointTable::new(&self.layout, 0);
        table.reserve(values.len() / columns);
        let mut row = Vec::with_capacity(self.at.len());
        values.chunks_exact(columns).for_each(|values| self.push(&mut table, values, &mut row));
        table
    }

    fn finish(&self, parts: Vec<columns::PointTable>) -> Cloud {
        columns::PointTable::join(&self.layout, parts).into_cloud(&self.layout)
    }
}

impl TextRows {
    fn new(lines: &Lines, names: Option<&[String]>) -> Result<Self, Error> {
        let places = names.map(|names| Places::new(lines, names)).transpose()?;
        let tables = places.iter().map(|places| columns::PointTable::new(&places.layout, 0)).collect();
        Ok(Self { places, tables, kept: vec![Vec::new()], row: Vec::new() })
    }

    /// Adds a row to the last part.
    fn push(&mut self, values: &[f64]) {
        match (&self.places, self.tables.last_mut()) {
            (Some(places), Some(last)) => places.push(last, values, &mut self.row),
            _ => self.kept.last_mut().into_iter().for_each(|last| last.extend_from_slice(values)),
        }
    }

    /// A part of rows of so many values.
    fn part(&self, values: Vec<f64>, columns: usize) -> ParsedRows {
        match &self.places {
            Some(places) => (Some(places.table(&values, columns)), Vec::new()),
            None => (None, values),
        }
    }

    /// Adds parts that [`Self::part`] made.
    fn extend(&mut self, more: Vec<ParsedRows>) {
        for (table, values) in more {
            self.tables.extend(table);
            self.kept.push(values);
        }
    }

    fn finish(self, lines: &Lines, columns: usize, pts: bool) -> Result<Cloud, Error> {
        if let Some(places) = self.places {
            return Ok(places.finish(self.tables));
        }
        let names = if pts { of_pts(columns, &self.kept) } else { None };
        let places = Places::new(lines, &names.unwrap_or_else(|| by_values(columns, &self.kept)))?;
        // The values of each part are gone once they are in columns.
        let parts = self.kept.into_par_iter().map(|values| places.table(&values, columns));
        Ok(places.finish(parts.collect()))
    }
}

/// Returns `true` if the first bytes of a file are those of a table: a line of three or more numbers, possibly after
/// comments and a count.
pub(crate) fn looks_like_one(start: &[u8]) -> bool {
    if start.contains(&0) {
        return false;
    }
    let text = String::from_utf8_lossy(start);
    // The last line may go on.
    let whole = text.rfind('\n').map_or(&*text, |end| &text[..end]);
    let mut lines = whole.lines().map(str::trim).filter(|line| !line.is_empty() && comment(line).is_none());
    let first = lines.next().unwrap_or_default();
    let line = if count(first).is_some() { lines.next().unwrap_or_default() } else { first };
    let fields = Delimiter::detect(line).names(line);
    // The last field of a line that goes on may be half a number.
    fields.len() >= 3 && fields.iter().take(3).all(|field| any_number(field).is_some())
}
