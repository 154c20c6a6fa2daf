//! Signals that are ignored from the start stay ignored in whatever is started: SIGHUP under `nohup`, SIGINT in a
//! script's job in the background.

use std::ffi::OsStr;
use std::process::Command;

/// A command that heeds SIGHUP, SIGINT and SIGTERM even where these tests ignore them.
pub fn heeding(program: impl AsRef<OsStr>) -> Command {
    if ![1, 2, 15].into_iter().any(is_ignored) {
        return Command::new(program);
    }
    // From the GNU core utilities; it keeps the process.
    let mut env = Command::new("env");
    env.arg("--default-signal=HUP,INT,TERM").arg(program);
    env
}

/// True if these tests ignore a signal.
fn is_ignored(signal: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
