//! `report.html`.

use maud::{Markup, html};

use super::files::Report;
use super::{Cell, Slope, Workload};
use crate::report::page::{Drawn, ReportTable, count, digits, facts, grouped, mib, page, passes as table_of};

/// The whole page.
pub(super) fn html(report: &Report<'_>, figures: &[Drawn]) -> String {
    let body = html! {
        p {
            "What layers of transparency cost: device time, memory and error of each method, over images in which every "
            "pixel holds exactly as many fragments as the horizontal axes say."
        }
        (about(report))
        h2 { "Result" }
        (summary(report))
        p {
            "Each row is the deepest cell that was measured for a scene, a size and a method. The slope is that of time "
            "over layers, both logarithmic, by least squares over the deeper half of the cells, at least three: 1 means in "
            "proportion to the layers, 2 means quadratic."
        }
        @if let Some(area) = report.sweep.area_text() { p { (area) "." } }
        h2 { "Figures" }
        @for figure in figures { (figure.html("the table of all cells")) }
        h2 { "Time of each pass" }
        p { "Median device time in ms over layers per pixel. An empty cell means that the pass did not run." }
        (passes(report))
        h2 { "All cells" }
        details { summary { (report.sweep.cells.len()) " measured cells" } (cells(report)) }
        h2 { "Skipped cells" }
        (skipped(report))
        h2 { "How it was measured" }
        (method(report))
    };
    page("pellucid stress", &body)
}

fn about(report: &Report<'_>) -> Markup {
    let Report { settings, device, command, .. } = report;
    let budget = settings.memory_budget.map_or("the device's".to_owned(), |b| bytesize::ByteSize(b).to_string());
    facts(&[
        ("device", device.name.clone()),
        ("driver", device.driver.clone()),
        ("pellucid", env!("CARGO_PKG_VERSION").to_owned()),
        ("command", (*command).to_owned()),
        ("frames behind each median", settings.frames.to_string()),
        ("limits", format!("{} fragments, {} s a frame", grouped(settings.max_fragments), settings.max_seconds)),
        ("memory budget", budget),
        ("seed", settings.seed.to_string()),
    ])
}

/// A table of cells, with the columns that all have.
fn about_cells<'a>(cells: impl IntoIterator<Item = &'a Cell>) -> ReportTable<'a, Cell> {
    ReportTable::new(cells)
        .text("scene", |cell| cell.workload.name())
        .number("pixels", |side| size(side as u32), |cell| f64::from(cell.side))
        .text("method", |cell| cell.method)
        .number("layers", count, |cell| f64::from(cell.layers))
}

/// A whole number, with thousands apart.
fn whole(value: f64) -> String {
    grouped(value as u64)
}

fn small(value: f64) -> String {
    format!("{value:.1e}")
}

fn summary(report: &Report<'_>) -> Markup {
    let slopes = report.sweep.slopes();
    // None where a series has too few cells.
    let slope = |cell: &Cell| Slope::of(&slopes, cell);
    let range = |slope: &Slope| format!("{}–{}", slope.layers[0], slope.layers[1]);
    about_cells(report.sweep.deepest())
        .number("fragments", whole, |cell| cell.fragments as f64)
        .number("ms", digits, |cell| cell.gpu_ms.median)
        .number("Mfragments/s", digits, Cell::mfragments_per_s)
        .number("slope", |exponent| format!("{exponent:.2}"), |cell| slope(cell).map(|slope| slope.law.exponent))
        .written("over layers", |cell| (f64::NAN, slope(cell).map_or_else(String::new, range)))
        .number("R²", |share| format!("{share:.3}"), |cell| slope(cell).map(|slope| slope.law.r_squared))
        .number("peak MiB", digits, |cell| mib(cell.peak_device_bytes))
        .number("B/fragment", digits, Cell::bytes_per_fragment)
        .number("largest error", small, |cell| cell.error.max)
        .text("kind", |cell| cell.expected.word())
        .written("expected", |cell| (f64::NAN, expected(cell)))
        .html()
}

/// The error that is expected of a cell, and whether it is so.
pub fn expected(cell: &Cell) -> String {
    let word = if cell.holds() == Some(false) { "no: " } else { "" };
    let found = cell.error.standard_errors.map(|found| format!("{word}{found:.2} standard errors"));
    let bound = cell.bound().map(|bound| format!("{word}at most {}", small(bound)));
    bound.or(found).unwrap_or_default()
}

/// A table of passes for each scene and size; the middle size is open.
fn passes(report: &Report<'_>) -> Markup {
    let middle = report.settings.sides[report.settings.sides.len() / 2];
    html! {
        @for (workload, side) in places(report) {
            details open[side == middle] {
                summary { (workload.name()) ", " (size(side)) " pixels" }
                @for entry in &report.settings.entries {
                    (passes_of(entry.name, &report.sweep.series(workload, side, entry.name)))
                }
            }
        }
    }
}

