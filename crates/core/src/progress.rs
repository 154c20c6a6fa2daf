//! Progress of long work, and requests to cancel it.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Somebody who watches long work. It is called from several threads, and often: once for each few thousand points or
/// for each window of an image.
pub trait Observer: Send + Sync {
    /// A stage has begun, as in `reading scan.laz`.
    fn stage(&self, _name: &str) {}

    /// `done` steps of the stage are finished; the total may be unknown.
    fn advanced(&self, _done: u64, _total: Option<u64>) {}

    /// Returns `true` if the work should end early. A renderer asks before each submission to the device, and then
    /// fails with `Cancelled`.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Somebody who watches wanted the work to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

/// Phase of the host's work, in the order of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// Reads files, or generates the built-in scene.
    Read,
    /// Finds radii, normals, fields, colors.
    Prepare,
    /// Puts points into the order of the method.
    Order,
    /// Opens the device and copies points to it.
    Upload,
    /// Makes pipelines of shaders.
    Compile,
    /// Renders, and waits for the device.
    Frame,
    /// Encodes and writes the picture.
    Write,
}

impl Phase {
    /// All, in order.
    pub const ALL: [Self; 7] =
        [Self::Read, Self::Prepare, Self::Order, Self::Upload, Self::Compile, Self::Frame, Self::Write];

    /// Returns the name that profiles use.
    pub fn name(self) -> &'static str {
        ["read", "prepare", "order", "upload", "compile", "frame", "write"][self as usize]
    }
}

/// A stretch of time that belongs to one phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// The phase.
    pub phase: Phase,
    /// Time when the phase began.
    pub begin: Instant,
    /// Duration of the phase.
    pub length: Duration,
}

/// The phases so far.
#[derive(Debug, Default)]
struct Clock {
    ended: Vec<Span>,
    running: Option<(Phase, Instant)>,
}

impl Clock {
    /// Begins a phase, which ends the one before it.
    fn begin(&mut self, phase: Phase) {
        if self.running.is_some_and(|(running, _)| running == phase) {
            return;
        }
        let now = Instant::now();
        self.ended.extend(self.running(now));
        self.running = Some((phase, now));
    }

    /// The phase that runs, up to now.
    fn running(&self, now: Instant) -> Option<Span> {
        self.running.map(|(phase, begin)| Span { phase, begin, length: now - begin })
    }
}

/// A handle on the progress of some work; clones are of the same work.
#[derive(Clone)]
pub struct Progress(Arc<State>);

struct State {
    message: Mutex<String>,
    /// [`UNKNOWN`] until the length is known.
    length: AtomicU64,
    position: AtomicU64,
    clock: Mutex<Clock>,
    observer: Option<Box<dyn Observer>>,
}

const UNKNOWN: u64 = u64::MAX;

impl Progress {
    /// Progress without an observer.
    pub fn hidden() -> Self {
        Self::with(None)
    }

    /// Progress with an observer.
    pub fn observed(observer: impl Observer + 'static) -> Self {
        Self::with(Some(Box::new(observer)))
    }

    fn with(observer: Option<Box<dyn Observer>>) -> Self {
        let (length, position) = (AtomicU64::new(UNKNOWN), AtomicU64::new(0));
        Self(Arc::new(State { message: Mutex::default(), length, position, clock: Mutex::default(), observer }))
    }

