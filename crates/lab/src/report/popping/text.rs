//! Popping as a table for a terminal.

use comfy_table::{CellAlignment, Table, presets};

use super::{Curve, Popping};

/// A line for each method.
pub fn popping_table(popping: &Popping) -> String {
    let mut table = Table::new();
    let head = ["method", "mean RMSE", "worst RMSE", "of frame", "mean FLIP", "worst FLIP", "mean error"];
    table.load_style(presets::NOTHING).set_header(head);
    table.add_rows(popping.curves.iter().map(line));
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let refused: String =
        popping.refused.iter().map(|r| format!("  {} was left out: {}\n", r.method, r.reason)).collect();
    format!(
        "popping over {} frames: the change of the error, against {}, from frame to frame\n{}\n{refused}",
        popping.frames,
        popping.exact,
        table.trim_fmt()
    )
}

fn line(curve: &Curve) -> [String; 7] {
    let number = |value: f64| format!("{value:.2e}");
    [
        curve.name(),
        number(curve.mean_rmse),
        number(curve.worst_rmse),
        curve.worst_frame.to_string(),
        number(curve.mean_flip),
        number(curve.worst_flip),
        number(curve.mean_error),
    ]
}
