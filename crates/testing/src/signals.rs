//! Signals that are ignored from the start stay ignored in whatever is started.

/// Whether these tests ignore a signal, as SIGHUP under `nohup`, or SIGINT in a script's job in the background.
pub fn is_ignored(signal: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
