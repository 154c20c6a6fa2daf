//! Popping on the page of a comparison.

use maud::{Markup, html};

use super::{Curve, Popping};
use crate::report::page::{Column, table};

/// The section with its figures; `error` writes an error.
pub(in crate::report) fn section(popping: &Popping, figures: &Markup, error: fn(f64) -> String) -> Markup {
    let columns = [
        Column::text("method"),
        Column::number("mean RMSE"),
        Column::number("worst RMSE"),
        Column::number("of frame"),
        Column::number("mean FLIP"),
        Column::number("worst FLIP"),
        Column::number("mean error (RMSE)"),
    ];
    let row = |curve: &Curve| {
        vec![
            curve.name(),
            error(curve.mean_rmse),
            error(curve.worst_rmse),
            curve.worst_frame.to_string(),
            error(curve.mean_flip),
            error(curve.worst_flip),
            error(curve.mean_error),
        ]
    };
    html! {
        h2 { "Popping" }
        p {
            "The table shows how much the error changes from one of the path's " (popping.frames) " frames to the next: what "
            "flickers or jumps while the camera moves. The error of a frame is its difference from " code { (popping.exact) } ", pixel by "
            "pixel; an error that stays the same does not pop, however large it is (the last column). RMSE is that of the change; FLIP compares the exact frame with the "
            "exact frame plus the change. An error that moves with the scene changes, too. Steps as small as a film's keep that "
            "change small, so jumps stand out."
        }
        (table(&columns, &popping.curves.iter().map(row).collect::<Vec<_>>()))
        (figures)
        @for refused in &popping.refused { p { (refused.method) " was left out: " (refused.reason) } }
    }
}

/// The caption of a figure, for `popping.svg` with RMSE and for the other with FLIP.
pub(in crate::report) fn caption(name: &str) -> Markup {
    let figure = if name == "popping.svg" { "RMSE" } else { "FLIP" };
    html! {
        b { "The change of the error since the frame before, as " (figure) ", over the frames of the path. " }
        "Lower is steadier. A peak is a frame in which much jumps at once; a level line is noise that is new in every frame. No change at all is "
        "drawn at the least value."
    }
}
