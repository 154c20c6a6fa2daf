//! Folders that tests read.

use std::path::{Path, PathBuf};

use crate::skip::{NO_DATA, skip};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The folder of compiled shaders that suites share, tests in one process and programs that tests start:
/// `PELLUCID_CACHE_DIR`, which `tools/test.sh` sets, or else a folder beside the test binaries.
pub fn shader_cache() -> PathBuf {
    let named = std::env::var_os("PELLUCID_CACHE_DIR").filter(|folder| !folder.is_empty());
    let beside = || {
        let program = std::env::current_exe().expect("this program has a path");
        // target/debug/deps/cli-…
        program.ancestors().nth(3).map_or_else(std::env::temp_dir, |target| target.join("shaders"))
    };
    named.map_or_else(beside, PathBuf::from)
}

/// A folder of real clouds.
pub struct Clouds {
    folder: PathBuf,
    /// True if files may be missing: tests/data holds only some.
    is_subset: bool,
}

impl Clouds {
    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// True for the subset.
    pub fn is_subset(&self) -> bool {
        self.is_subset
    }

    /// A file of it, as `models/dragon.ply`; `None` where the subset lacks it.
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        let path = self.folder.join(name);
        (!self.is_subset || path.is_file()).then_some(path)
    }
}

/// Folders of real clouds to test with: the subset in the repository, and [`whole_clouds`] where they are.
#[track_caller]
pub fn clouds() -> Vec<Clouds> {
    let subset = Clouds { folder: root().join("tests/data"), is_subset: true };
    let whole = whole_clouds().map(|folder| Clouds { folder, is_subset: false });
    [Some(subset), whole].into_iter().flatten().collect()
}

/// The folder of all real clouds: `PELLUCID_TEST_DATA`, by default `../shared/data` beside the repository. Where it is
/// absent what needs it is skipped.
#[track_caller]
pub fn whole_clouds() -> Option<PathBuf> {
    let named = std::env::var_os("PELLUCID_TEST_DATA").map(PathBuf::from);
    let path = named.unwrap_or_else(|| root().join("../shared/data"));
    if !path.is_dir() {
        skip(NO_DATA, &format!("no folder {}", path.display()));
        return None;
    }
    Some(path)
}
