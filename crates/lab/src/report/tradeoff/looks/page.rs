//! How errors look, on the page of a comparison.

use std::path::Path;

use maud::{Markup, html};
use pellucid_io::output;

use super::super::pictures::{cropped, read, uri};
use super::super::{DIFFERENCE_GAIN, Row, Tradeoff};
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

/// Half a step of 8 bits: no picture of 8 bits shows less.
const LEAST_SHOWN: f64 = 0.5 / 255.0;
/// Smaller shares are not listed.
const LEAST_SHARE: f64 = 0.05;
/// A bias that is a smaller part of the RMSE is none to speak of.
const LEAST_BIAS: f64 = 0.1;

/// Returns a sentence about the size and the sign of the error, and a sentence about its parts.
pub(super) fn sentences(row: &Row, look: &Look) -> [String; 2] {
    let rmse = error(row.errors.rmse);
    let size = if row.errors.max < LEAST_SHOWN {
        format!("An error of at most {} shows in no picture of 8 bits (RMSE {rmse})", error(row.errors.max))
    } else if look.bias.abs() < LEAST_BIAS * row.errors.rmse {
        format!("With an RMSE of {rmse} it is neither brighter nor darker than the exact image on average")
    } else {
        let side = if look.bias > 0.0 { "bright" } else { "dark" };
        format!("With an RMSE of {rmse} it is too {side} by {} on average", error(look.bias.abs()))
    };
    let mut parts = parts(look);
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let listed: Vec<String> = parts
        .iter()
        .filter(|(share, _)| *share >= LEAST_SHARE)
        .map(|(share, what)| format!("{:.0} % {what}", 100.0 * share))
        .collect();
    [format!("{size}."), format!("Its squared error is {}.", joined(&listed))]
}

/// Shares and what they are.
fn parts(look: &Look) -> [(f64, &'static str); 4] {
    let leak = look.leak.unwrap_or(0.0);
    let order = if leak < 0.0 {
        "the opposite of leak (hidden colors are too weak)"
    } else {
        "leak (hidden colors come through)"
    };
    [
        (look.even, "an even shift (the same everywhere)"),
        (leak.abs(), order),
        (look.ghost, "ghosts (shapes that are not there)"),
        (look.noise, "noise (from pixel to pixel)"),
    ]
}

fn joined(parts: &[String]) -> String {
    match parts {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tradeoff::Errors;
    use crate::report::tradeoff::looks::Worst;

    fn look(bias: f64, [even, leak, ghost, noise]: [f64; 4]) -> Look {
        Look { bias, even, leak: Some(leak), ghost, noise, worst: Worst { x: 0, y: 0, side: 1, share: 1.0 } }
    }

    fn row(rmse: f64, max: f64) -> Row {
        let errors = Errors { rmse, max, ..Errors::default() };
        Row { method: "moments".into(), setting: "method.moments=8".into(), errors, ..Row::default() }
    }

    #[test]
    fn two_sentences_say_how_large_and_what() {
        let [size, what] = sentences(&row(0.02, 0.3), &look(-0.012, [0.04, 0.6, 0.2, 0.16]));
        assert_eq!(size, "With an RMSE of 0.0200 it is too dark by 0.0120 on average.");
        assert_eq!(
            what,
            "Its squared error is 60 % leak (hidden colors come through), 20 % ghosts (shapes that are not there) and 16 % noise (from \
             pixel to pixel)."
        );
        let [size, what] = sentences(&row(0.02, 0.3), &look(0.001, [0.0, -1.0, 0.0, 0.0]));
        assert!(size.contains("neither brighter nor darker"), "{size}");
        assert_eq!(what, "Its squared error is 100 % the opposite of leak (hidden colors are too weak).");
        let [size, _] = sentences(&row(0.0005, 0.001), &look(0.0005, [1.0, 0.0, 0.0, 0.0]));
        assert_eq!(size, "An error of at most 0.00100 shows in no picture of 8 bits (RMSE 5.0e−4).");
        let [size, what] = sentences(&row(0.02, 0.3), &look(0.02, [1.0, 0.0, 0.0, 0.0]));
        assert!(size.contains("too bright by 0.0200"), "{size}");
        assert_eq!(what, "Its squared error is 100 % an even shift (the same everywhere).");
        assert_eq!(row(0.0, 0.0).name(), "moments moments=8");
    }
}
