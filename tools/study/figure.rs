//! The map as a figure: mean list × wanted error, a marker for the fastest method.

use std::collections::BTreeMap;

use pellucid_engine::output::Error;
use pellucid_lab::choice::EXACT;
use pellucid_lab::report::plot::{Axis, Figure, Panel, Point, Series, Steps};

use crate::map::{ERRORS, fastest, verdicts};
use crate::rows::{Measured, Study};

/// Width and height of a panel in pixels.
const PANEL: [u32; 2] = [330, 270];
/// Where exact images are drawn.
const EXACT_AT: f64 = 1e-5;

/// A cell of the map: mean list, wanted error, the fastest method, its time over that of the fastest exact setting.
struct Cell {
    mean: f64,
    error: f64,
    family: String,
    of_exact: f64,
}

/// The figure of a driver: a panel for all scenes, then one for each.
///
/// # Errors
/// It can't be drawn.
pub fn svg(study: &Study) -> Result<String, Error> {
    let mut panels = vec![("all scenes".to_owned(), of_all(study))];
    for scene in scenes(study) {
        let cases = study.cases.iter().filter(|measured| measured.case.scene == scene);
        panels.push((scene.clone(), cases.flat_map(of_case).collect()));
    }
    let names = by_frequency(panels.iter().flat_map(|(_, cells)| cells));
    let panel = |(title, cells): &(String, Vec<Cell>)| Panel {
        title: title.clone(),
        series: cells.iter().map(|cell| series(&names, cell)).collect(),
        front: Vec::new(),
        is_guided: false,
    };
    let figure = Figure {
        x: Axis { label: "mean list", floor: 1.0, steps: Steps::Tens },
        y: Axis { label: "largest RMSE (1e-5: exact)", floor: EXACT_AT, steps: Steps::Tens },
        panels: panels.iter().map(panel).collect(),
        names,
        guide: None,
        front: "",
        panel: PANEL,
        columns: 2,
    };
    figure.svg().map_err(|error| Error::Report { reason: error.to_string() })
}

/// The scenes of a study, in the order of its file.
pub fn scenes(study: &Study) -> Vec<String> {
    let mut scenes: Vec<String> = Vec::new();
    for measured in &study.cases {
        if !scenes.contains(&measured.case.scene) {
            scenes.push(measured.case.scene.clone());
        }
    }
    scenes
}

/// The wanted means of a study, ascending.
pub fn targets(study: &Study) -> Vec<u32> {
    let mut targets: Vec<u32> = study.cases.iter().map(|measured| measured.case.target).collect();
    targets.sort_unstable();
    targets.dedup();
    targets
}

/// A marker of its own: markers of one method are not joined by a line.
fn series(names: &[String], cell: &Cell) -> Series {
    let point = Point { label: format!("{:.2}", cell.of_exact), ..Point::new(cell.mean, cell.error) };
    let name = names.iter().position(|name| *name == cell.family).unwrap_or_default();
    Series { name, points: vec![point], note: String::new() }
}

fn at(error: f64) -> f64 {
    if error <= EXACT { EXACT_AT } else { error }
}

fn of_case(measured: &Measured) -> Vec<Cell> {
    let Some(exact) = fastest(measured, EXACT) else { return Vec::new() };
    let cell = |(error, _): &(f64, &str)| {
        let row = fastest(measured, *error)?;
        let (mean, family) = (measured.case.mean, row.family());
        Some(Cell { mean, error: at(*error), family, of_exact: row.ms() / exact.ms() })
    };
    ERRORS.iter().filter_map(cell).collect()
}

fn of_all(study: &Study) -> Vec<Cell> {
    let mut cells = Vec::new();
    for target in targets(study) {
        let cases: Vec<&Measured> = study.cases.iter().filter(|measured| measured.case.target == target).collect();
        for (error, _) in ERRORS {
            if let Some(best) = verdicts(&cases, error).into_iter().next() {
                let (mean, error) = (target.into(), at(error));
                cells.push(Cell { mean, error, family: best.family, of_exact: best.of_exact });
            }
        }
    }
    cells
}

/// The methods of cells, the most frequent first, so that they have the colors that differ most.
fn by_frequency<'a>(cells: impl Iterator<Item = &'a Cell>) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for cell in cells {
        *counts.entry(&cell.family).or_default() += 1;
    }
    let mut names: Vec<(&str, usize)> = counts.into_iter().collect();
    names.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    names.into_iter().map(|(name, _)| name.to_owned()).collect()
}
