//! PTX files (Leica Cyclone): scans as grids, each with its position.
//!
//! A scan begins with columns and rows of its grid, four lines of three numbers (the scanner's position and axes, which
//! the matrix repeats) and four lines of a matrix that maps row vectors to the common coordinates: (x y z 1) · M. Then
//! each cell has x y z, or 0 0 0 for cells without a return; and intensity, color, or both.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use pellucid_core::progress::Progress;

use super::lines::{Fields, Lines};
use super::names::{ColumnNames, UsedColumns, of_scanners};
use super::table::LEAST_LINE;
use crate::columns::Columns;
use crate::grid::{Elevations, the_only};
use crate::{Error, InputFile, PROGRESS_STEP};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::sensor::Sensor;

/// The values of a row, common to all scans; missing ones are NaN.
const ALL: usize = 7;

/// Reads all scans of a file as one cloud.
pub(super) fn read(source: &mut InputFile, given: Option<&ColumnNames>, progress: &Progress) -> Result<Cloud, Error> {
    let mut lines = Lines::new(source);
    let names = given.map_or_else(|| of_scanners(ALL).unwrap_or_default(), |given| given.as_slice().to_vec());
    let UsedColumns { columns, at } = UsedColumns::from_names(&names);
    let position = ["x", "y", "z"].map(|name| columns.iter().position(|column| column.name.eq_ignore_ascii_case(name)));
    let [Some(x), Some(y), Some(z)] = position else { return Ok(Cloud::default()) };
    let mut table = Columns::new(&columns)
        .map_err(|missing| lines.source.malformed("columns", format!("no column `{missing}`")))?;
    let (mut line, mut values, mut row) = (String::new(), Vec::new(), Vec::new());
    let (mut total, mut sensors) = (0, Vec::new());
    while lines.next(&mut line)? {
        let scan = Scan::read(&mut lines, &mut line)?;
        total += scan.cells;
        progress.set_length(total);
        let (mut layout, mut elevations) = (None, Elevations::default());
        for index in 0..scan.cells {
            if !lines.next(&mut line)? {
                let what = format!(
                    "the file ends after {index} of the {} points of the scan at line {}",
                    scan.cells, scan.line
                );
                return Err(lines.source.truncated(what));
            }
            let (fields, wanted) = match &mut layout {
                Some(layout) => layout,
                None => layout.insert(first(&lines, &line, given)?),
            };
            fields.row(&line, *wanted, &mut values).map_err(|fault| lines.wrong(fault))?;
            row.clear();
            if given.is_some() {
                row.extend(at.iter().map(|&at| values[at]));
            } else {
                spread(&values, &mut row);
            }
            let point = DVec3::new(row[x], row[y], row[z]);
            elevations.add(index % scan.rows.max(1), point);
            let place = scan.place(point);
            (row[x], row[y], row[z]) = place.into();
            table.push(&row);
            if (index + 1).is_multiple_of(PROGRESS_STEP) {
                progress.inc(PROGRESS_STEP);
            }
        }
        sensors.push(scan.sensor().filter(|_| elevations.follow_rows()));
    }
    let cloud = without_blank_intensity(table.finish());
    Ok(Cloud { sensor: the_only(&sensors), ..cloud })
}

/// Drops the intensity if no scan has it.
fn without_blank_intensity(mut cloud: Cloud) -> Cloud {
    cloud.intensity = cloud.intensity.filter(|values| values.iter().any(|value| !value.is_nan()));
    for value in cloud.intensity.iter_mut().flatten().filter(|value| value.is_nan()) {
        *value = 0.0;
    }
    cloud
}

/// The fields of lines like the first one, and how many: as many as are named, or as a scanner writes.
fn first(lines: &Lines, line: &str, given: Option<&ColumnNames>) -> Result<(Fields, usize), Error> {
    if let Some(given) = given {
        return Ok((Fields::detect(line, given.skipped()), given.as_slice().len()));
    }
    let (mut fields, mut values) = (Fields::detect(line, vec![]), Vec::new());
    fields.numbers(line, &mut values).map_err(|fault| lines.wrong(fault))?;
    if of_scanners(values.len()).is_some() {
        return Ok((fields, values.len()));
    }
    let expected = "x y z, then intensity, r g b, or both";
    Err(lines.malformed(format!("{} values (expected {expected}); --columns names them", values.len())))
}

