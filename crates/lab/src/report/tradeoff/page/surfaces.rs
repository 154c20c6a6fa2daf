//! The parts of the page that are about opaque points alone.

use maud::{Markup, html};

use super::{Row, Tradeoff, error, percent};
use crate::report::page::{ReportTable, count, digits, grouped};
use crate::report::tradeoff::figures::short;
use crate::report::tradeoff::{Shaded, Surveyed};

/// The effect of more iterations on `image-space`, for each cloud.
pub(super) fn iterations(report: &Tradeoff, surveyed: &Surveyed) -> Markup {
    let points = |row: &Row| {
        let cloud = surveyed.clouds.iter().find(|(thinning, _)| *thinning == row.thinning);
        cloud.map_or_else(String::new, |(_, points)| grouped(*points))
    };
    let rows: Vec<&Row> = report.rows.iter().filter(|row| row.method == "image-space").collect();
    let table = ReportTable::new(rows.iter().copied())
        .text("points", points)
        .text("setting", |row| short(&row.setting))
        .number("ms", digits, |row| row.gpu_ms.median)
        .number("RMSE", error, |row| row.errors.rmse)
        .number("inside", error, |row| row.rmse_inside)
        .number("% holes", percent, |row| row.holes);
    html! {
        @if rows.is_empty() { p { "The method image-space was not measured." } } @else {
            p {
                "Points of one pixel whose holes are filled afterwards: an iteration fills holes one pixel farther from their rim, and "
                "takes the same time whatever the points are."
            }
            (table.html())
        }
    }
}

/// Soft shadows of more and fewer samples.
pub(super) fn shaded(found: &Shaded) -> Markup {
    let table = ReportTable::new(&found.steps)
        .number("samples of the light", count, |step| f64::from(step.samples))
        .number("ms", digits, |step| step.ms.median)
        .written("from–to", |step| (step.ms.median, format!("{}–{}", digits(step.ms.min), digits(step.ms.max))))
        .number("RMSE", error, |step| step.rmse)
        .number("RMSE · √samples", error, |step| step.rmse * f64::from(step.samples).sqrt());
    html! {
        h2 { "Shadows" }
        p {
            "With " code { (found.method) } ", against an image with " (found.reference_samples) " samples. The time is that of the passes "
            "that find the shadows, which a cloud keeps as long as light and points stay."
        }
        (table.html())
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
