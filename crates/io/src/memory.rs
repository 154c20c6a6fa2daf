//! Clouds that can't fit into memory, refused before any of their points is read.

use std::path::Path;

use super::Error;

/// Checks that memory can hold so many points of at least so many bytes each, where the system says how much is free.
pub(super) fn check(path: &Path, points: u64, bytes_each: u64) -> Result<(), Error> {
    check_within(free(), path, points, bytes_each)
}

fn check_within(free: Option<u64>, path: &Path, points: u64, bytes_each: u64) -> Result<(), Error> {
    let needed = points.saturating_mul(bytes_each);
    match free {
        Some(free) if needed > free => Err(Error::TooLarge { path: path.to_path_buf(), points, needed, free }),
        _ => Ok(()),
    }
}

/// Bytes that Linux says can be used, swap included.
fn free() -> Option<u64> {
    parse(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse(text: &str) -> Option<u64> {
    bytes(text, "MemAvailable:")?.checked_add(bytes(text, "SwapFree:").unwrap_or(0))
}

fn bytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Memory for points where the system doesn't say how much is free.
const UNKNOWN: u64 = 2 << 30;

/// The least memory for points that is of use.
pub const LEAST_MEMORY: u64 = 1 << 20;

/// Returns the number of bytes of memory for points where nobody asks for others: half of what Linux says can be used
/// without swapping.
pub fn memory_for_points() -> u64 {
    let text = std::fs::read_to_string("/proc/meminfo").ok();
    let free = text.and_then(|text| bytes(&text, "MemAvailable:"));
    free.map_or(UNKNOWN, |free| (free / 2).max(LEAST_MEMORY))
}

/// Returns `true` if this process can have so many more bytes of memory, as far as the system says.
pub fn has_memory(bytes: u64) -> bool {
    let Ok(length) = usize::try_from(bytes) else { return false };
    free().is_none_or(|free| bytes <= free) && Vec::<u8>::new().try_reserve_exact(length).is_ok()
}

/// Returns the most bytes of memory that this process had at a time so far, where Linux says so.
pub fn peak_memory() -> Option<u64> {
    bytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_has_all_memory_that_there_could_be() {
        assert!(has_memory(0) && has_memory(1 << 20));
        assert!(!has_memory(u64::MAX) && !has_memory(1 << 60));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_of_memory_holds_what_was_touched_and_given_back() {
        let before = peak_memory().unwrap();
        drop(std::hint::black_box(vec![1u8; 512 << 20]));
        let after = peak_memory().unwrap();
        assert!(after >= 512 << 20 && after >= before, "{before}, {after}");
    }

    #[test]
    fn available_memory_is_parsed() {
        let text = "MemTotal:       24000 kB\nMemAvailable:   1000 kB\nSwapTotal: 9 kB\nSwapFree:       24 kB\n";
        assert_eq!(parse(text), Some(1 << 20));
        assert_eq!(parse("MemAvailable: 2 kB\n"), Some(2048));
        for other in ["", "MemTotal: 1 kB\n", "MemAvailable: many kB\n", "MemAvailable: 99999999999999999999 kB\n"] {
            assert_eq!(parse(other), None, "{other}");
        }
    }

    #[test]
    fn more_than_is_free_is_refused() {
        let check = |free, points| check_within(free, Path::new("a.ply"), points, 24);
        assert!(check(Some(2400), 100).is_ok() && check(None, u64::MAX).is_ok());
        let error = check(Some(2399), 100).unwrap_err().to_string();
        assert!(
            error.starts_with("a.ply: 100 points take at least 2.3 KiB of memory, but only 2.3 KiB are free"),
            "{error}"
        );
        assert!(error.contains("pellucid prepare") && error.contains("--host-memory"), "{error}");
        assert!(check(Some(u64::MAX - 1), u64::MAX).is_err());
    }
}
