//! Reports: measurements as tables, figures and one self-contained HTML page.
//!
//! [`stress`] is the depth-complexity sweep, [`tradeoff`] compares accuracy with time, [`popping`] follows
//! errors along a camera path. All share their parts: [`fit`]
//! finds slopes, [`plot`] draws figures as SVG, [`page`] is the frame of a page.

pub mod fit;
pub mod page;
pub mod plot;
pub mod popping;
mod records;
pub mod stress;
pub mod tradeoff;
pub(crate) mod truth;

/// The different ones of some items, each where it comes first.
fn unique<T: PartialEq>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for item in items {
        if !found.contains(&item) {
            found.push(item);
        }
    }
    found
}
