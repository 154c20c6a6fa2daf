//! Files written here byte by byte or by other libraries, read back; damaged files; and real ones where there are any.

mod bad;
mod docs;
pub mod e57;
pub mod las;
mod meant;
mod octree;
mod octree_bad;
mod pcd;
pub mod ply;
pub mod real;
mod splats;
mod text;

use std::path::{Path, PathBuf};

use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use tempfile::TempDir;

/// A folder with one file in it, gone after the test.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn load(path: &Path) -> Result<Cloud, pellucid_io::Error> {
    pellucid_io::load(path, &Progress::hidden())
}

/// Loads some bytes as a file of that name.
fn load_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<Cloud, pellucid_io::Error> {
    load(&Folder::new().file(name, bytes))
}

/// Asserts that loading fails, and that the message starts with the file and says each of some things.
#[track_caller]
fn assert_refused(name: &str, bytes: impl AsRef<[u8]>, says: &[&str]) {
    let folder = Folder::new();
    let path = folder.file(name, bytes);
    let message = load(&path).expect_err("loaded").to_string();
    assert!(message.starts_with(&format!("{}: ", path.display())), "{message}");
    for words in says {
        assert!(message.contains(words), "`{words}` is not in: {message}");
    }
}
