//! Threads that do work. A thread that has finished waits for more work: each thread keeps memory of its own, so that
//! the memory of a new thread for each call would add up.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::{io, thread};

/// Stack size in bytes: that of the main thread of a program, which translates shaders elsewhere.
const STACK: usize = 8 << 20;

/// Work. The closure that it returns is called once its thread is free again, and wakes the caller that waits.
type Job = Box<dyn FnOnce() -> Box<dyn FnOnce()> + Send>;

/// Threads that have nothing to do.
static IDLE: Mutex<Vec<Sender<Job>>> = Mutex::new(Vec::new());

fn rest(worker: Sender<Job>) {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(worker);
}

/// Runs work on a free thread, or else a new one. The closure that it returns is called on the same thread.
///
/// # Errors
/// Returns an error if the system gives no more threads.
pub fn start<D: FnOnce() + 'static>(work: impl FnOnce() -> D + Send + 'static) -> io::Result<()> {
    let free = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let worker = free.map_or_else(new, Ok)?;
    let job: Job = Box::new(move || Box::new(work()));
    worker.send(job).map_err(|error| io::Error::other(error.to_string()))
}

/// Starts a thread. It ends when its work panics, or else with the process.
fn new() -> io::Result<Sender<Job>> {
    let (sender, jobs) = channel::<Job>();
    let own = sender.clone();
    let name = "pellucid".to_owned();
    thread::Builder::new().name(name).stack_size(STACK).spawn(move || {
        for job in jobs {
            let tell = job();
            // First, so that the woken caller finds it free.
            rest(own.clone());
            tell();
        }
    })?;
    Ok(sender)
}
