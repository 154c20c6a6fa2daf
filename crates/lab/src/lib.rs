//! Measures what the engine does: hard cases with known answers ([`check`]), reports of accuracy, time and memory
//! ([`report`]), and the choice of a method from measurements ([`choice`]).

pub mod check;
pub mod choice;
pub mod ensemble_warnings;
pub mod report;

mod profile_table;

pub use profile_table::profile_table;
