//! Faults on demand, for tests of what a failure leaves: in debug builds alone, by the environment variable
//! `PELLUCID_FAULT`. A release build takes no notice of it.
//!
//! Its value is `ACTION@POINT` or `ACTION@POINT:N`, as in `device-lost@wait:3`: when the point is passed for the N-th
//! time (by default the first), the action happens, once. With `N,M,…` it happens again at the M-th time and so on.
//! Points:
//!
//! | point | what is counted |
//! |---|---|
//! | `allocate` | allocations of device memory |
//! | `submit`, `wait` | submissions to the device, before and after they are done; not those of a window |
//! | `show` | frames of a window, before they are submitted |
//! | `output/create` | output files, before the temporary file is made |
//! | `output/rename`, `output/renamed` | output files, before and after the temporary file gets its name |
//! | `output/byte` | bytes of output files: the N-th and what follows is not written |
//! | `cache/rename` | files of the caches, before they get their name |
//!
//! Actions: `device-lost` and `out-of-memory` are what Vulkan answers; `disk-full` is what the system answers; `kill`
//! is SIGKILL; `hang` says so on standard error and waits two minutes for a signal.

use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Failures of a device, in Vulkan's words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceFault {
    /// `VK_ERROR_DEVICE_LOST`.
    Lost,
    /// `VK_ERROR_OUT_OF_DEVICE_MEMORY`.
    OutOfMemory,
    /// `VK_ERROR_UNKNOWN`.
    Unknown,
}

/// Writes bytes of an output file, up to the fault that is due among them.
///
/// # Errors
/// The system's, and the fault.
pub fn write_all(out: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    if let Some(before) = self::bytes("output/byte", bytes.len()) {
        out.write_all(&bytes[..before])?;
        strike()?;
    }
    out.write_all(bytes)
}

const VARIABLE: &str = "PELLUCID_FAULT";

/// Time that a hanging program waits for a signal.
const PATIENCE: Duration = Duration::from_secs(120);

const POINTS: [&str; 9] = [
    "allocate",
    "submit",
    "wait",
    "show",
    "output/create",
    "output/byte",
    "output/rename",
    "output/renamed",
    "cache/rename",
];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Action {
    DeviceLost,
    OutOfMemory,
    DiskFull,
    Kill,
    Hang,
}

#[derive(Debug)]
struct FaultPlan {
    action: Action,
    point: String,
    /// Passes of the point at which the action happens, counted from 1, in ascending order.
    at: Vec<u64>,
    passed: AtomicU64,
}

impl FaultPlan {
    fn parse(text: &str) -> Option<Self> {
        let (action, place) = text.split_once('@')?;
        let (point, at) = place.split_once(':').unwrap_or((place, "1"));
        let action = match action {
            "device-lost" => Action::DeviceLost,
            "out-of-memory" => Action::OutOfMemory,
            "disk-full" => Action::DiskFull,
            "kill" => Action::Kill,
            "hang" => Action::Hang,
            _ => return None,
        };
        let at: Vec<u64> = at.split(',').map(|at| at.parse().ok()).collect::<Option<_>>()?;
        let ascending = at.first().is_some_and(|at| *at > 0) && at.is_sorted_by(|a, b| a < b);
        if !ascending {
            return None;
        }
        POINTS.contains(&point).then(|| Self { action, point: point.to_owned(), at, passed: AtomicU64::new(0) })
    }

    /// The number of the next `units` of a point that precede the fault, if it is among them.
    fn due(&self, point: &str, units: u64) -> Option<u64> {
        if self.point != point {
            return None;
        }
        let passed = self.passed.fetch_add(units, Ordering::Relaxed);
        let due = self.at.iter().find(|at| passed < **at && **at <= passed + units);
        due.map(|at| at - 1 - passed)
    }
}

/// The plan given by the environment. A misspelled plan is an error, because its test would pass otherwise.
fn plan() -> Option<&'static FaultPlan> {
    if !cfg!(debug_assertions) {
        return None;
    }
    static PLAN: OnceLock<Option<FaultPlan>> = OnceLock::new();
    let read = || {
        let text = std::env::var(VARIABLE).ok()?;
        Some(
            FaultPlan::parse(&text)
                .unwrap_or_else(|| panic!("{VARIABLE}={text}: no such fault; crates/fault/src/lib.rs lists them")),
        )
    };
    PLAN.get_or_init(read).as_ref()
}

/// The failure of the device due at a point.
pub fn device(point: &str) -> Result<(), DeviceFault> {
    let Some(plan) = plan().filter(|plan| plan.due(point, 1).is_some()) else { return Ok(()) };
    match plan.action {
        Action::DeviceLost => Err(DeviceFault::Lost),
        Action::OutOfMemory => Err(DeviceFault::OutOfMemory),
        _ => strike().map_err(|_| DeviceFault::Unknown),
    }
}

/// The system error due at a point.
pub fn file(point: &str) -> io::Result<()> {
    if plan().is_some_and(|plan| plan.due(point, 1).is_some()) { strike() } else { Ok(()) }
}

/// Returns the number of the next `len` bytes at a point that precede the fault, if it is among them; they must be
/// written before [`strike`].
pub fn bytes(point: &str, len: usize) -> Option<usize> {
    plan()?.due(point, len as u64).map(|before| before as usize)
}

/// Makes the fault happen.
pub fn strike() -> io::Result<()> {
    match plan().map(|plan| plan.action) {
        Some(Action::Kill) => {
            #[cfg(unix)]
            let _ = signal_hook::low_level::raise(signal_hook::consts::SIGKILL);
            std::process::abort()
        }
        Some(Action::Hang) => {
            let _ = writeln!(io::stderr(), "fault: hanging");
            std::thread::sleep(PATIENCE);
            std::process::abort()
        }
        Some(_) => Err(ErrorKind::StorageFull.into()),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_due_once_and_where_it_was_asked_for() {
        let plan = FaultPlan::parse("disk-full@output/byte:10").unwrap();
        assert_eq!(plan.action, Action::DiskFull);
        assert_eq!(plan.due("output/rename", 100), None);
        assert_eq!([9, 5, 100].map(|units| plan.due("output/byte", units)), [None, Some(0), None]);
        let first = FaultPlan::parse("kill@submit").unwrap();
        assert_eq!([1, 1].map(|units| first.due("submit", units)), [Some(0), None]);
        let again = FaultPlan::parse("device-lost@wait:2,4").unwrap();
        assert_eq!([1, 1, 1, 1, 1].map(|units| again.due("wait", units)), [None, Some(0), None, Some(0), None]);
        let wrong = ["", "kill", "kill@nowhere", "kill@submit:0", "kill@submit:x", "burn@submit", "kill@submit:3,3"];
        for wrong in wrong {
            assert!(FaultPlan::parse(wrong).is_none(), "{wrong}");
        }
    }
}
