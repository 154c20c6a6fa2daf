//! `report.html`.

use maud::{Markup, PreEscaped, html};

use super::figures::{Drawn, FLIP_FLOOR, LAW_R_SQUARED, RMSE_FLOOR, bias_floor, short, signed};
use super::pictures::Pictures;
use super::{Analytic, DIFFERENCE_GAIN, Row, Shaded, ShadedStep, Surveyed, Tradeoff};
use crate::report::page::{Cell, Column, Line, digits, facts, figure, grouped, page, script, sortable, sorting, table};

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
";

/// The whole page.
pub(super) fn html(report: &Tradeoff, figures: &[Drawn], pictures: &Pictures) -> String {
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
            p { "What the paper says of these methods, and what was measured on this scene:" }
            (findings(report))
        }
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
        h2 { "All settings" }
        p { "Settings on the Pareto front are marked. A click on the head of a column sorts by it, another one the other way round; "
            "“from–to” is sorted by its width over the median. “% off” are the pixels with a channel off by more than 1/255." }
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
        @if !report.rows.is_empty() { (script(include_str!("pictures.js"))) }
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
        "in {count} runs, since it was interrupted: in each of them all settings that were left took turns, but a median may \
         hold frames of several runs, and two medians frames of different ones"
    )
}

fn error(value: f64) -> String {
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
fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0".to_owned(),
        percent if percent < 0.001 => "< 0.001".to_owned(),
        percent => digits(percent),
    }
}

fn named<'a>(figures: &'a [Drawn], names: &'a [&str]) -> impl Iterator<Item = &'a Drawn> {
    figures.iter().filter(|drawn| names.contains(&drawn.name))
}

fn shown(drawn: &Drawn, report: &Tradeoff) -> Markup {
    let description = format!("{}: the values are those of the tables on this page", drawn.name);
    figure(&drawn.svg, &description, &caption(drawn.name, report))
}

/// Numbers of a caption: powers of ten alone are floors.
fn power(value: f64) -> Markup {
    html! { "10" sup { "−" (-value.log10().round()) } }
}

fn caption(name: &str, report: &Tradeoff) -> Markup {
    match name {
        "error.svg" if report.surveyed.is_some() => html! {
            b { "RMSE over device time. " }
            "Down and left is better. A panel for each cloud, each with its own front; the first point of a ladder names what is "
            "turned, the last one says how far. No image with one sample in a pixel is as smooth at edges as the reference: 0 is out of reach."
        },
        "flip.svg" if report.surveyed.is_some() => html! {
            b { "FLIP over device time, " }
            "which weighs differences as an eye does that flips between the two images. The fronts are those of FLIP."
        },
        "size-time.svg" => html! {
            b { "Device time over the size factor, " }
            "as in Fig. 8 of Schütz and Wimmer (2015), but times instead of frames per second: down is better. Size 0 draws one pixel, "
            "1 the radius that the points have. Points of one pixel, and image-space with one iteration of its filters, have no size: "
            "lines across. Bars reach from the least to the greatest time."
        },
        "size-holes.svg" => html! {
            b { "Holes over the size factor: " }
            "the share of the silhouette's pixels on which nothing is drawn. None at all is drawn at half a pixel, the least value."
        },
        "size-error.svg" => html! {
            b { "RMSE inside the silhouette over the size factor. " }
            "Too small, and there are holes; too large, and points hide each other: the least error is between. How far splats reach "
            "over the outline is left out here, and not in the figures above."
        },
        "error.svg" => html! {
            b { "RMSE over device time. " }
            "Down and left is better. Points are medians, bars reach from the least to the greatest time; the first point "
            "of a ladder names what is turned. RMSE below " (power(RMSE_FLOOR)) ", equality included, is drawn there."
        },
        "flip.svg" => html! {
            b { "FLIP over device time, " }
            "which weighs differences as an eye does that flips between the two images. The front is that of FLIP. Values "
            "below " (power(FLIP_FLOOR)) ", equality included, are drawn there."
        },
        "convergence.svg" => html! {
            b { "RMSE over what is turned. " }
            "Independent samples fall in parallel to the dashed line. Slopes are given where a power law explains "
            (100.0 * LAW_R_SQUARED) " % of the variance. RMSE below " (power(RMSE_FLOOR))
            " is drawn there."
            @if report.analytic.is_some() { " The slope against alpha blending is that of settings which deal no point twice." }
        },
        _ => html! {
            b { "Noise and bias of stochastic methods. " }
            "Noise goes away with more images, bias stays. The floor is what noise alone leaves in the mean over the seeds: "
            "a bias below it can't be told from none. A bias below " (power(bias_floor(report)))
            ", 0 included, is drawn there."
        },
    }
}

