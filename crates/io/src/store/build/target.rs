//! The folder of a store: looked at before the work, filled when it is done.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::super::octree::metadata::METADATA;
use super::super::octree::nodes::NODES;
use super::super::octree::survey::SURVEY;
use super::super::octree::{HIERARCHY, POINTS};
use super::Built;
use super::feeder::remove;
use super::state::{self, State};
use crate::Error;
use pellucid_core::atomic;
use pellucid_fault as fault;

/// Refuses a folder with files of others, before the work.
pub fn check_target(folder: &Path) -> Result<(), Error> {
    let failed = |source| Error::Write { path: folder.to_path_buf(), source };
    match fs::read_dir(folder) {
        Ok(mut entries) => {
            let is_ours = [METADATA, POINTS].iter().any(|file| folder.join(file).exists());
            if !is_ours && entries.next().is_some() {
                return Err(Error::Occupied(folder.to_path_buf()));
            }
            Ok(())
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(failed(error)),
    }
}

/// Makes the store of a folder in another one beside it, `.NAME.pellucid-unfinished`, and goes on there if an earlier
/// run of the same key ended early. `run` gets that folder and how far it is. On a full disk `bytes` is what the store
/// needs.
pub(super) fn make(
    folder: &Path,
    key: &str,
    bytes: u64,
    run: impl Fn(&Path, State) -> Result<Built, Error>,
) -> Result<Built, Error> {
    check_target(folder)?;
    let work = state::work_folder(folder);
    let state = State::load(&work, key.to_owned())?;
    let is_begun = state.survey.is_some() || state.assembled.is_some();
    let mut made = run(&work, state);
    if made.is_err() && !State::is_there(&work) {
        state::clear(&work)?;
    }
    // The files that an earlier run left are not whole: the work is done anew.
    let is_lost = |error: &Error| match error {
        Error::Read { path, .. } | Error::Truncated { path, .. } => path.starts_with(&work),
        Error::Write { path, source } => path.starts_with(&work) && source.kind() == ErrorKind::UnexpectedEof,
        _ => false,
    };
    if is_begun && made.as_ref().is_err_and(is_lost) {
        state::clear(&work)?;
        made = run(&work, State::load(&work, key.to_owned())?);
    }
    made.map_err(|error| with_need(error, bytes))
}

/// Says how much room is needed, if that is what lacks.
fn with_need(error: Error, bytes: u64) -> Error {
    match error {
        Error::Write { path, source } if source.kind() == ErrorKind::StorageFull => {
            let need = bytesize::ByteSize(bytes);
            let source = std::io::Error::new(ErrorKind::StorageFull, format!("{source}, and about {need} are needed"));
            Error::Write { path, source }
        }
        error => error,
    }
}

/// Gives the files their names, metadata.json last. A store that was there is none from the first of them on.
pub(super) fn publish(work: &Path, target: &Path, metadata: &str) -> Result<(), Error> {
    let failed = |path: PathBuf| move |source| Error::Write { path, source };
    write(&work.join(METADATA), metadata)?;
    fs::create_dir_all(target).map_err(failed(target.to_path_buf()))?;
    remove(&target.join(METADATA))?;
    // Not every store has one.
    remove(&target.join(SURVEY))?;
    for file in [POINTS, HIERARCHY, NODES, SURVEY].into_iter().filter(|file| work.join(file).exists()) {
        let to = target.join(file);
        let renamed = fault::file("output/rename").and_then(|()| fs::rename(work.join(file), &to));
        renamed.map_err(failed(to))?;
    }
    write(&target.join(METADATA), metadata)?;
    state::clear(work)
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    let written = atomic::write(path, |out| std::io::Write::write_all(out, text.as_bytes()));
    written.map_err(|source| Error::Write { path: path.to_path_buf(), source })
}

/// Returns the name of a store.
pub(super) fn name(target: &Path) -> String {
    target.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
