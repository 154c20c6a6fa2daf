//! Checks of all methods alike, and the pages that reports write.

mod check;
mod determinism;
mod popping;
mod profiler;
mod stopped;
mod stores;
mod stress;
mod tradeoff_page;

use std::panic::resume_unwind;
use std::thread;

/// Runs both halves of a long test at the same time, so that no core idles where such a test is the last one. Returns
/// their results; a panic of one becomes that of the test.
fn by_halves<T: Send>(run: impl Fn(usize) -> T + Sync) -> [T; 2] {
    // Skipped tests print the name of their thread.
    let name = thread::current().name().unwrap_or("main").to_owned();
    thread::scope(|scope| {
        let run = &run;
        let start = |half| thread::Builder::new().name(name.clone()).spawn_scoped(scope, move || run(half));
        let started = [0, 1].map(|half| start(half).expect("a thread"));
        // Waits for both before it panics.
        let ended = started.map(thread::ScopedJoinHandle::join);
        ended.map(|result| result.unwrap_or_else(|panic| resume_unwind(panic)))
    })
}