fn passes_of(method: &str, series: &[&Cell]) -> Markup {
    // The deepest cell first: it has most passes, and has them in their order.
    let names = series.iter().rev().flat_map(|cell| &cell.passes).map(|pass| pass.name).collect();
    let frame = |cell: &&Cell| {
        let times = cell.passes.iter().map(|pass| (pass.name, pass.gpu_ms.median)).collect();
        (cell.layers.to_string(), times, cell.gpu_ms.median)
    };
    table_of(method, names, series.iter().map(frame).collect())
}

fn cells(report: &Report<'_>) -> Markup {
    about_cells(&report.sweep.cells)
        .number("points", whole, |cell| cell.points as f64)
        .number("fragments", whole, |cell| cell.fragments as f64)
        .number("min ms", digits, |cell| cell.gpu_ms.min)
        .number("median ms", digits, |cell| cell.gpu_ms.median)
        .number("max ms", digits, |cell| cell.gpu_ms.max)
        .number("wall ms", digits, |cell| cell.wall_ms.median)
        .number("Mfragments/s", digits, Cell::mfragments_per_s)
        .number("peak MiB", digits, |cell| mib(cell.peak_device_bytes))
        .number("B/fragment", digits, Cell::bytes_per_fragment)
        .number("bands", count, |cell| cell.bands as f64)
        .number("largest error", small, |cell| cell.error.max)
        .number("RMSE", small, |cell| cell.error.rmse)
        .written("expected", |cell| (f64::NAN, expected(cell)))
        .number("of pixels", count, |cell| cell.error.pixels as f64)
        .html()
}

fn skipped(report: &Report<'_>) -> Markup {
    let table = ReportTable::new(&report.sweep.skipped)
        .text("scene", |skipped| skipped.workload.name())
        .number("pixels", |side| size(side as u32), |skipped| f64::from(skipped.side))
        .text("method", |skipped| skipped.method)
        .number("layers", count, |skipped| f64::from(skipped.layers))
        .text("why", |skipped| &skipped.reason);
    html! {
        @if report.sweep.skipped.is_empty() { p { "None." } } @else { (table.html()) }
    }
}

fn method(report: &Report<'_>) -> Markup {
    html! {
        p {
            b { "Scenes. " } "In " code { "stack" } " each layer is one disc over the whole image. In " code { "mosaic" }
            " each layer is tiled by discs of radius 1.7 pixels, which cover 3 × 3 pixels each, in random colors. Both have exactly as many "
            "fragments in every pixel as layers, and differ in what it takes to find them. Opacity is 1 − 2^(−1/layers), so "
            "the pile lets half of the light through: no layer is hidden, and none can be left out. For the soft methods the same "
            "points are spheres of the same radius, with this opacity on a ray through their center; in " code { "stack" }
            " they all intersect."
        }
        p {
            b { "Time. " } "Each method renders a scene twice before it is measured; then the methods take turns, first those of "
            "discs, then those of soft spheres, " (report.settings.frames) " frames each. Device time is the sum of all passes between timestamps, wall time lasts "
            "from the first submission to the end of read-back."
        }
        p {
            b { "Memory. " } "The peak during a frame rendered with its own buffers, with nothing on the device but the cloud."
        }
        p {
            b { "Error. " } "Every method is compared with the exact picture of what it draws: discs one behind the other, or "
            "the integrals of the soft spheres (" code { "soft-base" } "), computed in float64 from the equations without a device. "
            "Of discs a random sample of 256 pixels is compared, of soft spheres fewer where there are many layers. RMSE is over linear "
            "R, G, B. For an " b { "exact" } " method the table has the largest error that its roundings explain. The error of an "
            b { "approximate" } " one is its own, and nothing is expected of it. For a " b { "stochastic" } " one the table has the "
            "RMSE over the standard errors that the method itself states of these pixels: about 1 if both are right. “no” stands "
            "before a figure that is not as expected."
        }
        p {
            b { "Skipped. " } "Left out are cells with more fragments than the limit, methods whose frame would take longer than "
            "the limit, by a prediction from their previous two cells, and what a method refuses."
        }
    }
}

fn places(report: &Report<'_>) -> impl Iterator<Item = (Workload, u32)> {
    let sides = report.settings.sides.clone();
    Workload::ALL.into_iter().flat_map(move |workload| sides.clone().into_iter().map(move |side| (workload, side)))
}

fn size(side: u32) -> String {
    format!("{side} × {side}")
}
