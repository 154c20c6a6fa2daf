//! Progress, warnings and cancellation.

use std::fmt::Display;
use std::sync::Arc;

use pellucid_core::progress::{Observer as EngineObserver, Progress};
use pellucid_session::Messages;

/// Watches work: hears of its progress and of what does not come out as requested, and may cancel it.
pub trait Observer: Send + Sync {
    /// Hears that a stage has begun, as in `reading scan.laz`.
    fn stage(&self, _name: &str) {}

    /// Hears that `done` steps of the stage are finished; the total may be unknown.
    fn advanced(&self, _done: u64, _total: Option<u64>) {}

    /// Hears that something does not come out as requested: a sentence.
    fn warn(&self, _warning: &str) {}

    /// Hears something that many want to know: a sentence.
    fn note(&self, _note: &str) {}

    /// Returns `true` if the work should end early. Work asks before each submission to the device, and then fails with
    /// [`ErrorKind::Cancelled`](crate::ErrorKind::Cancelled).
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Observer that watches nothing.
struct Nobody;

impl Observer for Nobody {}

/// Observer as the engine and the session know it.
#[derive(Clone)]
pub(crate) struct Watcher(Arc<dyn Observer>);

impl Default for Watcher {
    fn default() -> Self {
        Self(Arc::new(Nobody))
    }
}

impl Watcher {
    pub fn new(observer: impl Observer + 'static) -> Self {
        Self(Arc::new(observer))
    }

    /// Returns the progress of one piece of work.
    pub fn progress(&self) -> Progress {
        Progress::observed(self.clone())
    }
}

impl EngineObserver for Watcher {
    fn stage(&self, name: &str) {
        self.0.stage(name);
    }

    fn advanced(&self, done: u64, total: Option<u64>) {
        self.0.advanced(done, total);
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

impl Messages for Watcher {
    fn warn(&self, warning: &dyn Display) {
        self.0.warn(&warning.to_string());
    }

    fn note(&self, note: &dyn Display) {
        self.0.note(&note.to_string());
    }

    fn name(&self, option: &str) -> String {
        option.replace('-', "_")
    }

    fn option(&self, option: &str, value: &dyn Display) -> String {
        format!("{}({value})", self.name(option))
    }
}
