//! What the window does when the device is lost or has no memory left, and when it is closed in the middle of the work. As
//! `viewer.rs`; `PELLUCID_FAULT` (src/fault.rs, debug builds) says where a fault happens.

mod closed;
mod lost;
