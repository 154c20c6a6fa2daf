//! The map as a picture: a cell for each mean list and wanted error, colored by the fastest method.

use maud::{Markup, html};
use pellucid_session::choice::EXACT;

use crate::map::{ERRORS, fastest, verdicts};
use crate::rows::{Measured, Row, Study};

/// Width and height of a cell, in pixels.
const CELL: [usize; 2] = [86, 29];
/// Left of the cells stand the errors, above them title and means.
const LEFT: usize = 46;
const TOP: usize = 46;
/// Gap between two panels, in pixels.
const GAP: usize = 22;
/// Panels beside one another.
const COLUMNS: usize = 2;

/// Colors of methods, of Okabe and Ito's hues, light enough for dark text. The text of a cell says the same.
const COLORS: [(&str, &str); 12] = [
    ("abuffer", "#d9d9d9"),
    ("linked-list", "#c6c6c6"),
    ("sorted", "#eeeeee"),
    ("peel", "#b3b3b3"),
    ("hybrid", "#7fcdb2"),
    ("mlab", "#f3c677"),
    ("moments", "#ee9a6c"),
    ("wavelet", "#dfaac8"),
    ("stochastic", "#9fd3f2"),
    ("weighted", "#7fb8dc"),
    ("average", "#b9d6ea"),
    ("unsorted", "#cfe3f0"),
];
const OTHER: &str = "#ffffff";

/// A cell: the fastest setting, and its time over that of the fastest exact one.
struct Cell {
    row: Row,
    of_exact: f64,
}

/// A coordinate system with a row for each error and a column for each mean.
struct Panel {
    title: String,
    cells: Vec<Vec<Option<Cell>>>,
}

/// The picture of a driver: a panel for all scenes, then one for each.
pub fn svg(study: &Study) -> String {
    let targets = targets(study);
    let panels: Vec<Panel> = std::iter::once(of_all(study, &targets))
        .chain(scenes(study).iter().map(|scene| of_scene(study, scene, &targets)))
        .collect();
    let [wide, high] = [LEFT + CELL[0] * targets.len() + GAP, TOP + CELL[1] * ERRORS.len() + GAP];
    let (width, height) = (wide * COLUMNS.min(panels.len()), high * panels.len().div_ceil(COLUMNS));
    let place = |number: usize| format!("translate({} {})", number % COLUMNS * wide, number / COLUMNS * high);
    let picture = html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height) viewBox=(format!("0 0 {width} {height}"))
            font-family="sans-serif" font-size="11" text-anchor="middle" fill="#222222" {
            rect width="100%" height="100%" fill="#ffffff" {}
            @for (number, panel) in panels.iter().enumerate() {
                g transform=(place(number)) { (drawn(panel, &targets)) }
            }
        }
    };
    // One element a line, so that a change of one cell is one of a few lines.
    picture.into_string().replace("><", ">\n<") + "\n"
}

fn drawn(panel: &Panel, targets: &[u32]) -> Markup {
    let x = |column: usize| LEFT + CELL[0] * column;
    let y = |row: usize| TOP + CELL[1] * row;
    html! {
        text x=(x(0)) y="18" font-size="14" font-weight="bold" text-anchor="start" { (panel.title) }
        @for (column, target) in targets.iter().enumerate() {
            text x=(x(column) + CELL[0] / 2) y=(TOP - 6) { "mean " (target) }
        }
        @for (row, (_, name)) in ERRORS.iter().enumerate() {
            text x=(LEFT - 6) y=(y(row) + 18) text-anchor="end" { (name) }
            @for (column, cell) in panel.cells[row].iter().enumerate() {
                @if let Some(cell) = cell {
                    rect x=(x(column)) y=(y(row)) width=(CELL[0] - 2) height=(CELL[1] - 2) fill=(color(&cell.row)) {}
                    text x=(x(column) + CELL[0] / 2) y=(y(row) + 12) { (short(&cell.row)) }
                    text x=(x(column) + CELL[0] / 2) y=(y(row) + 24) font-size="10" { (format!("{:.2}", cell.of_exact)) }
                }
            }
        }
    }
}

fn color(row: &Row) -> &'static str {
    let family = row.family();
    let method = family.split(' ').next().unwrap_or_default();
    COLORS.iter().find(|(name, _)| *name == method).map_or(OTHER, |(_, color)| *color)
}

/// Method and the number of its step, as in `hybrid 8`; a star stands for another setting of it.
fn short(row: &Row) -> String {
    let (family, step) = (row.family(), row.step());
    let (method, rest) = family.split_once(' ').unwrap_or((&family, ""));
    let star = if rest.is_empty() { "" } else { "*" };
    let number = step.split_once('=').map_or("", |(_, number)| number);
    format!("{method}{star} {number}").trim_end().to_owned()
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

fn of_scene(study: &Study, scene: &str, targets: &[u32]) -> Panel {
    let cell = |error: f64, target: u32| {
        let measured = study.find(scene, target)?;
        let (row, exact) = (fastest(measured, error)?, fastest(measured, EXACT)?);
        Some(Cell { row: row.clone(), of_exact: row.ms() / exact.ms() })
    };
    Panel { title: scene.to_owned(), cells: cells(targets, cell) }
}

fn of_all(study: &Study, targets: &[u32]) -> Panel {
    let cell = |error: f64, target: u32| {
        let cases: Vec<&Measured> = study.cases.iter().filter(|measured| measured.case.target == target).collect();
        let best = verdicts(&cases, error).into_iter().next()?;
        Some(Cell { row: Row(best.key, 0.0, 0.0, 0), of_exact: best.of_exact })
    };
    Panel { title: "all scenes".to_owned(), cells: cells(targets, cell) }
}

fn cells(targets: &[u32], cell: impl Fn(f64, u32) -> Option<Cell>) -> Vec<Vec<Option<Cell>>> {
    ERRORS.iter().map(|(error, _)| targets.iter().map(|target| cell(*error, *target)).collect()).collect()
}
