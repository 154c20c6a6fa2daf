//! Forked processes. They have neither the threads nor the device of their parent, and get an error instead of hanging.

use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::failure::Failure;

/// Id of the process that has used pellucid; 0 until one has.
static USED_BY: AtomicU32 = AtomicU32::new(0);

/// Notes that this process uses pellucid.
///
/// # Errors
/// Returns an error if the process was forked from one that had used pellucid already.
pub fn enter() -> Result<(), Failure> {
    let this = process::id();
    match USED_BY.compare_exchange(0, this, Ordering::AcqRel, Ordering::Acquire) {
        Err(other) if other != this => Err(Failure::Refused(format!(
            "this process was forked from process {other} after pellucid had been used there: the copy has neither its threads nor its \
             device. Start workers anew instead, as in multiprocessing.get_context(\"spawn\"), or use pellucid only in the workers"
        ))),
        _ => Ok(()),
    }
}

/// Value of a device, which a forked process must leave alone even at its end.
pub struct Kept<T> {
    /// Name for error messages.
    name: &'static str,
    value: Option<T>,
    process: u32,
}

impl<T> Kept<T> {
    pub fn new(name: &'static str, value: T) -> Self {
        Self { name, value: Some(value), process: process::id() }
    }

    /// Returns the value, unless it was closed.
    pub fn get(&mut self) -> Result<&mut T, Failure> {
        let name = self.name;
        self.value.as_mut().ok_or_else(|| Failure::Value(format!("this {name} was closed; make another one")))
    }

    /// Ends it early.
    pub fn close(&mut self) {
        let value = self.value.take();
        if self.process != process::id() {
            std::mem::forget(value);
        }
    }
}

impl<T> Drop for Kept<T> {
    fn drop(&mut self) {
        self.close();
    }
}
