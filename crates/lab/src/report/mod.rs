//! Reports: measurements as tables, figures and one HTML page that needs nothing but itself.
//!
//! [`stress`] is the depth-complexity sweep, [`tradeoff`] accuracy against time. What they are made of serves any report:
//! [`fit`] finds slopes, [`plot`] draws figures as SVG, [`page`] is the frame of a page.

pub mod fit;
pub mod page;
pub mod plot;
pub mod stress;
pub mod tradeoff;
pub(crate) mod truth;
