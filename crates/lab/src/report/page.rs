//! The frame of a report's page: one HTML file that loads nothing.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #282828; background: #fff; max-width: 1180px; margin: 2rem auto; padding: 0 1rem; }
h1, h2, h3 { line-height: 1.2; }
h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; padding-bottom: .2rem; }
code { font-size: .9em; background: #f3f3f3; padding: .1em .3em; border-radius: 3px; overflow-wrap: anywhere; }
figure { margin: 1rem 0 2rem; }
figure svg { max-width: 100%; height: auto; }
figcaption { color: #555; font-size: .9rem; max-width: 60rem; }
p { max-width: 60rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; margin: .5rem 0 1.5rem; }
th, td { padding: .15rem .6rem; text-align: right; white-space: nowrap; }
th { border-bottom: 1px solid #888; vertical-align: bottom; }
tr:nth-child(even) td { background: #f6f6f6; }
.text { text-align: left; }
.long { white-space: normal; text-align: left; }
sup { line-height: 0; }
summary { cursor: pointer; font-weight: 600; margin: .3rem 0; }
[hidden] { display: none !important; }
.sentences td { white-space: normal; vertical-align: top; min-width: 5rem; }
.sortable th { position: relative; }
.sortable th button { all: unset; cursor: pointer; white-space: nowrap; }
.sortable th button:hover { text-decoration: underline; }
.sortable th button:focus-visible { outline: 2px solid #0072b2; outline-offset: 2px; }
.sortable th button::after { content: \"▲\"; visibility: hidden; position: absolute; font-size: .6em; }
.sortable th[aria-sort=ascending] button::after, .sortable th[aria-sort=descending] button::after { visibility: visible; }
.sortable th[aria-sort=descending] button::after { content: \"▼\"; }
.sortable th:first-child, .sortable td:first-child { position: sticky; left: 0; background: #fff; }
.sortable th, .sortable td { padding-left: .35rem; padding-right: .55rem; }
.sortable tr:nth-child(even) td:first-child { background: #f6f6f6; }
tr.marked td, .sortable tr.marked td:first-child { background: #fdf3d8; }
";

/// The page may not load anything; it may show and run what it contains.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'";

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Head of the column.
    pub title: String,
    /// True if it contains words, which are aligned left, rather than numbers.
    pub is_text: bool,
}

impl Column {
    /// A column of numbers.
    pub fn number(title: impl Into<String>) -> Self {
        Self { title: title.into(), is_text: false }
    }

    /// A column of words.
    pub fn text(title: impl Into<String>) -> Self {
        Self { title: title.into(), is_text: true }
    }
}

/// The whole page.
pub fn page(title: &str, body: &Markup) -> String {
    document(title, STYLE, &html! { h1 { (title) } (body) })
}

/// A page with a style of its own. It may not load anything.
pub fn document(title: &str, style: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(style)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// A table; every row has a cell for each column.
pub fn table(columns: &[Column], rows: &[Vec<String>]) -> Markup {
    let class = |column: &Column| column.is_text.then_some("text");
    html! {
        div.wide {
            table {
                thead { tr { @for column in columns { th class=[class(column)] { (column.title) } } } }
                tbody {
                    @for row in rows {
                        tr { @for (cell, column) in row.iter().zip(columns) { td class=[class(column)] { (cell) } } }
                    }
                }
            }
        }
    }
}

/// A cell of a table that can be sorted.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The displayed text.
    pub text: String,
    /// The sort key of rows; NaN, and words, sort by the text.
    pub value: f64,
}

impl Cell {
    /// A word.
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), value: f64::NAN }
    }

    /// A number as `show` writes it.
    pub fn number(value: f64, show: impl Fn(f64) -> String) -> Self {
        Self { text: show(value), value }
    }

    fn key(&self) -> String {
        match self.value {
            value if value.is_nan() => self.text.clone(),
            // The form that JavaScript reads.
            value if value.is_infinite() => if value > 0.0 { "Infinity" } else { "-Infinity" }.to_owned(),
            value => value.to_string(),
        }
    }
}

/// A row of a table that can be sorted.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Cells of the row, as many as there are columns.
    pub cells: Vec<Cell>,
    /// True if it is highlighted.
    pub is_marked: bool,
}

/// A table that a click on the head of a column sorts, with [`sorting`] on the page.
pub fn sortable(columns: &[Column], lines: &[Line]) -> Markup {
    let class = |column: &Column| column.is_text.then_some("text");
    html! {
        div.wide {
            table.sortable {
                thead { tr { @for column in columns { th scope="col" class=[class(column)] { (column.title) } } } }
                tbody {
                    @for line in lines {
                        tr class=[line.is_marked.then_some("marked")] {
                            @for (cell, column) in line.cells.iter().zip(columns) {
                                td class=[class(column)] data-value=(cell.key()) { (cell.text) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The script that sorts [`sortable`] tables, once at the end of a page.
pub fn sorting() -> Markup {
    script(include_str!("sort.js"))
}

/// A script of the page's own, which must not hold `</script`.
pub fn script(text: &str) -> Markup {
    html! { script { (PreEscaped(text)) } }
}

/// A list of names and their values.
pub fn facts(rows: &[(&str, String)]) -> Markup {
    html! {
        table { tbody { @for (name, value) in rows { tr { td.text { (name) } td.long { (value) } } } } }
    }
}

/// A figure from an SVG element, with its caption; `description` is for those who can't see it.
pub fn figure(svg: &str, description: &str, caption: &Markup) -> Markup {
    html! {
        figure {
            div role="img" aria-label=(description) { (PreEscaped(svg)) }
            figcaption { (caption) }
        }
    }
}

/// Three significant digits.
pub fn digits(value: f64) -> String {
    if !(value.abs() > 0.0 && value.is_finite()) {
        return value.to_string();
    }
    let places = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.places$}")
}

/// Thousands apart.
pub fn grouped(value: u64) -> String {
    let text = value.to_string();
    let head = text.len() % 3;
    let mut groups: Vec<&str> = Vec::new();
    if head > 0 {
        groups.push(&text[..head]);
    }
    groups.extend((head..text.len()).step_by(3).map(|at| &text[at..at + 3]));
    // A narrow space that doesn't break.
    groups.join("\u{202f}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_readable() {
        assert_eq!([0.0, 0.012345, 1.0, 12.345, 1234.5].map(digits), ["0", "0.0123", "1.00", "12.3", "1234"]);
        assert_eq!([0, 999, 1000, 16_777_216].map(grouped), ["0", "999", "1\u{202f}000", "16\u{202f}777\u{202f}216"]);
    }

    #[test]
    fn shown_text_is_escaped() {
        let body = table(&[Column::text("name"), Column::number("n")], &[vec!["<b>&".into(), "1".into()]]);
        let page = page("a < b", &body);
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
        assert!(page.contains("<title>a &lt; b</title>") && page.contains("&lt;b&gt;&amp;") && !page.contains("<b>"));
    }
}
