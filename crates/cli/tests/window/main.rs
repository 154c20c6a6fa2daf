//! The window of `pellucid view` on displays without a screen, with a real pointer and real keys. Without Xvfb and
//! xdotool these tests are skipped with a note, or fail if `PELLUCID_REQUIRE_GPU` is 1.
#![cfg(all(unix, feature = "viewer"))]

mod viewer;
mod viewer_loss;
mod viewer_path;
#[cfg(target_os = "linux")]
mod viewer_window;
