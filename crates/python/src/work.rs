//! Work on a thread of its own, for which the caller waits without the interpreter's lock.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::failure::Failure;
use crate::fork;
use crate::talk::Talk;
use crate::threads;

/// Time between two checks of signals and progress.
const GLANCE: Duration = Duration::from_millis(25);

/// Time that interrupted work may take to end before it is left alone. Ctrl-C must take less than 0.2 s.
const GRACE: Duration = Duration::from_millis(50);

/// Number of threads that are at work, including those that nobody waits for.
static BUSY: AtomicU32 = AtomicU32::new(0);

struct Busy;

impl Busy {
    fn new() -> Self {
        BUSY.fetch_add(1, Ordering::AcqRel);
        Self
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        BUSY.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Does work, and raises its error as an exception. `listener` is called with (stage, done, total), on this thread and
/// with the lock held. KeyboardInterrupt ends the wait at once, and the work soon after.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    listener: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Talk) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    fork::enter()?;
    let (talk, (sender, receiver)) = (Talk::new(), sync_channel(1));
    let receiver = Mutex::new(receiver);
    let (busy, at_work) = (Busy::new(), talk.clone());
    threads::start(move || {
        let done = work(&at_work);
        drop(busy);
        // Nobody may be waiting any more.
        move || drop(sender.send(done))
    })?;
    let result = wait_for(py, &receiver, &talk, listener)?;
    talk.hand_over(py)?;
    if let (Some(listener), Ok(_)) = (listener, &result) {
        // Messages since the last glance.
        talk.tell(listener)?;
    }
    Ok(result?)
}

fn wait_for<T: Send>(
    py: Python<'_>,
    receiver: &Mutex<Receiver<Result<T, Failure>>>,
    talk: &Talk,
    listener: Option<&Bound<'_, PyAny>>,
) -> PyResult<Result<T, Failure>> {
    loop {
        let heard = match detached(py, receiver, GLANCE) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Disconnected) => {
                return Ok(Err(Failure::Refused(
                    "a bug in pellucid ended this call; what went wrong is on standard error".to_owned(),
                )));
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().and_then(|()| listener.map_or(Ok(()), |listener| talk.tell(listener)))
            }
        };
        if let Err(interruption) = heard {
            talk.cancel();
            let _unheard = detached(py, receiver, GRACE);
            return Err(interruption);
        }
    }
}

fn detached<T: Send>(
    py: Python<'_>,
    receiver: &Mutex<Receiver<Result<T, Failure>>>,
    limit: Duration,
) -> Result<Result<T, Failure>, RecvTimeoutError> {
    py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(limit))
}

/// Wait until interrupted work has ended, for at most `seconds`, before the process ends and takes the drivers away
/// that it uses. Another interruption ends the wait.
#[pyfunction]
pub fn wait(py: Python<'_>, seconds: f64) -> PyResult<()> {
    if fork::enter().is_err() {
        // Its threads were the parent's.
        return Ok(());
    }
    let limit = Duration::try_from_secs_f64(seconds).unwrap_or_default();
    let begin = Instant::now();
    while BUSY.load(Ordering::Acquire) > 0 && begin.elapsed() < limit {
        py.detach(|| thread::sleep(Duration::from_millis(5)));
        py.check_signals()?;
    }
    Ok(())
}
