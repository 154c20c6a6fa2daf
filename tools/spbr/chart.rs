//! Measured values beside expected ones, as a figure and as a table.

use std::fmt::Write;
use std::path::Path;

use pellucid_engine::Result;
pub use pellucid_lab::report::plot::Axis;
use pellucid_lab::report::plot::{Figure, PANEL, Panel, Point, Series};

/// A measured value over x, and what theory expects.
pub struct Row {
    pub x: f64,
    pub found: f64,
    /// Half of the length of the error bar.
    pub spread: f64,
    pub expected: f64,
}

/// Writes `name.svg`: a panel for each title.
pub fn figure(folder: &Path, name: &str, x: Axis, y: Axis, panels: &[(String, Vec<Row>)]) -> Result<()> {
    let panel = |(title, rows): &(String, Vec<Row>)| {
        let found = |row: &Row| {
            let range_y = [row.found - row.spread, row.found + row.spread];
            Point { range_y, ..Point::new(row.x, row.found) }
        };
        // Measured points lie on top.
        let expected = rows.iter().map(|row| Point::new(row.x, row.expected));
        Panel::new(title, [Series::new(1, expected), Series::new(0, rows.iter().map(found))])
    };
    let names = vec!["measured".into(), "expected".into()];
    let (columns, panels) = (panels.len(), panels.iter().map(panel).collect());
    let figure = Figure { panel: PANEL, columns, ..Figure::in_rows(PANEL[1], names, x, y, panels) };
    let svg = figure.svg().map_err(|error| pellucid_io::output::Error::Report { reason: error.to_string() })?;
    super::write(folder, &format!("{name}.svg"), &svg)
}

/// A table of numbers as CSV.
pub fn csv(header: &str, rows: &[Vec<f64>]) -> String {
    let mut text = format!("{header}\n");
    for row in rows {
        let cells: Vec<_> = row.iter().map(f64::to_string).collect();
        // Writing to a string can't fail.
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}
