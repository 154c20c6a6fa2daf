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
        "popping.svg" | "popping-flip.svg" => popping::caption(name),
        _ => html! {
            b { "Noise and bias of stochastic methods. " }
            "Noise goes away with more images, bias stays. The floor is what noise alone leaves in the mean over the seeds: "
            "a bias below it can't be told from none. A bias below " (power(bias_floor(report)))
            ", 0 included, is drawn there."
        },
    }
}

/// Numbers of a caption: powers of ten alone are floors.
fn power(value: f64) -> Markup {
    html! { "10" sup { "−" (-value.log10().round()) } }
}
