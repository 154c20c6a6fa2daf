//! Measured values beside expected ones, as a figure and as a table.

use std::fmt::Write;
use std::path::Path;

use pellucid_engine::Result;
use pellucid_lab::report::plot::{Axis, Figure, PANEL, Panel, Point, Series, Steps};

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
        let series = [
            Series {
                name: 1,
                points: rows.iter().map(|row| Point::new(row.x, row.expected)).collect(),
                note: String::new(),
            },
            Series { name: 0, points: rows.iter().map(found).collect(), note: String::new() },
        ];
        Panel { title: title.clone(), series: series.into(), front: Vec::new(), is_guided: false }
    };
    let figure = Figure {
        x,
        y,
        names: vec!["measured".into(), "expected".into()],
        guide: None,
        front: "",
        panel: PANEL,
        columns: panels.len(),
        panels: panels.iter().map(panel).collect(),
    };
    let svg = figure.svg().map_err(|error| pellucid_engine::output::Error::Report { reason: error.to_string() })?;
    super::write(folder, &format!("{name}.svg"), &svg)
}

/// An axis in even steps.
pub fn even(label: &'static str) -> Axis {
    Axis { label, floor: 0.0, steps: Steps::Even }
}

/// A logarithmic axis.
pub fn tens(label: &'static str, floor: f64) -> Axis {
    Axis { label, floor, steps: Steps::Tens }
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
