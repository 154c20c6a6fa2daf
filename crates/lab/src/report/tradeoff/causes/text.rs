//! The causes of errors as a table for a terminal.

use comfy_table::{CellAlignment, Table, presets};

use super::Cause;
use super::table::changed;

/// The causes and their figures, without what they mean; empty without causes.
pub fn causes_table(causes: &[Cause]) -> String {
    if causes.is_empty() {
        return String::new();
    }
    let mut table = Table::new();
    let head = ["cause", "changed", "RMSE", "FLIP", "largest", "> 1/255", "ms"];
    table.load_style(presets::NOTHING).set_header(head);
    table.add_rows(causes.iter().map(line));
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let about = "by cause: the exact image of this kernel and order, compared with itself with one thing changed";
    format!("{about}\n{}\n", table.trim_fmt())
}

fn line(cause: &Cause) -> [String; 7] {
    [
        cause.cause.clone(),
        changed(cause),
        format!("{:.2e}", cause.rmse),
        format!("{:.2e}", cause.flip),
        format!("{:.2e}", cause.max),
        format!("{:.2}%", 100.0 * cause.above_1_255),
        format!("{:.2}", cause.gpu_ms),
    ]
}
