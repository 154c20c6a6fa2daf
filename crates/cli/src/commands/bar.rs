//! The progress bar on standard error.

use std::fmt::Display;
use std::ops::Deref;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pellucid_core::progress::{Observer, Progress};
use pellucid_session::Messages;

use super::console::Console;

/// Work that is done within this time shows no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Interval at which a stage of unknown length signals that it is alive.
const TICK: Duration = Duration::from_millis(200);

/// A progress bar, the progress that it shows, and the console for everything else.
pub struct Bar {
    pub console: Console,
    shown: ProgressBar,
    progress: Progress,
}

/// Forwards the engine's progress to a progress bar.
struct BarObserver(ProgressBar);

impl Observer for BarObserver {
    fn stage(&self, name: &str) {
        self.0.set_message(name.to_owned());
    }

    fn advanced(&self, done: u64, total: Option<u64>) {
        if let Some(total) = total {
            self.0.set_length(total);
        }
        if done == 0 {
            // Time spent before the first step says nothing about the time per step.
            self.0.reset_eta();
        }
        self.0.set_position(done);
    }
}

impl Deref for Bar {
    type Target = Progress;

    fn deref(&self) -> &Progress {
        &self.progress
    }
}

/// Messages are printed without disturbing the bar.
impl Messages for Bar {
    fn warn(&self, warning: &dyn Display) {
        self.suspend(|| self.console.warn(warning));
    }

    fn note(&self, note: &dyn Display) {
        self.suspend(|| self.console.note(note));
    }

    fn detail(&self, detail: &dyn Display) {
        self.suspend(|| self.console.detail(detail));
    }
}

impl Bar {
    /// A bar that appears once the work has lasted a second, if it may appear at all.
    pub fn new(console: Console, visible: bool) -> Self {
        let shown = ProgressBar::hidden();
        if visible {
            if let Ok(style) = counted_style() {
                shown.set_style(style);
            }
            let weak = shown.downgrade();
            std::thread::spawn(move || {
                std::thread::sleep(PATIENCE);
                if let Some(bar) = weak.upgrade()
                    && !bar.is_finished()
                {
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                }
            });
        }
        Self { console, progress: Progress::observed(BarObserver(shown.clone())), shown }
    }

    /// Begins a stage of unknown length: the bar shows its name and the elapsed time.
    pub fn stage(&self, name: &str) {
        if let Ok(style) = ProgressStyle::with_template("{msg} {spinner} {elapsed}") {
            self.shown.set_style(style);
        }
        self.progress.set_message(name.to_owned());
        self.shown.reset_elapsed();
        self.shown.enable_steady_tick(TICK);
    }

    /// Begins a stage of `length` steps.
    pub fn counted(&self, name: &str, length: u64) {
        self.shown.disable_steady_tick();
        if let Ok(style) = counted_style() {
            self.shown.set_style(style);
        }
        self.shown.reset();
        self.progress.reset();
        self.progress.set_message(name.to_owned());
        self.progress.set_length(length);
    }

    /// Prints something without disturbing the bar.
    pub fn suspend<R>(&self, print: impl FnOnce() -> R) -> R {
        self.shown.suspend(print)
    }

    /// Takes the bar away.
    pub fn finish_and_clear(&self) {
        self.shown.finish_and_clear();
    }
}

fn counted_style() -> Result<ProgressStyle, indicatif::style::TemplateError> {
    ProgressStyle::with_template("{msg} {wide_bar} {percent:>3}% {eta:>4}")
}
