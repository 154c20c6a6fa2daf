//! Popping as tables and figures, on the page of a comparison and by themselves.

use std::io::{self, Write};
use std::path::Path;

use maud::{Markup, html};
use pellucid_core::metrics::error_text;
use pellucid_io::output;
use serde::Serialize;

use super::{Curve, FrameError, Popping};
use crate::report::page::{ReportTable, count};
use crate::report::plot::{Axis, Figure, Panel, Point, Series};
use crate::report::records::{self, record};

/// A frame of a method as a record.
#[derive(Serialize)]
struct Line<'a> {
    method: &'a str,
    setting: &'a str,
    error: &'a FrameError,
}

/// The table for programs: method after method, and of each frame after frame.
///
/// # Errors
/// Writing fails.
pub fn csv(popping: &Popping, file: impl Write) -> io::Result<()> {
    let lines = popping.curves.iter().flat_map(|curve| {
        let Curve { method, setting, frames, .. } = curve;
        frames.iter().map(move |error| record(&Line { method, setting, error }))
    });
    let columns =
        "method setting frame=error/frame error_rmse=error/error popping_rmse=error/rmse popping_flip=error/flip";
    records::csv(file, columns, lines)
}

/// Writes the table to a file, whole or not at all.
///
/// # Errors
/// Writing fails.
pub fn write(path: &Path, popping: &Popping) -> Result<(), output::Error> {
    output::write_atomically(path, |file| csv(popping, file))
}

/// A line for each method; `last` is the head of the last column.
fn table<'a>(popping: &'a Popping, error: impl Fn(f64) -> String + Copy, last: &str) -> ReportTable<'a, Curve> {
    let mut table = ReportTable::new(&popping.curves)
        .text("method", Curve::name)
        .number("mean RMSE", error, |curve| curve.mean_rmse);
    if popping.curves.iter().any(|curve| curve.rolled_rmse.is_some()) {
        table = table.number("rolling", error, |curve| curve.rolled_rmse);
    }
    table
        .number("worst RMSE", error, |curve| curve.worst_rmse)
        .number("of frame", count, |curve| f64::from(curve.worst_frame))
        .number("mean FLIP", error, |curve| curve.mean_flip)
        .number("worst FLIP", error, |curve| curve.worst_flip)
        .number(last, error, |curve| curve.mean_error)
}

/// The table for a terminal.
pub fn popping_table(popping: &Popping) -> String {
    let table = table(popping, error_text, "mean error");
    let refused: String =
        popping.refused.iter().map(|r| format!("  {} was left out: {}\n", r.method, r.reason)).collect();
    format!(
        "popping over {} frames: the change of the error, against {}, from frame to frame\n{}\n{refused}",
        popping.frames,
        popping.exact,
        table.terminal()
    )
}

/// The section with its figures; `error` writes an error.
pub(in crate::report) fn section(popping: &Popping, figures: &Markup, error: fn(f64) -> String) -> Markup {
    html! {
        h2 { "Popping" }
        p {
            "The table shows how much the error changes from one of the path's " (popping.frames) " frames to the next: what "
            "flickers or jumps while the camera moves. The error of a frame is its difference from " code { (popping.exact) } ", pixel by "
            "pixel; an error that stays the same does not pop, however large it is (the last column). RMSE is that of the change; FLIP compares the exact frame with the "
            "exact frame plus the change. An error that moves with the scene changes, too. Steps as small as a film's keep that "
            "change small, so jumps stand out."
        }
        @if popping.curves.iter().any(|curve| curve.rolled_rmse.is_some()) {
            p {
                "The column “rolling” has the mean RMSE where the camera rolls about its own axis instead, by so much that "
                "points move as far in the picture. No point changes its depth then, so this is what the motion of the picture "
                "across its pixels changes; what the path adds to it is points that change their order."
            }
        }
        (table(popping, error, "mean error (RMSE)").html())
        (figures)
        @for refused in &popping.refused { p { (refused.method) " was left out: " (refused.reason) } }
    }
}

/// A figure over the frames of the path, with a line for each method and its caption; `None` if there is nothing to
/// show. Its axis has a label and a floor, and `value` is that of a frame by the measure.
pub(in crate::report) fn over_frames(
    popping: &Popping,
    measure: &str,
    axis: Axis,
    value: fn(&FrameError) -> Option<f64>,
) -> Option<(Figure, Markup)> {
    if popping.frames < 2 || popping.curves.is_empty() {
        return None;
    }
    let point = |frame: &FrameError| Some(Point::new(frame.frame.into(), value(frame)?));
    let series = popping.curves.iter().enumerate();
    let series = series.map(|(name, curve)| Series::new(name, curve.frames.iter().filter_map(point)));
    let names = popping.curves.iter().map(Curve::name).collect();
    let caption = html! {
        b { "The change of the error since the frame before, as " (measure) ", over the frames of the path. " }
        "Lower is steadier. A peak is a frame in which much jumps at once; a level line is noise that is new in every frame. No change at all is "
        "drawn at the least value."
    };
    Some((Figure::in_rows(420, names, Axis::even("frame"), axis, vec![Panel::new("", series)]), caption))
}
