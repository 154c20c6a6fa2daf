//! What the window does when the device is lost or has no memory left, and when it is closed in the middle of the work. As
//! `tests/viewer.rs`; `PELLUCID_FAULT` (src/fault.rs, debug builds) says where a fault happens.
#![cfg(all(unix, feature = "viewer"))]

#[path = "viewer"]
mod viewer {
    pub mod display;
    pub mod garden;
    pub mod window;
}

mod viewer_loss {
    mod closed;
    mod lost;
}

#[path = "common/signals.rs"]
mod ignored;
