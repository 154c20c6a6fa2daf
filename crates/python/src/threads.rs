//! Threads that work is done on. One that has finished waits for more: each thread has memory of its own that it keeps, so
//! that a new one for each call would add up.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::{io, thread};

/// As much as the main thread of a program has, which shaders are translated on elsewhere.
const STACK: usize = 8 << 20;

/// Work. What it returns is called once its thread is free again, and tells whoever waits.
type Job = Box<dyn FnOnce() -> Box<dyn FnOnce()> + Send>;

/// The threads that have nothing to do.
static IDLE: Mutex<Vec<Sender<Job>>> = Mutex::new(Vec::new());

fn rest(worker: Sender<Job>) {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(worker);
}

/// Has a thread do this: one that is free, else a new one. What is returned is called on the same thread.
///
/// # Errors
/// The system gives no more threads.
pub fn start<D: FnOnce() + 'static>(work: impl FnOnce() -> D + Send + 'static) -> io::Result<()> {
    let free = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let worker = free.map_or_else(new, Ok)?;
    let job: Job = Box::new(move || Box::new(work()));
    worker.send(job).map_err(|error| io::Error::other(error.to_string()))
}

/// A thread. It ends with a panic of its work, and else with the process.
fn new() -> io::Result<Sender<Job>> {
    let (sender, jobs) = channel::<Job>();
    let own = sender.clone();
    let name = "pellucid".to_owned();
    thread::Builder::new().name(name).stack_size(STACK).spawn(move || {
        for job in jobs {
            let tell = job();
            // First, so that whoever is told finds it free.
            rest(own.clone());
            tell();
        }
    })?;
    Ok(sender)
}
