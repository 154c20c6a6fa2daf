//! Errors of ranks: an error of one is an error of all.

use std::process::ExitCode;

use pellucid_engine::Result;

use super::ranks::Ranks;
use crate::commands::console::print_stderr;

/// Returns the result of a rank once all others have theirs: an error of one is an error of all, and the first rank
/// prints it.
///
/// # Errors
/// The exit status.
pub fn together<T>(ranks: &Ranks, done: Result<T>) -> std::result::Result<T, ExitCode> {
    let (own, said) = match done {
        Ok(own) => (Some(own), Vec::new()),
        Err(error) => {
            let error = crate::error::Error::from(error);
            let text = format!("{}: {}", ranks.name(), crate::with_causes(&error));
            (None, [vec![error.exit_status()], text.into_bytes()].concat())
        }
    };
    let all = ranks.all_told(&said);
    let Some(first) = all.iter().find(|said| !said.is_empty()) else {
        return own.ok_or(ExitCode::FAILURE);
    };
    if ranks.is_first() {
        let others = all.iter().filter(|said| !said.is_empty()).count() - 1;
        let more = if others > 0 { format!(" (and {others} other ranks)") } else { String::new() };
        print_stderr(format_args!("error: {}{more}", String::from_utf8_lossy(&first[1..])));
    }
    Err(ExitCode::from(first[0]))
}