/// The effect of more iterations on `image-space`, for each cloud.
fn iterations(report: &Tradeoff, surveyed: &Surveyed) -> Markup {
    let columns = [
        Column::text("points"),
        Column::text("setting"),
        Column::number("ms"),
        Column::number("RMSE"),
        Column::number("inside"),
        Column::number("% holes"),
    ];
    let points = |row: &Row| {
        let cloud = surveyed.clouds.iter().find(|(thinning, _)| *thinning == row.thinning);
        cloud.map_or_else(String::new, |(_, points)| grouped(*points))
    };
    let line = |row: &Row| {
        let inside = row.rmse_inside.map_or_else(String::new, error);
        let holes = row.holes.map_or_else(String::new, percent);
        let numbers = [digits(row.gpu_ms.median), error(row.errors.rmse), inside, holes];
        [vec![points(row), short(&row.setting)], numbers.to_vec()].concat()
    };
    let rows: Vec<_> = report.rows.iter().filter(|row| row.method == "image-space").map(line).collect();
    html! {
        @if rows.is_empty() { p { "The method image-space was not measured." } } @else {
            p {
                "Points of one pixel whose holes are filled afterwards: an iteration fills holes one pixel farther from their rim, and "
                "takes the same time whatever the points are."
            }
            (table(&columns, &rows))
        }
    }
}

/// Soft shadows of more and fewer samples.
fn shaded(found: &Shaded) -> Markup {
    let columns = [
        Column::number("samples of the light"),
        Column::number("ms"),
        Column::number("from–to"),
        Column::number("RMSE"),
        Column::number("RMSE · √samples"),
    ];
    let row = |step: &ShadedStep| {
        let scaled = step.rmse * f64::from(step.samples).sqrt();
        let range = format!("{}–{}", digits(step.ms.min), digits(step.ms.max));
        vec![step.samples.to_string(), digits(step.ms.median), range, error(step.rmse), error(scaled)]
    };
    html! {
        h2 { "Shadows" }
        p {
            "With " code { (found.method) } ", against an image with " (found.reference_samples) " samples. The time is that of the passes "
            "that find the shadows, which a cloud keeps as long as light and points stay."
        }
        (table(&columns, &found.steps.iter().map(row).collect::<Vec<_>>()))
    }
}

fn convergence(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("over"),
        Column::number("slope of RMSE"),
        Column::number("R²"),
        Column::number("slope of RMSE over time"),
        Column::number("R²"),
        Column::number("settings"),
    ];
    let row = |c: &super::Convergence| {
        vec![
            c.method.clone(),
            c.key.clone(),
            signed(c.rmse.exponent, 3),
            format!("{:.3}", c.rmse.r_squared),
            signed(c.over_time.exponent, 3),
            format!("{:.3}", c.over_time.r_squared),
            c.rows.to_string(),
        ]
    };
    let rows: Vec<_> = report.convergence.iter().map(row).collect();
    html! {
        @if rows.is_empty() { p { "No method has three settings on a ladder." } } @else {
            p {
                "Slopes of RMSE, both axes logarithmic, by least squares: −0.5 is what independent samples give. A law "
                "with R² far from 1 is none."
            }
            (table(&columns, &rows))
        }
    }
}

/// Errors against alpha blending of planes.
fn blended(report: &Tradeoff, analytic: &Analytic) -> Markup {
    let columns = [
        Column::text("setting"),
        Column::number("ms"),
        Column::number("RMSE against the reference"),
        Column::number("against alpha blending"),
        Column::number("expected"),
    ];
    let row = |row: &Row| {
        let (_, count) = row.step.as_ref()?;
        let numbers = [digits(row.gpu_ms.median), error(row.errors.rmse), error(row.rmse_analytic?)];
        Some([vec![short(&row.setting)], numbers.to_vec(), vec![error(analytic.expected(*count))]].concat())
    };
    let list = |values: &[f64]| values.iter().map(|value| digits(*value)).collect::<Vec<_>>().join(", ");
    html! {
        h3 { "Against alpha blending" }
        p {
            "This scene is planes that fill the image, of opacity " (list(&analytic.opacities)) " (the nearest first) and "
            (list(&analytic.points_per_pixel)) " points on a pixel, so that its image is known: one color. Up to "
            (digits(analytic.dealt_once)) " ensembles no point is dealt twice, and the error falls as 1/√ensembles"
            @if let Some(law) = analytic.slope { " (slope " (signed(law.exponent, 3)) " as measured)" }
            ". Beyond, what is left is the chance of how many points are on a pixel: " (error(analytic.floor))
            " is the error of the reference itself, " (error(analytic.expected_floor)) " the one expected."
        }
        (table(&columns, &report.rows.iter().filter_map(row).collect::<Vec<_>>()))
    }
}

