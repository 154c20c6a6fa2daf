//! `report.html`.

use maud::{Markup, html};

use super::files::Report;
use super::{Cell, Slope, Workload};
use crate::report::page::{Column, digits, facts, figure, grouped, page, table};

/// Errors below are drawn at this value: an error of 0 has no place on a logarithmic axis.
pub(super) const ERROR_FLOOR: f64 = 1e-9;

const MIB: f64 = (1 << 20) as f64;

/// The whole page, with the figures by the names of their files.
pub(super) fn html(report: &Report<'_>, figures: &[(&str, String)]) -> String {
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
        h2 { "Figures" }
        @for (name, svg) in figures {
            (figure(svg, &format!("{name}: the values are those of the table of all cells"), &caption(name)))
        }
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

/// The columns of the slopes: exponent, range, share of the variance explained; empty where a series has too few cells.
fn slope_texts(slopes: &[Slope], cell: &Cell) -> [String; 3] {
    let same_series = |s: &&Slope| (s.workload, s.side, s.method) == (cell.workload, cell.side, cell.method);
    slopes.iter().find(same_series).map_or_else(Default::default, |Slope { law, layers: [from, to], .. }| {
        [format!("{:.2}", law.exponent), format!("{from}–{to}"), format!("{:.3}", law.r_squared)]
    })
}

fn summary(report: &Report<'_>) -> Markup {
    let slopes = report.sweep.slopes();
    let columns = [
        Column::text("scene"),
        Column::number("pixels"),
        Column::text("method"),
        Column::number("layers"),
        Column::number("fragments"),
        Column::number("ms"),
        Column::number("Mfragments/s"),
        Column::number("slope"),
        Column::number("over layers"),
        Column::number("R²"),
        Column::number("peak MiB"),
        Column::number("B/fragment"),
        Column::number("largest error"),
    ];
    let row = |cell: &&Cell| {
        let [slope, over, explained] = slope_texts(&slopes, cell);
        vec![
            cell.workload.name().to_owned(),
            size(cell.side),
            cell.method.to_owned(),
            cell.layers.to_string(),
            grouped(cell.fragments),
            digits(cell.gpu_ms.median),
            digits(cell.mfragments_per_s()),
            slope,
            over,
            explained,
            digits(cell.peak_device_bytes as f64 / MIB),
            digits(cell.bytes_per_fragment()),
            format!("{:.1e}", cell.error.max),
        ]
    };
    let rows: Vec<_> = report.sweep.deepest().iter().map(row).collect();
    table(&columns, &rows)
}

fn caption(name: &str) -> Markup {
    match name {
        "time.svg" => html! {
            b { "Device time of a frame. " }
            "Points are medians, bars reach from the shortest to the longest time, slopes are those of the table. The dashed line is parallel to everything that "
            "grows in proportion to the layers."
        },
        "throughput.svg" => html! {
            b { "Fragments over device time. " }
            "The line is level where each further layer costs as much as the one before; it rises where a frame's fixed cost still counts."
        },
        "memory.svg" => html! {
            b { "Largest amount of device memory at any time of a frame, " }
            "cloud and image included, as the allocator reserves it: in blocks of 8 MiB. The line is level where fragments no longer "
            "fit and the image is cut into bands."
        },
        _ => html! {
            b { "Largest difference in linear R, G, B and A from the float64 reference, " }
            "over the pixels compared. Below 10⁻⁹, equality included, it is drawn at 10⁻⁹."
        },
    }
}

/// A table of passes for each scene and size; the middle size is open.
fn passes(report: &Report<'_>) -> Markup {
    let middle = report.settings.sides[report.settings.sides.len() / 2];
    html! {
        @for (workload, side) in places(report) {
            details open[side == middle] {
                summary { (workload.name()) ", " (size(side)) " pixels" }
                @for method in &report.settings.methods {
                    (passes_of(method.name(), &report.sweep.series(workload, side, method.name())))
                }
            }
        }
    }
}

fn passes_of(method: &str, series: &[&Cell]) -> Markup {
    // The deepest cell first: it has most passes, and has them in their order.
    let mut names: Vec<&str> = Vec::new();
    for pass in series.iter().rev().flat_map(|cell| &cell.passes) {
        if !names.contains(&pass.name) {
            names.push(pass.name);
        }
    }
    let mut columns = vec![Column::text(method)];
    columns.extend(series.iter().map(|cell| Column::number(cell.layers.to_string())));
    let time = |cell: &Cell, name: &str| {
        cell.passes.iter().find(|pass| pass.name == name).map(|pass| digits(pass.gpu_ms.median)).unwrap_or_default()
    };
    let row = |name: &&str| {
        std::iter::once((*name).to_owned()).chain(series.iter().map(|cell| time(cell, name))).collect::<Vec<_>>()
    };
    let mut rows: Vec<_> = names.iter().map(row).collect();
    let sums = series.iter().map(|cell| digits(cell.gpu_ms.median));
    rows.push(std::iter::once("all passes".to_owned()).chain(sums).collect());
    table(&columns, &rows)
}

fn cells(report: &Report<'_>) -> Markup {
    let columns = [
        Column::text("scene"),
        Column::number("pixels"),
        Column::text("method"),
        Column::number("layers"),
        Column::number("points"),
        Column::number("fragments"),
        Column::number("min ms"),
        Column::number("median ms"),
        Column::number("max ms"),
        Column::number("wall ms"),
        Column::number("Mfragments/s"),
        Column::number("peak MiB"),
        Column::number("B/fragment"),
        Column::number("bands"),
        Column::number("largest error"),
        Column::number("RMSE"),
        Column::number("of pixels"),
    ];
    let row = |cell: &Cell| {
        vec![
            cell.workload.name().to_owned(),
            size(cell.side),
            cell.method.to_owned(),
            cell.layers.to_string(),
            grouped(cell.points),
            grouped(cell.fragments),
            digits(cell.gpu_ms.min),
            digits(cell.gpu_ms.median),
            digits(cell.gpu_ms.max),
            digits(cell.wall_ms.median),
            digits(cell.mfragments_per_s()),
            digits(cell.peak_device_bytes as f64 / MIB),
            digits(cell.bytes_per_fragment()),
            cell.bands.to_string(),
            format!("{:.1e}", cell.error.max),
            format!("{:.1e}", cell.error.rmse),
            cell.error.pixels.to_string(),
        ]
    };
    table(&columns, &report.sweep.cells.iter().map(row).collect::<Vec<_>>())
}

fn skipped(report: &Report<'_>) -> Markup {
    let columns = [
        Column::text("scene"),
        Column::number("pixels"),
        Column::text("method"),
        Column::number("layers"),
        Column::text("why"),
    ];
    let row = |s: &super::Skipped| {
        vec![s.workload.name().to_owned(), size(s.side), s.method.to_owned(), s.layers.to_string(), s.reason.clone()]
    };
    let rows: Vec<_> = report.sweep.skipped.iter().map(row).collect();
    html! {
        @if rows.is_empty() { p { "None." } } @else { (table(&columns, &rows)) }
    }
}

fn method(report: &Report<'_>) -> Markup {
    html! {
        p {
            b { "Scenes. " } "In " code { "stack" } " each layer is one disc over the whole image. In " code { "mosaic" }
            " each layer is tiled by discs of radius 1.7 pixels, which cover 3 × 3 pixels each, in random colors. Both have exactly as many "
            "fragments in every pixel as layers, and differ in what it takes to find them. Opacity is 1 − 2^(−1/layers), so "
            "the pile lets half of the light through: no layer is hidden, and none can be left out."
        }
        p {
            b { "Time. " } "Each method renders a scene twice before it is measured; then the methods take turns, "
            (report.settings.frames) " frames each. Device time is the sum of all passes between timestamps, wall time lasts "
            "from the first submission to the end of read-back."
        }
        p {
            b { "Memory. " } "The peak during a frame rendered with its own buffers, with nothing on the device but the cloud."
        }
        p {
            b { "Error. " } "The error is measured against the same scene in float64, computed from the equations without a device, over a "
            "random sample of 256 pixels. (In " code { "stack" } " all pixels are alike.) RMSE is over linear R, G, B."
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
