//! What windows meet: window managers, screens of high density, files that are dropped, many sizes, compositors. As
//! `tests/viewer.rs`; without ctwm or cage those tests that need them are skipped with a note.
#![cfg(all(target_os = "linux", feature = "viewer"))]

#[path = "viewer"]
mod viewer {
    pub mod display;
    pub mod garden;
    pub mod window;
    pub mod x11;
}

mod viewer_window {
    mod density;
    mod dropped;
    mod leaks;
    mod managed;
    mod wayland;
}
