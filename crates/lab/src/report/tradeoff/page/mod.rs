//! `report.html`.

mod captions;
mod comparison;
mod convergence;
mod passes;
mod surfaces;

use maud::{Markup, PreEscaped, html};

use self::captions::{named, shown};
use self::comparison::compared;
use self::convergence::{bias, blended, convergence};
use self::passes::passes;
use self::surfaces::{about_surfaces, iterations, shaded};
use super::causes;
use super::figures::{Drawn, short};
use super::looks;
use super::pictures::Pictures;
use super::{Row, Tradeoff};
use crate::report::page::{Cell, Column, Line, digits, facts, grouped, page, script, sortable, sorting, table};
use crate::report::popping;

const MIB: f64 = (1 << 20) as f64;

const STYLE: &str = "
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 1rem; margin: 1rem 0; }
.pair figure { margin: 0; }
.stack { position: relative; --cut: 50%; background: #000; touch-action: pan-y; cursor: ew-resize; user-select: none; }
.stack.still { cursor: default; }
.stack img { display: block; width: 100%; height: auto; pointer-events: none; }
.stack img.above { position: absolute; inset: 0; clip-path: inset(0 0 0 var(--cut)); }
.edge { position: absolute; top: 0; bottom: 0; left: var(--cut); width: 2px; margin-left: -1px; background: #fff; box-shadow: 0 0 2px #000; }
.tag { position: absolute; bottom: .5rem; padding: 0 .5rem; background: #000b; color: #fff; font-size: .8rem; pointer-events: none; }
.tag.left { left: .5rem; }
.tag.right { right: .5rem; }
.slider { width: 100%; margin: .5rem 0; }
select { font: inherit; max-width: 100%; }
.crops { display: flex; flex-wrap: wrap; gap: 1rem; }
.crop { max-width: 100%; }
.crop img { display: block; max-width: 100%; height: auto; image-rendering: pixelated; background: #000; }
.crop span { font-size: .8rem; }
";

/// The whole page.
pub(super) fn html(report: &Tradeoff, figures: &[Drawn], pictures: &Pictures, crops: &looks::Crops) -> String {
    let body = html! {
        style { (PreEscaped(STYLE)) }
        p {
            @if report.surveyed.is_some() {
                "What quality costs on one scene of opaque points: the error of each method and setting against the surfaces that the "
                "points stand for, and the holes that it leaves, over the device time of a frame."
            } @else {
                "What accuracy costs on one scene: the error of each method and setting against an exact image of the same "
                "scene, over the device time of a frame."
            }
        }
        (about(report))
        h2 { "Result" }
        p {
            "The Pareto front, fastest first: no other setting is at least as fast and as accurate and better in one of "
            "the two."
        }
        (front(report))
        @if !report.findings.is_empty() {
            p { "What the paper says about these methods, and what was measured on this scene:" }
            (findings(report))
        }
        (causes::page(&report.causes))
        (looks::section(report, crops))
        h2 { "Error over time" }
        @for drawn in named(figures, &["error.svg", "flip.svg"]) { (shown(drawn, report)) }
        @if let Some(surveyed) = &report.surveyed {
            h2 { "Size of splats" }
            @for drawn in named(figures, &["size-time.svg", "size-holes.svg", "size-error.svg"]) { (shown(drawn, report)) }
            h2 { "Filters of the image" }
            (iterations(report, surveyed))
            @if let Some(found) = &report.shaded { (shaded(found)) }
        } @else {
            h2 { "Convergence" }
            @for drawn in named(figures, &["convergence.svg"]) { (shown(drawn, report)) }
            (convergence(report))
            @if let Some(analytic) = &report.analytic { (blended(report, analytic)) }
            h2 { "Bias and noise" }
            @for drawn in named(figures, &["bias.svg"]) { (shown(drawn, report)) }
            (bias(report))
        }
        @if let Some(found) = &report.popping {
            (popping::section(found, &html! {
                @for drawn in named(figures, &["popping.svg", "popping-flip.svg"]) { (shown(drawn, report)) }
            }, error))
        }
        h2 { "All settings" }
        p { "Settings on the Pareto front are marked. Click the head of a column to sort by it, and again to reverse the order; "
            "“from–to” is sorted by its width over the median. “% off” is the share of pixels with a channel off by more than 1/255." }
        (rows(report))
        h2 { "Pictures" }
        (compared(report, pictures))
        h2 { "Time of each pass" }
        (passes(report))
        h2 { "Skipped settings" }
        (skipped(report))
        h2 { "How it was measured" }
        (method(report))
        (sorting())
        @if !report.rows.is_empty() { (script(include_str!("../pictures.js"))) }
    };
    page("pellucid tradeoff", &body)
}

fn about(report: &Tradeoff) -> Markup {
    let reference = &report.reference;
    let checked = match reference.checked_pixels {
        0 => reference.method.clone(),
        pixels => format!(
            "{}; {} of its pixels, chosen at random, are within {} of the float64 reference",
            reference.method,
            grouped(pixels as u64),
            error(reference.largest_error),
        ),
    };
    let met = match &report.surveyed {
        Some(surveyed) => ("silhouette", format!("{} pixels", grouped(surveyed.silhouette))),
        None => {
            let (fragments, longest) = (grouped(report.fragments), grouped(report.max_list.into()));
            ("fragments", format!("{fragments}, at most {longest} on a pixel"))
        }
    };
    facts(&[
        ("scene", report.scene.clone()),
        ("points", grouped(report.points)),
        met,
        ("image", format!("{} × {} pixels", report.size[0], report.size[1])),
        ("reference", checked),
        ("device", report.device.clone()),
        ("driver", report.driver.clone()),
        ("pellucid", format!("{}, format {}", report.pellucid, report.version)),
        ("command", report.command.clone()),
        ("measured", sittings(report.sittings)),
    ])
}

/// The number of runs; the conditions of different runs may differ.
fn sittings(count: u32) -> String {
    if count < 2 {
        return "in one run".to_owned();
    }
    format!(
        "in {count} runs, since it was interrupted: in each run all remaining settings took turns, but a median may \
         hold frames of several runs, and two medians may hold frames of different runs"
    )
}

/// An error, with a power of ten if it is small.
pub(super) fn error(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { digits(value) } else { scientific(value) }
}

/// Two digits and a power of ten.
fn scientific(value: f64) -> String {
    format!("{value:.1e}").replace('-', "−")
}

fn front(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("setting"),
        Column::number("ms"),
        Column::number("RMSE"),
        Column::number("FLIP"),
        Column::number("largest error"),
        Column::number("% of pixels off by > 1/255"),
        Column::number("peak MiB"),
    ];
    let mut rows: Vec<&Row> = report.rows.iter().filter(|row| row.front).collect();
    rows.sort_by(|a, b| a.gpu_ms.median.total_cmp(&b.gpu_ms.median));
    let row = |row: &&Row| {
        vec![
            row.method.clone(),
            short(&row.setting),
            digits(row.gpu_ms.median),
            error(row.errors.rmse),
            error(row.errors.flip),
            error(row.errors.max),
            percent(row.errors.above_1_255),
            digits(row.peak_device_bytes as f64 / MIB),
        ]
    };
    table(&columns, &rows.iter().map(row).collect::<Vec<_>>())
}

fn findings(report: &Tradeoff) -> Markup {
    let columns = [Column::text("the paper"), Column::text("measured here"), Column::text("holds here")];
    let row = |finding: &super::Finding| {
        let holds = finding.holds.map_or("", |holds| if holds { "yes" } else { "no" });
        vec![finding.claim.clone(), finding.measured.clone(), holds.to_owned()]
    };
    let rows: Vec<_> = report.findings.iter().map(row).collect();
    html! { div.sentences { (table(&columns, &rows)) } }
}

/// A share in percent, to the thousandth.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".to_owned(),
        percent if percent < 0.001 => "< 0.001".to_owned(),
        percent => digits(percent),
    }
}

fn rows(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("setting"),
        Column::text("front"),
        Column::number("ms"),
        Column::number("from–to"),
        Column::number("wall ms"),
        Column::number("frames"),
        Column::number("seeds"),
        Column::number("peak MiB"),
        Column::number("lists MiB"),
        Column::number("RMSE"),
        Column::number("NMSE"),
        Column::number("PSNR"),
        Column::number("SSIM"),
        Column::number("FLIP"),
        Column::number("largest"),
        Column::number("% off"),
    ]
    .into_iter()
    .chain(report.surveyed.iter().flat_map(|_| [Column::number("inside"), Column::number("% holes")]));
    let columns: Vec<_> = columns.collect();
    let line = |row: &Row| {
        let ms = |value| Cell::number(value, digits);
        let small = |value| Cell::number(value, error);
        let count = |value: f64| Cell::number(value, |value| value.to_string());
        let errors = row.errors;
        let mut cells = vec![
            Cell::text(&row.method),
            Cell::text(short(&row.setting)),
            Cell::text(if row.front { "front" } else { "" }),
            ms(row.gpu_ms.median),
            // Sorted by how far times are spread.
            Cell::number((row.gpu_ms.max - row.gpu_ms.min) / row.gpu_ms.median, |_| {
                format!("{}–{}", digits(row.gpu_ms.min), digits(row.gpu_ms.max))
            }),
            ms(row.wall_ms.median),
            count(row.frames as f64),
            row.repeats.map_or(Cell::text(""), |repeats| count(repeats.seeds.into())),
            ms(row.peak_device_bytes as f64 / MIB),
            ms(row.fragment_bytes as f64 / MIB),
            small(errors.rmse),
            small(errors.nmse),
            Cell::number(errors.psnr.unwrap_or(f64::INFINITY), |db| {
                if db.is_finite() { format!("{db:.1}") } else { "∞".to_owned() }
            }),
            Cell::number(errors.ssim, |ssim| format!("{ssim:.4}")),
            small(errors.flip),
            small(errors.max),
            Cell::number(errors.above_1_255, percent),
        ];
        if report.surveyed.is_some() {
            cells.push(row.rmse_inside.map_or(Cell::text(""), small));
            cells.push(row.holes.map_or(Cell::text(""), |holes| Cell::number(holes, percent)));
        }
        Line { cells, is_marked: row.front }
    };
    let lines: Vec<_> = report.rows.iter().map(line).collect();
    html! { div #settings { (sortable(&columns, &lines)) } }
}

fn skipped(report: &Tradeoff) -> Markup {
    let columns = [Column::text("method"), Column::text("setting"), Column::text("why")];
    let row = |s: &super::Skipped| vec![s.method.clone(), short(&s.setting), s.reason.clone()];
    let rows: Vec<_> = report.skipped.iter().map(row).collect();
    let late = report.skipped.iter().filter(|skipped| skipped.for_time).count();
    html! {
        @if late > 0 { p { (left_out(late)) } }
        @if rows.is_empty() { p { "None." } } @else { (table(&columns, &rows)) }
    }
}

fn left_out(late: usize) -> String {
    let (settings, them) = if late == 1 { ("setting was", "it") } else { ("settings were", "them") };
    format!("{late} {settings} left out because of the time; more of it (--time) lets {them} in.")
}

fn method(report: &Tradeoff) -> Markup {
    html! {
        p {
            b { "Settings. " } "Each method runs along a ladder of its own. A setting named here as " code { "samples=64" }
            " is " code { "--set method.samples=64" } " for the command line."
        }
        p {
            b { "Time. " } "Device time is the sum of all passes between timestamps; wall time lasts from the first "
            "submission to the end of read-back. Frames of all settings are rendered in turns, so that a machine that slows "
            "down slows them all; those that take long are timed once, by themselves: the table says 1 frame. Medians are given, "
            "and the least and the greatest."
        }
        p {
            b { "Memory. " } "The largest number of device bytes at any time of a frame, cloud and image included, as the "
            "allocator reserves it; beside it the bytes of the lists of fragments, or of the events of soft spheres, in the largest band."
        }
        @if let Some(surveyed) = &report.surveyed { (about_surfaces(report, surveyed)) } @else {
        p {
            b { "Error. " } "Against the image of " code { (report.reference.method) } ", which leaves nothing out, and is computed in or checked against float64. On "
            "linear R, G, B, composed over the background, of all pixels. RMSE is the root of the mean squared difference; NMSE is the "
            "squared difference over the reference's squares; PSNR has a peak of 1; FLIP is in [0, 1]. The errors of "
            "stochastic methods are root mean squares (RMSE, NMSE) or means (the others) over the seeds."
        }
        p {
            b { "Bias. " } "From as many images with different seeds as the table says. The bias is the RMSE of their mean "
            "against the reference, less noise/√seeds by squares, and 0 where that is more."
        }
        }
    }
}
