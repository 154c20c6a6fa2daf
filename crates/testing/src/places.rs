//! Folders that tests read.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Folder of the real clouds: `PELLUCID_TEST_DATA`, by default `../shared/data` beside the repository. `None` (with a note)
/// where it is absent.
pub fn data() -> Option<PathBuf> {
    static FOUND: OnceLock<Option<PathBuf>> = OnceLock::new();
    FOUND
        .get_or_init(|| {
            let named = std::env::var_os("PELLUCID_TEST_DATA").map(PathBuf::from);
            let path = named.unwrap_or_else(|| root().join("../shared/data"));
            if path.is_dir() {
                return Some(path);
            }
            eprintln!("skipped: no real clouds at {}", path.display());
            None
        })
        .clone()
}