/// Puts the values of a line where a row with intensity and color has them.
fn spread(values: &[f64], row: &mut Vec<f64>) {
    row.resize(ALL, f64::NAN);
    row[..3].copy_from_slice(&values[..3]);
    match &values[3..] {
        [intensity] => row[3] = *intensity,
        [intensity, color @ ..] if color.len() == 3 => {
            row[3] = *intensity;
            row[4..].copy_from_slice(color);
        }
        color if color.len() == 3 => row[4..].copy_from_slice(color),
        _ => {}
    }
}

/// The head of a scan.
struct Scan {
    /// The line that it starts at.
    line: u64,
    cells: u64,
    /// Cells of a column, from the bottom to the top.
    rows: u64,
    /// Takes column vectors to the common coordinates.
    matrix: DMat4,
}

impl Scan {
    /// Reads the head of a scan; `line` holds its first line.
    fn read(lines: &mut Lines, line: &mut String) -> Result<Self, Error> {
        let start = lines.number;
        let columns = size(lines, line, "columns")?;
        next(lines, line)?;
        let rows = size(lines, line, "rows")?;
        for _ in 0..4 {
            next(lines, line)?;
            numbers::<3>(lines, line)?;
        }
        let mut axes = [DVec4::ZERO; 4];
        for axis in &mut axes {
            next(lines, line)?;
            *axis = numbers::<4>(lines, line)?.into();
        }
        let left = lines.source.len.saturating_sub(lines.read) + 1;
        let cells = columns.checked_mul(rows).filter(|&cells| cells <= left / LEAST_LINE).ok_or_else(|| {
            lines.source.truncated(format!(
                "line {start} announces {columns} × {rows} points, but the {} bytes after its header hold at most {}",
                left - 1,
                left / LEAST_LINE
            ))
        })?;
        let [a, b, c, d] = axes;
        // The lines are rows of a matrix for row vectors: columns of one for column vectors.
        Ok(Self { line: start, cells, rows, matrix: DMat4::from_cols(a, b, c, d) })
    }

    /// Returns the scanner in the common coordinates; `None` if the matrix is no pose.
    fn sensor(&self) -> Option<Sensor> {
        let axes = DMat3::from_mat4(self.matrix);
        let [x, z] = [axes.x_axis.try_normalize()?, axes.z_axis.try_normalize()?];
        let y = z.cross(x).try_normalize()?;
        let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
        let position = self.matrix.w_axis.truncate();
        (position.is_finite() && rotation.is_finite()).then(|| Sensor::laser(position, rotation))
    }

    /// A point in the common coordinates; NaN where nothing came back.
    fn place(&self, point: DVec3) -> DVec3 {
        if point == DVec3::ZERO { DVec3::NAN } else { self.matrix.transform_point3(point) }
    }
}

fn next(lines: &mut Lines, line: &mut String) -> Result<(), Error> {
    if lines.next(line)? {
        return Ok(());
    }
    Err(lines.source.truncated(format!("the file ends at line {} within the header of a scan", lines.number)))
}

fn size(lines: &Lines, line: &str, what: &str) -> Result<u64, Error> {
    let shown = || line.chars().take(40).collect::<String>();
    line.parse().map_err(|_| lines.malformed(format!("expected the number of {what} of a scan, found `{}`", shown())))
}

fn numbers<const N: usize>(lines: &Lines, line: &str) -> Result<[f64; N], Error> {
    let mut row = Vec::new();
    Fields::detect(line, vec![]).row(line, N, &mut row).map_err(|fault| lines.wrong(fault))?;
    row.try_into().map_err(|_| lines.malformed(format!("expected {N} values")))
}
