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
summary { cursor: pointer; font-weight: 600; margin: .3rem 0; }
";

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its head.
    pub title: String,
    /// Whether it holds words, which stand on the left, and not numbers.
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
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                (body)
            }
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

/// Names and what they stand for.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_is_escaped() {
        let body = table(&[Column::text("name"), Column::number("n")], &[vec!["<b>&".into(), "1".into()]]);
        let page = page("a < b", &body);
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
        assert!(page.contains("<title>a &lt; b</title>") && page.contains("&lt;b&gt;&amp;") && !page.contains("<b>"));
    }
}