fn bias(report: &Tradeoff) -> Markup {
    let columns = [
        Column::text("method"),
        Column::text("setting"),
        Column::number("seeds"),
        Column::number("RMSE"),
        Column::number("noise"),
        Column::number("bias"),
        Column::number("floor of the bias"),
        Column::text("bias seen"),
    ];
    let line = |row: &Row| {
        let repeats = row.repeats?;
        let number = |value| Cell::number(value, error);
        let cells = vec![
            Cell::text(&row.method),
            Cell::text(short(&row.setting)),
            Cell::number(repeats.seeds.into(), |seeds| seeds.to_string()),
            number(row.errors.rmse),
            number(repeats.noise),
            number(repeats.bias),
            number(repeats.bias_floor),
            Cell::text(if repeats.bias > repeats.bias_floor { "yes" } else { "no" }),
        ];
        Some(Line { cells, is_marked: false })
    };
    let lines: Vec<_> = report.rows.iter().filter_map(line).collect();
    html! {
        @if lines.is_empty() { p { "No method among those measured depends on a seed." } } @else {
            p {
                "Images with different seeds, their mean, and the reference: noise is the RMSE of one image against the "
                "mean, bias that of the mean against the reference, less what noise leaves in it."
            }
            (sortable(&columns, &lines))
        }
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

/// Method and setting, as one would say it.
fn name(row: &Row) -> String {
    format!("{} {}", row.method, short(&row.setting)).trim_end().to_owned()
}

fn about_row(row: &Row) -> String {
    let Row { errors, gpu_ms, .. } = row;
    format!(
        "{}: RMSE {}, FLIP {}, largest error {}, {} ms; full size in {} and {}",
        name(row),
        error(errors.rmse),
        error(errors.flip),
        error(errors.max),
        digits(gpu_ms.median),
        row.picture,
        row.difference,
    )
}

/// The picture of a row over the reference, and the difference. The row with the median error is chosen at first, and
/// stays where no script runs.
fn compared(report: &Tradeoff, pictures: &Pictures) -> Markup {
    let mut by_error: Vec<usize> = (0..report.rows.len()).collect();
    by_error.sort_by(|a, b| report.rows[*a].errors.rmse.total_cmp(&report.rows[*b].errors.rmse));
    let Some(&chosen) = by_error.get(by_error.len() / 2) else {
        return html! { p { "No setting was measured." } };
    };
    let [picture, difference] = pictures.rows[chosen];
    let [width, height] = pictures.size;
    let mut kinds: [Vec<usize>; 2] = std::array::from_fn(|kind| pictures.rows.iter().map(|row| row[kind]).collect());
    for kind in &mut kinds {
        kind.sort_unstable();
        kind.dedup();
    }
    let scale = match pictures.factor {
        1 => html! { "Pictures are shown with all their pixels." },
        n => html! {
            "Pictures are reduced to " (width) " × " (height) ": a pixel here is the mean of " (n) " × " (n)
            " pixels, in linear light, and in the differences the greatest of them, so that none is lost. The files beside this page "
            "have all pixels."
        },
    };
    html! {
        p { (scale) }
        p { label for="setting" { "Setting " } (choices(report, pictures, chosen)) }
        p #chosen aria-live="polite" { (about_row(&report.rows[chosen])) }
        div.pair {
            figure {
                div.stack #over {
                    img src=(pictures.uris[pictures.reference]) width=(width) height=(height) alt="the reference";
                    @for index in &kinds[0] {
                        img.above data-picture=(index) hidden[*index != picture] src=(pictures.uris[*index])
                            width=(width) height=(height) alt="the setting's picture, right of the cut";
                    }
                    span.edge {}
                    span.tag.left { "reference" }
                    span.tag.right { "setting" }
                }
                input.slider #cut type="range" min="0" max="100" step="any" value="50"
                    aria-label="where the reference ends and the setting's picture begins, in percent of the width";
                figcaption { b { "The reference, left, and the setting, right. " } "The slider moves the cut between them." }
            }
            figure {
                div.stack.still {
                    @for index in &kinds[1] {
                        img data-difference=(index) hidden[*index != difference] src=(pictures.uris[*index])
                            width=(width) height=(height) alt="the setting's difference from the reference";
                    }
                }
                figcaption { b { "Their absolute difference, " } (DIFFERENCE_GAIN) " times as bright." }
            }
        }
    }
}

fn choices(report: &Tradeoff, pictures: &Pictures, chosen: usize) -> Markup {
    html! {
        select #setting {
            @for (index, (row, [picture, difference])) in report.rows.iter().zip(&pictures.rows).enumerate() {
                option data-picture=(picture) data-difference=(difference) data-facts=(about_row(row))
                    selected[index == chosen] {
                    (name(row)) " — RMSE " (error(row.errors.rmse)) ", " (digits(row.gpu_ms.median)) " ms"
                }
            }
        }
    }
}

