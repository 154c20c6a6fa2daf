//! Output files by their names: checked before the work, written whole or not at all after it.

use std::io;
use std::path::{Path, PathBuf};

use super::Error;
use pellucid_core::atomic::{self, NewFolder, Staged, Writer};

/// Checks that `path` names a file in an existing, writable folder.
///
/// # Errors
/// The folder is missing, `path` is a folder, or the system refuses a file there.
pub fn check_folder(path: &Path) -> Result<(), Error> {
    let folder = atomic::folder(path);
    if !folder.is_dir() {
        let (path, folder) = (path.to_owned(), folder.to_owned());
        let file = nearest(&folder).filter(|there| !there.is_dir()).map(Path::to_owned);
        return Err(match file {
            Some(file) => Error::NotAFolder { path, file },
            None => Error::NoFolder { path, folder },
        });
    }
    if path.is_dir() || path.file_name().is_none() {
        return Err(Error::IsFolder(path.to_owned()));
    }
    // Devices and pipes are written to where they are.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    atomic::probe(folder).map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// Checks that a report can be written into `folder`, which need not exist yet.
///
/// # Errors
/// A file exists in place of the folder or one of its parents, or the system refuses a file there.
pub fn check_report_folder(folder: &Path) -> Result<(), Error> {
    let there = nearest(folder).unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(Error::NotAFolder { path: folder.to_owned(), file: there.to_owned() });
    }
    atomic::probe(there).map_err(|source| Error::Write { path: folder.to_owned(), source })
}

/// Creates a folder for a report if it doesn't exist. If it stays empty, dropping the result removes it.
///
/// # Errors
/// Errors of the system.
pub fn make_folder(folder: &Path) -> Result<NewFolder, Error> {
    NewFolder::make(folder).map_err(|source| Error::Write { path: folder.to_owned(), source })
}

/// The part of a path that exists; `None` if that is the current folder.
fn nearest(path: &Path) -> Option<&Path> {
    path.ancestors().filter(|part| !part.as_os_str().is_empty()).find(|part| part.symlink_metadata().is_ok())
}

/// Writes to a temporary name in the folder of `path` and renames. Afterwards the new file exists, or, after an error,
/// the earlier one.
///
/// # Errors
/// Returns the errors of [`check_folder`], of `write` and of the system.
pub fn write_atomically<W>(path: &Path, write: W) -> Result<(), Error>
where
    W: FnOnce(&mut Writer) -> io::Result<()>,
{
    let mut files = Files::default();
    files.add(path, write)?;
    files.publish()
}

/// Files that get their names only when all are complete.
#[derive(Debug, Default)]
pub struct Files(Vec<(PathBuf, Staged)>);

impl Files {
    /// Writes one more file under a temporary name.
    ///
    /// # Errors
    /// Returns the errors of [`check_folder`], of `write` and of the system; the other files are then removed.
    pub fn add<W>(&mut self, path: &Path, write: W) -> Result<(), Error>
    where
        W: FnOnce(&mut Writer) -> io::Result<()>,
    {
        check_folder(path)?;
        let staged = Staged::write(path, write).map_err(|source| Error::Write { path: path.to_owned(), source })?;
        self.0.push((path.to_owned(), staged));
        Ok(())
    }

    /// Gives all files their names, in the order in which they were added.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn publish(self) -> Result<(), Error> {
        self.0.into_iter().try_for_each(|(path, staged)| {
            staged.publish(&path).map_err(|source| Error::Write { path: path.clone(), source })
        })
    }
}
