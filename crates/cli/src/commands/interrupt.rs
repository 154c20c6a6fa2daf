//! What a signal leaves: nothing half-written. The program ends by the signal, as it would without this module, unless a command
//! asks to finish first what it is at.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the first SIGINT is told by [`asked`] instead of ending the program.
static DEFERRED: AtomicBool = AtomicBool::new(false);

/// Whether it came.
static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first SIGINT only makes [`asked`] true; a second one ends the program. Where there are no signals an
/// interruption ends it at once.
pub fn defer() {
    DEFERRED.store(true, Ordering::Relaxed);
}

/// Whether somebody wants the program to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

#[cfg(not(unix))]
pub fn watch() {}

#[cfg(unix)]
pub use signals::watch;

#[cfg(unix)]
mod signals {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use pellucid_engine::atomic;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::{flag, low_level};

    use super::{ASKED, DEFERRED};

    /// From now on SIGINT, SIGTERM and SIGHUP remove what is unfinished before they end the program. A signal that was ignored
    /// from the start, as `nohup` and shells for jobs in the background have it, stays so.
    pub fn watch() {
        // A file that grows over `ulimit -f` is then an error like that of a full disk, and not the end of the program.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        let ignored = ignored();
        let watched = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
        // Without it a signal ends the program all the same, and may leave a temporary file.
        let Ok(mut signals) = Signals::new(watched) else { return };
        std::thread::spawn(move || {
            for signal in signals.forever() {
                let deferred = signal == SIGINT && DEFERRED.load(Ordering::Relaxed);
                if deferred && !ASKED.swap(true, Ordering::Relaxed) {
                    continue;
                }
                let _unfinished = atomic::discard_unfinished();
                let _ = low_level::emulate_default_handler(signal);
            }
        });
    }

    /// The signals that are ignored, a bit for each from SIGHUP on; none where the system doesn't tell.
    fn ignored() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}