/// A table of passes for each method.
fn passes(report: &Tradeoff) -> Markup {
    let mut methods: Vec<&str> = report.rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    html! {
        p { "Median device time in ms; empty: the pass did not run." }
        @for method in methods {
            @let rows: Vec<&Row> = report.rows.iter().filter(|row| row.method == method).collect();
            details { summary { (method) } (passes_of(&rows)) }
        }
    }
}

fn passes_of(rows: &[&Row]) -> Markup {
    // The longest list first: most of the others' passes are in it, and in their order.
    let mut by_length = rows.to_vec();
    by_length.sort_by_key(|row| std::cmp::Reverse(row.passes.len()));
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in by_length.iter().flat_map(|row| &row.passes) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let heads = rows.iter().map(|row| if row.setting.is_empty() { "defaults".to_owned() } else { short(&row.setting) });
    let mut columns = vec![Column::text("pass")];
    columns.extend(heads.map(Column::number));
    let time = |row: &Row, name: &str| row.passes.iter().find(|(pass, _)| pass == name).map(|(_, ms)| digits(*ms));
    let line = |name: &&str| {
        let times = rows.iter().map(|row| time(row, name).unwrap_or_default());
        std::iter::once((*name).to_owned()).chain(times).collect::<Vec<_>>()
    };
    let mut lines: Vec<_> = names.iter().map(line).collect();
    let sums = rows.iter().map(|row| digits(row.gpu_ms.median));
    lines.push(std::iter::once("all passes".to_owned()).chain(sums).collect());
    table(&columns, &lines)
}

fn skipped(report: &Tradeoff) -> Markup {
    let columns = [Column::text("method"), Column::text("setting"), Column::text("why")];
    let row = |s: &super::Skipped| vec![s.method.clone(), short(&s.setting), s.reason.clone()];
    let rows: Vec<_> = report.skipped.iter().map(row).collect();
    html! { @if rows.is_empty() { p { "None." } } @else { (table(&columns, &rows)) } }
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

/// The reference for opaque points.
fn about_surfaces(report: &Tradeoff, surveyed: &Surveyed) -> Markup {
    let across = surveyed.samples_across;
    html! {
        p {
            b { "Points. " } "All of them, and one of each " code { "thinning" } " by chance, which is no key of a scene file: a thinner "
            "cloud is part of the denser ones. Its radii are larger by √thinning, as the distance between neighbors on a surface is."
        }
        p {
            b { "Error. " } "Against " code { (report.reference.method) } ", as near to the surfaces as the points come: the mean of "
            (across) " × " (across) " samples in a pixel, of splats of size 1. The images have one sample in a pixel, and edges that show it: "
            "0 is out of reach. On linear R, G, B, composed over the background, of all pixels. RMSE is the root of the mean squared "
            "difference; NMSE is the squared difference over the reference's squares; PSNR has a peak of 1; FLIP is in [0, 1]."
        }
        p {
            b { "Holes. " } "The silhouette are the " (grouped(surveyed.silhouette)) " pixels of which the reference covers all samples, and "
            "those of the eight pixels around. A pixel of it on which nothing is drawn is a hole. Where a farther surface shows through, there "
            "is none by that count; the error tells. “Inside” is the RMSE of the silhouette's pixels."
        }
    }
}
