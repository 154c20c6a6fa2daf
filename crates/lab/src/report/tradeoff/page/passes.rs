//! The time of each pass.

use maud::{Markup, html};

use super::{Row, Tradeoff};
use crate::report::page::{Column, digits, table};
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

fn passes_of(rows: &[&Row]) -> Markup {
    // The longest list first: most of the others' passes are in it, and in their order.
    let mut by_length = rows.to_vec();
    by_length.sort_by_key(|row| std::cmp::Reverse(row.passes.len()));
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in by_length.iter().flat_map(|row| &row.passes) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let heads = rows.iter().map(|row| if row.setting.is_empty() { "defaults".to_owned() } else { short(&row.setting) });
    let mut columns = vec![Column::text("pass")];
    columns.extend(heads.map(Column::number));
    let time = |row: &Row, name: &str| row.passes.iter().find(|(pass, _)| pass == name).map(|(_, ms)| digits(*ms));
    let line = |name: &&str| {
        let times = rows.iter().map(|row| time(row, name).unwrap_or_default());
        std::iter::once((*name).to_owned()).chain(times).collect::<Vec<_>>()
    };
    let mut lines: Vec<_> = names.iter().map(line).collect();
    let sums = rows.iter().map(|row| digits(row.gpu_ms.median));
    lines.push(std::iter::once("all passes".to_owned()).chain(sums).collect());
    table(&columns, &lines)
}
