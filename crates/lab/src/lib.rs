//! Measures what the engine does: hard cases with known answers ([`check`]), reports of accuracy, time and memory
//! ([`report`]), and the choice of a method from measurements ([`choice`]). Says what there is to say of a frame
//! ([`frame_notes`]).

pub mod check;
pub mod choice;
mod ensemble_warnings;
pub mod frame_notes;
pub mod report;

mod profile_table;

pub use profile_table::profile_table;
