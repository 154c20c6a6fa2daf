//! The time of each pass.

use std::cmp::Reverse;

use maud::{Markup, html};

use super::{Row, Tradeoff};
use crate::report::page::passes as table_of;
use crate::report::tradeoff::figures::short;

/// A table of passes for each method.
pub(super) fn passes(report: &Tradeoff) -> Markup {
    let mut methods: Vec<&str> = report.rows.iter().map(|row| row.method.as_str()).collect();
    methods.dedup();
    html! {
        p { "Median device time in ms. An empty cell means that the pass did not run." }
        @for method in methods {
            @let rows: Vec<&Row> = report.rows.iter().filter(|row| row.method == method).collect();
            details { summary { (method) } (passes_of(&rows)) }
        }
    }
}

fn passes_of<'a>(rows: &[&'a Row]) -> Markup {
    // The longest list first: most of the others' passes are in it, and in their order.
    let mut by_length = rows.to_vec();
    by_length.sort_by_key(|row| Reverse(row.passes.len()));
    let names = by_length.iter().flat_map(|row| &row.passes).map(|(name, _)| name.as_str()).collect();
    let frame = |row: &&'a Row| {
        let head = if row.setting.is_empty() { "defaults".to_owned() } else { short(&row.setting) };
        (head, row.passes.iter().map(|(name, ms)| (name.as_str(), *ms)).collect(), row.gpu_ms.median)
    };
    table_of("pass", names, rows.iter().map(frame).collect())
}
