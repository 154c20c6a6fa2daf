//! The figures with their captions.

use maud::{Markup, html};

use super::Tradeoff;
use crate::report::page::figure;
use crate::report::popping;
use crate::report::tradeoff::figures::{Drawn, FLIP_FLOOR, LAW_R_SQUARED, RMSE_FLOOR, bias_floor};

pub(super) fn named<'a>(figures: &'a [Drawn], names: &'a [&str]) -> impl Iterator<Item = &'a Drawn> {
    figures.iter().filter(|drawn| names.contains(&drawn.name))
}

pub(super) fn shown(drawn: &Drawn, report: &Tradeoff) -> Markup {
    let description = format!("{}: the values are those of the tables on this page", drawn.name);
    figure(&drawn.svg, &description, &caption(drawn.name, report))
}

fn caption(name: &str, report: &Tradeoff) -> Markup {
    match name {
        "error.svg" if report.surveyed.is_some() => html! {
            b { "RMSE over device time. " }
            "Lower left is better. Each cloud has a panel with its own front; the first point of a ladder names the setting that "
            "changes, the last one gives its last value. No image with one sample per pixel is as smooth at edges as the reference, so 0 is out of reach."
        },
        "flip.svg" if report.surveyed.is_some() => html! {
            b { "FLIP over device time, " }
            "which weighs differences as an eye does while the two images alternate. The fronts are those of FLIP."
        },
        "size-time.svg" => html! {
            b { "Device time over the size factor, " }
            "as in Fig. 8 of Schütz and Wimmer (2015), but with times instead of frames per second: lower is better. Size 0 draws one pixel, "
            "size 1 the radius of each point. Points of one pixel, and image-space with one iteration of its filters, have no size and are "
            "horizontal lines. Bars reach from the shortest to the longest time."
        },
        "size-holes.svg" => html! {
            b { "Holes over the size factor: " }
            "the share of the silhouette's pixels on which nothing is drawn. No holes at all appear as half a pixel, the least value."
        },
        "size-error.svg" => html! {
            b { "RMSE inside the silhouette over the size factor. " }
            "Small points leave holes, and large points hide each other; the least error lies between. This figure leaves out how far splats reach "
            "over the outline; the figures above include it."
        },
        "error.svg" => html! {
            b { "RMSE over device time. " }
            "Lower left is better. Points are medians, bars reach from the shortest to the longest time; the first point "
            "of a ladder names the setting that changes. RMSE below " (power(RMSE_FLOOR)) ", equality included, is drawn there."
        },
        "flip.svg" => html! {
            b { "FLIP over device time, " }
            "which weighs differences as an eye does while the two images alternate. The front is that of FLIP. Values "
            "below " (power(FLIP_FLOOR)) ", equality included, are drawn there."
        },
        "convergence.svg" => html! {
            b { "RMSE over the setting that changes. " }
            "Errors of independent samples fall parallel to the dashed line. A slope is given where a power law explains "
            (100.0 * LAW_R_SQUARED) " % of the variance. RMSE below " (power(RMSE_FLOOR))
            " is drawn there."
            @if report.analytic.is_some() { " The slope against alpha blending is that of settings that deal no point twice." }
        },
        "popping.svg" | "popping-flip.svg" => popping::caption(name),
        _ => html! {
            b { "Noise and bias of stochastic methods. " }
            "Noise decreases with more images, bias stays. The floor is what noise alone leaves in the mean over the seeds: "
            "a bias below it can't be distinguished from none. A bias below " (power(bias_floor(report)))
            ", 0 included, is drawn there."
        },
    }
}

/// Numbers of a caption: powers of ten alone are floors.
fn power(value: f64) -> Markup {
    html! { "10" sup { "−" (-value.log10().round()) } }
}
