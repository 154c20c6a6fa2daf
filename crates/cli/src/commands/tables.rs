//! Tables of text.

use std::ops::Range;

use comfy_table::{CellAlignment, Table, presets};

/// Returns a table without lines, some of whose columns are aligned on the right.
pub fn table<const N: usize>(
    header: [&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
    right: Range<usize>,
) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header).add_rows(rows);
    table.column_iter_mut().take(right.end).skip(right.start).for_each(|column| {
        column.set_cell_alignment(CellAlignment::Right);
    });
    table
}
