//! The frame of a report's page: one HTML file that loads nothing.

use std::io::Write;
use std::path::Path;

use comfy_table::{CellAlignment, presets};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use pellucid_io::output::{self, Files};

use super::plot::Figure;
use super::unique;

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

/// A table of some rows. Each column is declared once, by its head and the cell of a row.
pub struct ReportTable<'a, R> {
    rows: Vec<&'a R>,
    columns: Vec<Column>,
}

struct Column {
    title: String,
    /// True if it contains words, which are aligned left, rather than numbers.
    is_text: bool,
    cells: Vec<Cell>,
}

struct Cell {
    text: String,
    /// The sort key of rows; NaN, and words, sort by the text.
    value: f64,
}

impl<'a, R> ReportTable<'a, R> {
    /// A table without a column.
    pub fn new(rows: impl IntoIterator<Item = &'a R>) -> Self {
        Self { rows: rows.into_iter().collect(), columns: Vec::new() }
    }

    fn column(mut self, title: impl Into<String>, is_text: bool, cell: impl Fn(&'a R) -> Cell) -> Self {
        let cells = self.rows.iter().map(|row| cell(row)).collect();
        self.columns.push(Column { title: title.into(), is_text, cells });
        self
    }

    /// Adds a column of words.
    #[must_use]
    pub fn text<T: Into<String>>(self, title: impl Into<String>, text: impl Fn(&'a R) -> T) -> Self {
        self.column(title, true, |row| Cell { text: text(row).into(), value: f64::NAN })
    }

    /// Adds a column of numbers as `show` writes them; without a number a cell is empty.
    #[must_use]
    pub fn number<N: Into<Option<f64>>>(
        self,
        title: impl Into<String>,
        show: impl Fn(f64) -> String,
        number: impl Fn(&'a R) -> N,
    ) -> Self {
        self.column(title, false, |row| match number(row).into() {
            Some(value) => Cell { text: show(value), value },
            None => Cell { text: String::new(), value: f64::NAN },
        })
    }

    /// Adds a column of numbers with texts of their own.
    #[must_use]
    pub fn written<T: Into<String>>(self, title: impl Into<String>, cell: impl Fn(&'a R) -> (f64, T)) -> Self {
        self.column(title, false, |row| {
            let (value, text) = cell(row);
            Cell { text: text.into(), value }
        })
    }

    /// The table on a page.
    pub fn html(&self) -> Markup {
        self.markup(None)
    }

    /// The table on a page with [`sorting`], which a click on the head of a column sorts; some rows are marked.
    pub fn sortable(&self, is_marked: impl Fn(&R) -> bool) -> Markup {
        self.markup(Some(&is_marked))
    }

    /// A table that can be sorted if rows may be marked.
    fn markup(&self, is_marked: Option<&dyn Fn(&R) -> bool>) -> Markup {
        let (class, scope) = (is_marked.map(|_| "sortable"), is_marked.map(|_| "col"));
        html! {
            div.wide {
                table class=[class] {
                    thead {
                        tr { @for column in &self.columns { th scope=[scope] class=[column.class()] { (column.title) } } }
                    }
                    tbody {
                        @for (index, row) in self.rows.iter().enumerate() {
                            tr class=[is_marked.and_then(|is_marked| is_marked(row).then_some("marked"))] {
                                @for column in &self.columns {
                                    @let cell = &column.cells[index];
                                    td class=[column.class()] data-value=[class.map(|_| cell.key())] { (cell.text) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// The table in a terminal.
    pub fn terminal(&self) -> String {
        let mut table = comfy_table::Table::new();
        table.load_style(presets::NOTHING).set_header(self.columns.iter().map(|column| &column.title));
        for row in 0..self.rows.len() {
            table.add_row(self.columns.iter().map(|column| &column.cells[row].text));
        }
        for (shown, column) in table.column_iter_mut().zip(&self.columns) {
            let side = if column.is_text { CellAlignment::Left } else { CellAlignment::Right };
            shown.set_cell_alignment(side);
        }
        table.trim_fmt()
    }
}

impl Column {
    fn class(&self) -> Option<&'static str> {
        self.is_text.then_some("text")
    }
}

impl Cell {
    fn key(&self) -> String {
        match self.value {
            value if value.is_nan() => self.text.clone(),
            // The form that JavaScript reads.
            value if value.is_infinite() => if value > 0.0 { "Infinity" } else { "-Infinity" }.to_owned(),
            value => value.to_string(),
        }
    }
}

/// Median times of a frame in ms: its head, its passes and the time of them all.
type Times<'a> = (String, Vec<(&'a str, f64)>, f64);

/// The median times of passes: a row for each name, and a column for each frame.
pub fn passes<'a>(title: &str, names: Vec<&'a str>, frames: Vec<Times<'a>>) -> Markup {
    let names: Vec<&str> = unique(names).into_iter().chain([ALL_PASSES]).collect();
    let mut table = ReportTable::new(&names).text(title, |name| *name);
    for (head, passes, all) in frames {
        let time = |name: &&str| passes.iter().find(|(pass, _)| pass == name).map(|(_, ms)| *ms);
        table = table.number(head, digits, |name| if *name == ALL_PASSES { Some(all) } else { time(name) });
    }
    table.html()
}

const ALL_PASSES: &str = "all passes";

/// The script that sorts tables ([`ReportTable::sortable`]), once at the end of a page.
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

/// A figure of a report: the name of its file, the SVG element and its caption.
pub struct Drawn {
    /// Name of the file.
    pub name: &'static str,
    svg: String,
    caption: Markup,
}

impl Drawn {
    /// Draws a figure.
    ///
    /// # Errors
    /// The drawing library fails.
    pub fn new(name: &'static str, figure: &Figure, caption: Markup) -> Result<Self, output::Error> {
        let failed = |error| output::Error::Report { reason: format!("{name}: {error}") };
        Ok(Self { name, svg: figure.svg().map_err(failed)?, caption })
    }

    /// The figure on a page; `values` names the tables that hold its values, for those who can't see it.
    pub fn html(&self, values: &str) -> Markup {
        html! {
            figure {
                div role="img" aria-label={ (self.name) ": the values are those of " (values) } { (PreEscaped(&self.svg)) }
                figcaption { (self.caption) }
            }
        }
    }
}

/// Adds the figures and, last, `report.html` to the files of a folder.
///
/// # Errors
/// Writing fails.
pub fn add(files: &mut Files, folder: &Path, figures: &[Drawn], html: &str) -> Result<(), output::Error> {
    for figure in figures {
        files.add(&folder.join(figure.name), |file| file.write_all(figure.svg.as_bytes()))?;
    }
    files.add(&folder.join("report.html"), |file| file.write_all(html.as_bytes()))
}

/// Three significant digits.
pub fn digits(value: f64) -> String {
    if !(value.abs() > 0.0 && value.is_finite()) {
        return value.to_string();
    }
    let places = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.places$}")
}

/// A whole number.
pub fn count(value: f64) -> String {
    value.to_string()
}

/// Bytes as MiB, in a table.
pub fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
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
        let page = page("a < b", &ReportTable::new(&["<b>&"]).text("name", |name| *name).html());
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
        assert!(page.contains("<title>a &lt; b</title>") && page.contains("&lt;b&gt;&amp;") && !page.contains("<b>"));
    }
}
