//! Progress of a build, in a file of its folder, so that it can go on after its process ended.

use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use super::super::Store;
use super::checkpoint::Checkpoint;
use super::plan::ChunkPlan;
use super::survey::BuildSurvey;
use super::{Settings, sink};
use crate::Error;

/// The file.
const STATE: &str = "state.json";

/// Progress of a build.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct State {
    /// A hash of inputs and settings.
    key: String,
    /// Result of the first pass, once it is done.
    pub survey: Option<BuildSurvey>,
    /// Result of the second pass, once it is done.
    pub scattered: Option<Scattered>,
    /// Progress of the third pass, once it has begun.
    pub assembled: Option<Assembled>,
}

/// The result of the second pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Scattered {
    pub plan: ChunkPlan,
    /// The largest distance of a position from where it was.
    pub rounding: f64,
}

/// Chunks that are done, and the assembler after them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Assembled {
    pub chunks: usize,
    pub checkpoint: Checkpoint,
}

impl State {
    /// Loads the state of a folder, if it is of the same inputs and settings; else makes a new one, and an empty
    /// folder.
    pub fn load(folder: &Path, key: String) -> Result<Self, Error> {
        let read = || serde_json::from_slice::<Self>(&std::fs::read(folder.join(STATE)).ok()?).ok();
        if let Some(state) = read().filter(|state| state.key == key) {
            return Ok(state);
        }
        clear(folder)?;
        let failed = |source| Error::Write { path: folder.to_path_buf(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        Ok(Self { key, ..Self::default() })
    }

    /// Returns `true` if a folder has one.
    pub fn is_there(folder: &Path) -> bool {
        folder.join(STATE).exists()
    }

    /// Writes it down.
    pub fn save(&self, folder: &Path) -> Result<(), Error> {
        let path = folder.join(STATE);
        let text = serde_json::to_vec(self).map_err(std::io::Error::from);
        // Beside it first, so that there is always a whole one.
        let beside = folder.join("state.new");
        let text = text.map_err(|source| Error::Write { path: path.clone(), source })?;
        sink::Sink::new(&beside)?.write(&text)?;
        std::fs::rename(&beside, &path).map_err(|source| Error::Write { path, source })
    }
}

/// Removes a folder with all that is in it, if it is there.
pub(super) fn clear(folder: &Path) -> Result<(), Error> {
    match std::fs::remove_dir_all(folder) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Write { path: folder.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

/// Returns the folder in which a store is made, beside its place.
pub(super) fn work_folder(target: &Path) -> PathBuf {
    let name = target.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    pellucid_core::atomic::folder(target).join(format!(".{name}.pellucid-unfinished"))
}

/// Returns a hash of the inputs, by name, size and time, and of the settings.
pub fn key(inputs: &[Box<dyn Store>], settings: &Settings) -> String {
    let mut hasher = blake3::Hasher::new();
    let mut add = |text: String| {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    };
    // The second form of what an unfinished build keeps.
    add(format!("{} 2 {settings:?}", env!("CARGO_PKG_VERSION")));
    for input in inputs {
        let summary = input.summary();
        add(format!("{summary:?}"));
        files(&summary.path).iter().for_each(|path| add(stamp(path)));
    }
    hasher.finalize().to_hex().to_string()
}

/// A file, or the files in a folder and in those below: the tiles of EPT are in one.
fn files(path: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![path.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            // Links may lead back.
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if is_folder { &mut folders } else { &mut files }.push(entry.path());
        }
        files.push(folder);
    }
    files.sort_unstable();
    files
}

fn stamp(path: &Path) -> String {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let about = std::fs::metadata(path).ok();
    let size = about.as_ref().map(std::fs::Metadata::len);
    let time = about.and_then(|about| about.modified().ok()?.duration_since(UNIX_EPOCH).ok());
    format!("{} {size:?} {time:?}", absolute.display())
}
