//! `report.html`.

mod comparison;
mod convergence;
mod surfaces;

use std::cmp::Reverse;

use maud::{Markup, PreEscaped, html};

use self::comparison::compared;
use self::convergence::{bias, blended, convergence};
use self::surfaces::{about_surfaces, iterations, shaded};
use super::figures::short;
use super::pictures::Pictures;
use super::{PixelArea, Row, Tradeoff, causes, looks};
use crate::report::page::{
    Drawn, ReportTable, count, digits, facts, grouped, mib, page, passes as table_of, script, sorting,
};
use crate::report::popping;

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
    let shown = |names: &[&str]| {
        html! {
            @for drawn in figures.iter().filter(|drawn| names.contains(&drawn.name)) {
                (drawn.html("the tables on this page"))
            }
        }
    };
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
            @if let Some(area) = &report.area { " Beside the errors of methods stands that of the samples (" (area.text()) ")." }
        }
        (front(report))
        @if !report.findings.is_empty() {
            p { "What the paper says about these methods, and what was measured on this scene:" }
            (findings(report))
        }
        (causes::page(&report.causes))
        (looks::section(report, crops))
        h2 { "Error over time" }
        (shown(&["error.svg", "flip.svg"]))
        @if let Some(surveyed) = &report.surveyed {
            h2 { "Size of splats" }
            (shown(&["size-time.svg", "size-holes.svg", "size-error.svg"]))
            h2 { "Filters of the image" }
            (iterations(report, surveyed))
            @if let Some(found) = &report.shaded { (shaded(found)) }
        } @else {
            h2 { "Convergence" }
            (shown(&["convergence.svg"]))
            (convergence(report))
            @if let Some(analytic) = &report.analytic { (blended(report, analytic)) }
            h2 { "Bias and noise" }
            (shown(&["bias.svg"]))
            (bias(report))
        }
        @if let Some(found) = &report.popping {
            (popping::section(found, &shown(&["popping.svg", "popping-flip.svg"]), error))
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
        ("sampling error", report.area.as_ref().map_or_else(|| no_area(report), PixelArea::text)),
        ("device", report.device.clone()),
        ("driver", report.driver.clone()),
        ("pellucid", format!("{}, format {}", report.pellucid, report.version)),
        ("command", report.command.clone()),
        ("measured", sittings(report.sittings)),
    ])
}

/// The reason why no sampling error is stated.
fn no_area(report: &Tradeoff) -> String {
    let surveyed = report.surveyed.is_some();
    let why = if surveyed { "the reference has many samples in a pixel" } else { "not measured" };
    format!("pixel area: {why}")
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

/// An error; a small one has two digits and a power of ten.
pub(super) fn error(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { digits(value) } else { format!("{value:.1e}").replace('-', "−") }
}

fn front(report: &Tradeoff) -> Markup {
    let mut rows: Vec<&Row> = report.rows.iter().filter(|row| row.front).collect();
    rows.sort_by(|a, b| a.gpu_ms.median.total_cmp(&b.gpu_ms.median));
    ReportTable::new(rows)
        .text("method", |row| &row.method)
        .text("setting", |row| short(&row.setting))
        .number("ms", digits, |row| row.gpu_ms.median)
        .number("RMSE", error, |row| row.errors.rmse)
        .number("FLIP", error, |row| row.errors.flip)
        .number("largest error", error, |row| row.errors.max)
        .number("% of pixels off by > 1/255", percent, |row| row.errors.above_1_255)
        .number("peak MiB", digits, |row| mib(row.peak_device_bytes))
        .html()
}

fn findings(report: &Tradeoff) -> Markup {
    let table = ReportTable::new(&report.findings)
        .text("the paper", |finding| &finding.claim)
        .text("measured here", |finding| &finding.measured)
        .text("holds here", |finding| finding.holds.map_or("", |holds| if holds { "yes" } else { "no" }));
    html! { div.sentences { (table.html()) } }
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
    let decibels = |db: f64| if db.is_finite() { format!("{db:.1}") } else { "∞".to_owned() };
    let range = |row: &Row| format!("{}–{}", digits(row.gpu_ms.min), digits(row.gpu_ms.max));
    let mut table = ReportTable::new(&report.rows)
        .text("method", |row| &row.method)
        .text("setting", |row| short(&row.setting))
        .text("front", |row| if row.front { "front" } else { "" })
        .number("ms", digits, |row| row.gpu_ms.median)
        // Sorted by how far times are spread.
        .written("from–to", |row| ((row.gpu_ms.max - row.gpu_ms.min) / row.gpu_ms.median, range(row)))
        .number("wall ms", digits, |row| row.wall_ms.median)
        .number("frames", count, |row| row.frames as f64)
        .number("seeds", count, |row| row.repeats.map(|repeats| f64::from(repeats.seeds)))
        .number("peak MiB", digits, |row| mib(row.peak_device_bytes))
        .number("lists MiB", digits, |row| mib(row.fragment_bytes))
        .number("RMSE", error, |row| row.errors.rmse)
        .number("NMSE", error, |row| row.errors.nmse)
        .number("PSNR", decibels, |row| row.errors.psnr.unwrap_or(f64::INFINITY))
        .number("SSIM", |ssim| format!("{ssim:.4}"), |row| row.errors.ssim)
        .number("FLIP", error, |row| row.errors.flip)
        .number("largest", error, |row| row.errors.max)
        .number("% off", percent, |row| row.errors.above_1_255);
    if report.surveyed.is_some() {
        table = table.number("inside", error, |row| row.rmse_inside).number("% holes", percent, |row| row.holes);
    }
    html! { div #settings { (table.sortable(|row| row.front)) } }
}

fn skipped(report: &Tradeoff) -> Markup {
    let table = ReportTable::new(&report.skipped)
        .text("method", |skipped| &skipped.method)
        .text("setting", |skipped| short(&skipped.setting))
        .text("why", |skipped| &skipped.reason);
    let late = report.skipped.iter().filter(|skipped| skipped.for_time).count();
    html! {
        @if late > 0 { p { (left_out(late)) } }
        @if report.skipped.is_empty() { p { "None." } } @else { (table.html()) }
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

/// A table of passes for each method.
fn passes(report: &Tradeoff) -> Markup {
    let mut methods: Vec<&str> = report.rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    html! {
        p { "Median device time in ms. An empty cell means that the pass did not run." }
        @for method in methods {
            @let rows: Vec<&Row> = report.rows.iter().filter(|row| row.method == method).collect();
            details { summary { (method) } (passes_of(&rows)) }
        }
    }
}

fn passes_of<'a>(rows: &[&'a Row]) -> Markup {
    // The longest list first: most of the others' passes are in it, and in their order.
    let mut by_length = rows.to_vec();
    by_length.sort_by_key(|row| Reverse(row.passes.len()));
    let names = by_length.iter().flat_map(|row| &row.passes).map(|(name, _)| name.as_str()).collect();
    let frame = |row: &&'a Row| {
        let head = if row.setting.is_empty() { "defaults".to_owned() } else { short(&row.setting) };
        (head, row.passes.iter().map(|(name, ms)| (name.as_str(), *ms)).collect(), row.gpu_ms.median)
    };
    table_of("pass", names, rows.iter().map(frame).collect())
}
