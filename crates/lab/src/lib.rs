//! Measures what the engine does: hard cases with known answers ([`check`]), and reports of accuracy, time and memory
//! ([`report`]).

pub mod check;
pub mod report;

mod profile_table;

pub use profile_table::profile_table;
