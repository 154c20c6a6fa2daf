//! The command line of `pellucid`, and with the feature `mpi` that of `pellucid-mpi`.

mod commands;
#[cfg(test)]
mod documents;
mod legend;

#[doc(hidden)]
pub use commands::console::{Captured, Streams};
pub use commands::main;
#[cfg(feature = "mpi")]
pub use commands::mpi::main as main_of_ranks;
#[doc(hidden)]
pub use commands::run_from;
