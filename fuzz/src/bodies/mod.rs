//! Fuzz bodies, a function for each reader of outside data. An input is a file's content, if need be with a
//! first byte or line that says what else is given; nothing that is in an input may make a body panic.

mod cloud;
mod pages;
mod path;
mod pictures;
mod prepared;
mod profile;
mod scene;
mod splats;
mod store;
mod volume;

use std::path::Path;

use super::harness::Body;

pub use cloud::{e57, las, pcd, ply, text};
pub use path::path;
pub use pictures::{compare, photo};
pub use prepared::prepared;
pub use profile::profile;
pub use scene::{polygon, scene};
pub use splats::splats;
pub use store::{copc, ept, octree};
pub use volume::volume;

/// Bodies by name, which is that of the target and of its corpus.
pub const TARGETS: [(&str, Body); 17] = [
    ("ply", ply),
    ("splats", splats),
    ("las", las),
    ("copc", copc),
    ("ept", ept),
    ("octree", octree),
    ("e57", e57),
    ("pcd", pcd),
    ("text", text),
    ("scene", scene),
    ("photo", photo),
    ("compare", compare),
    ("volume", volume),
    ("profile", profile),
    ("prepared", prepared),
    ("path", path),
    ("polygon", polygon),
];

/// Hands the path of a file with some content on. The file is gone afterwards.
fn with_file<T>(name: &str, content: &[u8], then: impl FnOnce(&Path) -> T) -> T {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("room for a temporary file");
    then(&path)
}
