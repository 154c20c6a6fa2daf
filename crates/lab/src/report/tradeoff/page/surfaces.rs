//! The parts of the page that are about opaque points alone.

use maud::{Markup, html};

use super::{Row, Tradeoff, error, percent};
use crate::report::page::{Column, digits, grouped, table};
use crate::report::tradeoff::figures::short;
use crate::report::tradeoff::{Shaded, ShadedStep, Surveyed};

/// The effect of more iterations on `image-space`, for each cloud.
pub(super) fn iterations(report: &Tradeoff, surveyed: &Surveyed) -> Markup {
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
pub(super) fn shaded(found: &Shaded) -> Markup {
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

/// The reference for opaque points.
pub(super) fn about_surfaces(report: &Tradeoff, surveyed: &Surveyed) -> Markup {
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
