//! A command in a process of its own, and what it cost.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time between two looks at the process.
const PAUSE: Duration = Duration::from_millis(20);

/// Cost of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Seconds from start to end.
    pub seconds: f64,
    /// The most bytes that were resident.
    pub bytes: u64,
}

/// Runs a program to its end.
///
/// # Errors
/// Returns an error if the program can't be started or fails, or if the system doesn't say how much is resident.
pub fn run(program: &Path, arguments: &[OsString]) -> Result<Cost, String> {
    let words: Vec<_> = arguments.iter().map(|word| word.to_string_lossy()).collect();
    let command = format!("{} {}", program.display(), words.join(" "));
    let failed = |what: String| format!("{command}: {what}");
    eprintln!("{command}");
    let start = Instant::now();
    let child = Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut child = child.map_err(|error| failed(error.to_string()))?;
    let mut bytes = 0;
    let status = loop {
        // The system counts the most itself: what comes between two looks is not lost, but what comes after the last
        // one.
        bytes = resident(child.id()).unwrap_or(bytes);
        if let Some(status) = child.try_wait().map_err(|error| failed(error.to_string()))? {
            break status;
        }
        std::thread::sleep(PAUSE);
    };
    let seconds = start.elapsed().as_secs_f64();
    if !status.success() {
        return Err(failed(status.to_string()));
    }
    if bytes == 0 {
        return Err(failed("the system doesn't say what is resident: this needs Linux".to_owned()));
    }
    eprintln!("  {seconds:.1} s, {}", bytesize::ByteSize(bytes));
    Ok(Cost { seconds, bytes })
}

/// The most bytes that a process had resident so far; `None` once it has ended.
fn resident(process: u32) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(1024 * kibibytes)
}
