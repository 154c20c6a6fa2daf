//! The way in, which all benches of this crate share.

use std::process::ExitCode;

use pellucid_engine::Result;

/// Measures, or does nothing where `cargo test --benches` runs the bench without the option; prints an error.
pub fn measure(run: impl FnOnce() -> Result<()>) -> ExitCode {
    if !std::env::args().any(|argument| argument == "--bench") {
        return ExitCode::SUCCESS;
    }
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
