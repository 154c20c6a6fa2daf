//! The environment of windows: window managers, screens of high density, dropped files, many sizes, compositors. Like
//! `viewer.rs`; without ctwm or cage the tests that need them are skipped with a note.

mod density;
mod dropped;
mod leaks;
mod managed;
mod wayland;
