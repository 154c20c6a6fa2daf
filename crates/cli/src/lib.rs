//! The command line of `pellucid`, and with the feature `mpi` that of `pellucid-mpi`.

mod commands;
#[cfg(test)]
mod documents;
mod error;
mod legend;

use std::io::Write;
use std::process::ExitCode;

/// `pellucid`.
pub fn main() -> ExitCode {
    commands::run().unwrap_or_else(|error| {
        // Without a standard error the message is lost, which is fine.
        let _ = writeln!(std::io::stderr(), "error: {}", with_causes(&error));
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
