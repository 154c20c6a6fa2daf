//! What windows meet: window managers, screens of high density, files that are dropped, many sizes, compositors. As
//! `viewer.rs`; without ctwm or cage those tests that need them are skipped with a note.

mod density;
mod dropped;
mod leaks;
mod managed;
mod wayland;
