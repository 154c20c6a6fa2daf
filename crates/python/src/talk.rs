//! Communication of work with its caller: progress, warnings, notes and cancellation.

use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pellucid_core::progress::{Observer, Progress};
use pellucid_session::Messages;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::failure::Failure;

/// Handle on some work, for both the thread that does it and the one that waits.
#[derive(Clone)]
pub struct Talk {
    pub progress: Progress,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    cancelled: AtomicBool,
    heard: Mutex<Heard>,
}

#[derive(Default)]
struct Heard {
    /// Stage, with the amount done and the total amount.
    stage: String,
    done: u64,
    total: Option<u64>,
    /// `true` if it was not reported yet.
    is_news: bool,
    warnings: Vec<String>,
    notes: Vec<String>,
}

impl Shared {
    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Listener(Arc<Shared>);

impl Observer for Listener {
    fn stage(&self, name: &str) {
        let mut heard = self.0.heard();
        (heard.stage, heard.done, heard.total, heard.is_news) = (name.to_owned(), 0, None, true);
    }

    fn advanced(&self, done: u64, total: Option<u64>) {
        let mut heard = self.0.heard();
        (heard.done, heard.total, heard.is_news) = (done, total, true);
    }

    fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }
}

impl Talk {
    pub fn new() -> Self {
        let shared = Arc::new(Shared::default());
        Self { progress: Progress::observed(Listener(Arc::clone(&shared))), shared }
    }

    /// Makes the work end at the next check.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Checks between two steps whether to go on.
    ///
    /// # Errors
    /// Returns an error if nobody waits any more.
    pub fn go_on(&self) -> Result<(), Failure> {
        self.progress.check().map_err(|_| Failure::Cancelled)
    }

    /// Calls `listener(stage, done, total)` if there is news.
    pub fn tell(&self, listener: &Bound<'_, PyAny>) -> PyResult<()> {
        let news = {
            let mut heard = self.shared.heard();
            let is_news = std::mem::take(&mut heard.is_news) && !heard.stage.is_empty();
            is_news.then(|| (heard.stage.clone(), heard.done, heard.total))
        };
        news.map_or(Ok(()), |news| listener.call1(news).map(drop))
    }

    /// Passes warnings and notes on, once.
    pub fn hand_over(&self, py: Python<'_>) -> PyResult<()> {
        let (warnings, notes) = {
            let mut heard = self.shared.heard();
            (std::mem::take(&mut heard.warnings), std::mem::take(&mut heard.notes))
        };
        if warnings.is_empty() && notes.is_empty() {
            return Ok(());
        }
        let lists = (PyList::new(py, warnings)?, PyList::new(py, notes)?);
        py.import("pellucid._errors")?.getattr("tell")?.call1(lists)?;
        Ok(())
    }
}

impl Messages for Talk {
    fn warn(&self, warning: &dyn Display) {
        self.shared.heard().warnings.push(warning.to_string());
    }

    fn note(&self, note: &dyn Display) {
        self.shared.heard().notes.push(note.to_string());
    }

    /// Returns the argument for an option of the command line.
    fn name(&self, option: &str) -> String {
        match option {
            "budget" => "budget_ms".to_owned(),
            _ => option.replace('-', "_"),
        }
    }

    fn option(&self, option: &str, value: &dyn Display) -> String {
        format!("{}={value}", self.name(option))
    }
}
