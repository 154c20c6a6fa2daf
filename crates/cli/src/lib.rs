//! The command line of `pellucid`, and with the feature `mpi` that of `pellucid-mpi`.

mod commands;
#[cfg(test)]
mod documents;
mod error;
mod legend;

use std::ffi::OsString;
use std::process::ExitCode;

#[doc(hidden)]
pub use commands::console::{Captured, Streams};

/// `pellucid`.
pub fn main() -> ExitCode {
    run_from(std::env::args_os(), Streams::Process)
}

/// Runs a command line, whose first argument is the program's name, and returns its exit status.
///
/// Tests capture the output and start no process. Then the handlers of signals and panics stay those of the caller.
#[doc(hidden)]
pub fn run_from(arguments: impl IntoIterator<Item = OsString>, streams: Streams) -> ExitCode {
    commands::run(arguments, streams).unwrap_or_else(|error| {
        streams.print_stderr(format_args!("error: {}", with_causes(&error)));
        ExitCode::from(error.exit_status())
    })
}

/// `pellucid-mpi`.
#[cfg(feature = "mpi")]
pub fn main_of_ranks() -> ExitCode {
    commands::mpi::run()
}

/// The message and those of its causes that it doesn't contain already.
fn with_causes(error: &dyn std::error::Error) -> String {
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !message.contains(&text) {
            message = format!("{message}: {text}");
        }
        cause = error.source();
    }
    message
}
