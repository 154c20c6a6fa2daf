//! The progress bar on standard error.

use std::fmt::Display;
use std::ops::Deref;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, WeakProgressBar};
use pellucid_core::progress::{Observer, Progress};
use pellucid_session::Messages;

use super::console::Console;

/// Work that is done within this time shows no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Interval at which a stage of unknown length signals that it is alive.
const TICK: Duration = Duration::from_millis(200);

/// Interval between two lines about progress where no bar can be shown.
const INTERVAL: Duration = Duration::from_secs(10);

/// Form in which progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// A bar on a terminal.
    Bar,
    /// Lines, for logs and pipes.
    Lines,
    Nothing,
}

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
    /// A bar that appears once the work has lasted a second. Without a terminal a line now and then stands for it, and
    /// nothing if nobody wants to see either.
    pub fn new(console: Console, shows: Shows) -> Self {
        let shown = ProgressBar::hidden();
        if shows == Shows::Lines {
            let weak = shown.downgrade();
            std::thread::spawn(move || remind(&weak, INTERVAL, |line| console.report(line)));
        }
        if shows == Shows::Bar {
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

/// Prints a line at each interval, until the work is done.
fn remind(bar: &WeakProgressBar, interval: Duration, print: impl Fn(String)) {
    let begin = Instant::now();
    loop {
        std::thread::sleep(interval);
        match bar.upgrade() {
            Some(bar) if !bar.is_finished() => {
                line(&bar.message(), bar.position(), bar.length(), begin.elapsed()).into_iter().for_each(&print);
            }
            _ => return,
        }
    }
}

/// The line about a stage; none without a name of it.
fn line(stage: &str, done: u64, all: Option<u64>, elapsed: Duration) -> Option<String> {
    let seconds = elapsed.as_secs();
    match all.filter(|all| *all > 0) {
        _ if stage.is_empty() => None,
        Some(all) => {
            let percent = 100 * u128::from(done.min(all)) / u128::from(all);
            Some(format!("progress: {stage}: {percent}% after {seconds} s"))
        }
        None => Some(format!("progress: {stage}, {seconds} s so far")),
    }
}

fn counted_style() -> Result<ProgressStyle, indicatif::style::TemplateError> {
    ProgressStyle::with_template("{msg} {wide_bar} {percent:>3}% {eta:>4}")
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_line_says_what_is_done_of_what() {
        let after = |stage, done, all| line(stage, done, all, Duration::from_millis(41_900));
        assert_eq!(after("frames", 3, Some(8)).as_deref(), Some("progress: frames: 37% after 41 s"));
        assert_eq!(after("uploading", 0, None).as_deref(), Some("progress: uploading, 41 s so far"));
        assert_eq!((after("", 1, Some(2)), after("x", 9, Some(3)).is_some()), (None, true));
    }

    #[test]
    fn lines_come_until_the_work_is_done() {
        let bar = ProgressBar::hidden();
        bar.set_message("searching");
        let (weak, lines) = (bar.downgrade(), Mutex::new(Vec::new()));
        std::thread::scope(|scope| {
            scope.spawn(|| remind(&weak, Duration::from_millis(5), |line| lines.lock().unwrap().push(line)));
            while lines.lock().unwrap().len() < 2 {
                std::thread::yield_now();
            }
            bar.finish_and_clear();
        });
        assert!(lines.lock().unwrap().iter().all(|line| line.starts_with("progress: searching, ")));
    }
}