    /// Asks the observer if the work may go on.
    ///
    /// # Errors
    /// Returns an error if the work should end early.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.0.observer.as_ref().is_some_and(|observer| observer.is_cancelled()) { Err(Cancelled) } else { Ok(()) }
    }

    /// Begins a phase and ends the one before it. A phase that runs already goes on.
    pub fn begin(&self, phase: Phase) {
        self.0.clock.lock().unwrap_or_else(PoisonError::into_inner).begin(phase);
    }

    /// Returns the phases so far, one after another; the one that runs goes on, and is there up to now.
    /// [`Phase::Compile`] is for those who know a device to tell apart
    /// (`Device::compilations`).
    pub fn spans(&self) -> Vec<Span> {
        let clock = self.0.clock.lock().unwrap_or_else(PoisonError::into_inner);
        let running = clock.running(Instant::now());
        clock.ended.iter().copied().chain(running).collect()
    }

    /// Names the stage.
    pub fn set_message(&self, message: impl Into<Cow<'static, str>>) {
        let message = message.into();
        if let Some(observer) = &self.0.observer {
            observer.stage(&message);
        }
        *self.0.message.lock().unwrap_or_else(PoisonError::into_inner) = message.into_owned();
    }

    /// Returns the stage's name.
    pub fn message(&self) -> String {
        self.0.message.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Says how many steps the stage has.
    pub fn set_length(&self, steps: u64) {
        self.0.length.store(steps.min(UNKNOWN - 1), Ordering::Relaxed);
        self.tell();
    }

    /// Adds to the number of steps that the stage has.
    pub fn inc_length(&self, steps: u64) {
        self.set_length(self.length().unwrap_or(0).saturating_add(steps));
    }

    /// Returns the number of steps of the stage, if they are known.
    pub fn length(&self) -> Option<u64> {
        Some(self.0.length.load(Ordering::Relaxed)).filter(|length| *length != UNKNOWN)
    }

    /// Says how many steps are done.
    pub fn set_position(&self, done: u64) {
        self.0.position.store(done, Ordering::Relaxed);
        self.tell();
    }

    /// Adds to the steps that are done.
    pub fn inc(&self, steps: u64) {
        self.0.position.fetch_add(steps, Ordering::Relaxed);
        self.tell();
    }

    /// Returns the number of steps that are done.
    pub fn position(&self) -> u64 {
        self.0.position.load(Ordering::Relaxed)
    }

    /// Begins a stage with no step done.
    pub fn reset(&self) {
        self.set_position(0);
    }

    fn tell(&self) {
        if let Some(observer) = &self.0.observer {
            observer.advanced(self.position(), self.length());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Log(Mutex<Vec<String>>);

    impl Observer for Arc<Log> {
        fn stage(&self, name: &str) {
            self.0.lock().unwrap().push(name.to_owned());
        }

        fn advanced(&self, done: u64, total: Option<u64>) {
            self.0.lock().unwrap().push(format!("{done} of {total:?}"));
        }

        fn is_cancelled(&self) -> bool {
            self.0.lock().unwrap().len() > 3
        }
    }

    #[test]
    fn each_moment_counts_for_one_phase() {
        let pause = || std::thread::sleep(Duration::from_millis(2));
        let (progress, begin) = (Progress::hidden(), Instant::now());
        assert_eq!(progress.spans(), []);
        for phase in [Phase::Read, Phase::Frame, Phase::Frame, Phase::Read] {
            progress.begin(phase);
            pause();
        }
        let spans = progress.spans();
        assert!(spans[0].begin >= begin && spans.iter().map(|span| span.length).sum::<Duration>() <= begin.elapsed());
        assert_eq!(spans.iter().map(|span| span.phase).collect::<Vec<_>>(), [Phase::Read, Phase::Frame, Phase::Read]);
        assert!(spans.windows(2).all(|pair| pair[0].begin + pair[0].length == pair[1].begin), "{spans:?}");
        let at_least = [2, 4, 2].map(Duration::from_millis);
        assert!(spans.iter().zip(at_least).all(|(span, least)| span.length >= least), "{spans:?}");
        pause();
        let later = progress.spans();
        assert_eq!(later[..2], spans[..2], "they have ended");
        assert!(later[2].length >= spans[2].length + Duration::from_millis(2), "it runs");
        assert_eq!(Phase::ALL.map(|phase| Phase::ALL[phase as usize]), Phase::ALL);
    }

    #[test]
    fn an_observer_is_told_and_may_cancel() {
        let log = Arc::new(Log::default());
        let progress = Progress::observed(log.clone());
        progress.set_message("points");
        progress.inc(2);
        progress.clone().set_length(5);
        assert_eq!(progress.check(), Ok(()));
        progress.inc(3);
        assert_eq!(*log.0.lock().unwrap(), ["points", "2 of None", "2 of Some(5)", "5 of Some(5)"]);
        assert_eq!(progress.check(), Err(Cancelled));
        assert_eq!((progress.position(), progress.length(), progress.message()), (5, Some(5), "points".to_owned()));
        assert_eq!(Progress::hidden().check(), Ok(()));
    }
}
