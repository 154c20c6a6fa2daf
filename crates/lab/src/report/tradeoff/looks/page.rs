//! How errors look, on the page of a comparison.

use std::path::Path;

use maud::{Markup, html};
use pellucid_io::output;

use super::super::pictures::{cropped, read, uri};
use super::super::{DIFFERENCE_GAIN, Tradeoff};
use super::text::sentences;
use super::{Look, Worst, shown};
use crate::report::page::{ReportTable, digits};
use crate::report::tradeoff::page::{error, percent};

/// Pixels of the page across one of a crop.
const SCALE: u32 = 4;

/// Reference, picture and difference of each approximation that is shown, around its worst place, as data URIs.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Crops(Vec<[String; 3]>);

impl Crops {
    /// Reads the files that the report names, one at a time.
    pub(in super::super) fn read(folder: &Path, report: &Tradeoff) -> Result<Self, output::Error> {
        let crop = |file: &str, Worst { x, y, side, .. }: Worst| {
            let path = folder.join(file);
            uri(&path, &cropped(&read(&path)?, [x, y], side))
        };
        let crops = shown(report).into_iter().map(|(_, row, look)| {
            let [truth, own, difference] = [&report.reference.picture, &row.picture, &row.difference];
            Ok([crop(truth, look.worst)?, crop(own, look.worst)?, crop(difference, look.worst)?])
        });
        Ok(Self(crops.collect::<Result<_, output::Error>>()?))
    }
}

/// The section; nothing without approximations.
pub(in super::super) fn section(report: &Tradeoff, crops: &Crops) -> Markup {
    let shown = shown(report);
    let share = |share: f64| if share < 0.0 { format!("−{}", percent(-share)) } else { percent(share) };
    let table = ReportTable::new(&shown)
        .text("method", |(_, row, _)| row.name())
        .number("bias", signed, |(.., look)| look.bias)
        .number("even %", share, |(.., look)| look.even)
        .number("leak %", share, |(.., look)| look.leak)
        .number("ghost %", share, |(.., look)| look.ghost)
        .number("noise %", share, |(.., look)| look.noise)
        .number("RMSE", error, |(_, row, _)| row.errors.rmse);
    html! {
        @if !shown.is_empty() {
            h2 { "How errors look" }
            (definitions())
            (table.html())
            @for ((_, row, look), crops) in shown.iter().zip(&crops.0) {
                @let [size, parts] = sentences(row, look);
                div.look {
                    h3 { (row.name()) }
                    p { (size) " " (parts) }
                    (around(look, crops))
                }
            }
        }
    }
}

fn signed(value: f64) -> String {
    if value < 0.0 { format!("−{}", error(-value)) } else { error(value) }
}

fn definitions() -> Markup {
    html! {
        p {
            "The most accurate measured setting of each approximation, on the pixels that are not background: the bias, and what the squared "
            "error consists of, in parts that make up the whole."
        }
        ul {
            li { b { "Bias " } "is the mean luminance of the image less that of the exact one, in linear light." }
            li { b { "Even " } "is a shift of color that is the same on all pixels." }
            li {
                b { "Leak " } "is light that comes through from behind: the part of the error that points from the exact color toward the mean of "
                "all colors on the pixel by opacity, as if they had no order; below 0 what is hidden is too weak."
            }
            li { b { "Ghosts " } "are the part of the rest that goes on from a pixel to those beside it: shapes and outlines that are not there." }
            li { b { "Noise " } "is what is left, another in each pixel." }
        }
    }
}

/// The place where it is worst.
fn around(Look { worst, .. }: &Look, crops: &[String; 3]) -> Markup {
    let Worst { x, y, side, share } = worst;
    let across = SCALE * side;
    let tags = ["exact".to_owned(), "method".to_owned(), format!("difference, {DIFFERENCE_GAIN} times")];
    html! {
        figure {
            div.crops {
                @for (uri, tag) in crops.iter().zip(&tags) {
                    div.crop {
                        img src=(uri) width=(across) height=(across) alt={ (tag) ", where the error is largest" };
                        span { (tag) }
                    }
                }
            }
            figcaption {
                "The " (side) " × " (side) " pixels with most of the error, " (digits(100.0 * share)) " % of it: from column " (x) " and row "
                (y) " on, each pixel " (SCALE) " times as wide."
            }
        }
    }
}
