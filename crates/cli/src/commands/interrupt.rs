//! Handling of signals, so that no file is left half-written. The program still ends by the signal, unless a command
//! asks to finish its current step first.

use std::io;
use std::process::{Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The status of a program that was interrupted (128 + SIGINT).
pub const STATUS: u8 = 130;

/// True if the first SIGINT only sets [`asked`] instead of ending the program.
static DEFERRED: AtomicBool = AtomicBool::new(false);

/// True once that SIGINT has arrived.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Defers interruptions: the first SIGINT only makes [`asked`] true; a second one ends the program. On systems without
/// signals an interruption ends it at once.
pub fn defer() {
    DEFERRED.store(true, Ordering::Relaxed);
}

/// True if the user wants the program to stop.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// The other program that works for this one, if there is one.
static HELPER: Mutex<Option<Child>> = Mutex::new(None);

fn helper() -> MutexGuard<'static, Option<Child>> {
    HELPER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Child process that ends with this value, and when a signal ends this program. There is one at a time.
pub struct Helper(());

impl Helper {
    /// Takes a program that was started.
    pub fn keep(child: Child) -> Self {
        *helper() = Some(child);
        Self(())
    }

    /// Returns the exit status of the child process, if it has ended.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn try_wait(&self) -> io::Result<Option<ExitStatus>> {
        helper().as_mut().map_or_else(|| Err(io::ErrorKind::NotFound.into()), Child::try_wait)
    }

    /// Ends it.
    pub fn kill(&self) {
        if let Some(child) = helper().as_mut() {
            // It may have ended by itself.
            let _ = child.kill();
        }
    }
}

impl Drop for Helper {
    fn drop(&mut self) {
        if let Some(mut child) = helper().take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

#[cfg(not(unix))]
pub fn watch() {}

#[cfg(unix)]
pub use signals::watch;

#[cfg(unix)]
mod signals {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use pellucid_core::atomic;
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::{flag, low_level};

    use super::{ASKED, DEFERRED, helper};

    /// Makes SIGINT, SIGTERM and SIGHUP remove unfinished files before they end the program. A signal that was
    /// ignored from the start, as under `nohup` or for background jobs of a shell, stays ignored.
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
                if let Some(child) = helper().as_mut() {
                    let _ = child.kill();
                }
                let _unfinished = atomic::discard_unfinished();
                let _ = low_level::emulate_default_handler(signal);
            }
        });
    }

    /// The ignored signals, one bit each, starting with SIGHUP; none if the system doesn't report them.
    fn ignored() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}
