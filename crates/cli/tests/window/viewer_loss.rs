//! The window's behavior when the device is lost or out of memory, and when it is closed in the middle of the work.
//! Like `viewer.rs`; `PELLUCID_FAULT` (src/fault.rs, debug builds) places a fault.

mod closed;
mod lost;
