//! Output files by their names: checked before the work, written whole or not at all after it.

use std::io;
use std::path::{Path, PathBuf};

use super::Error;
use crate::atomic::{self, NewFolder, Staged, Writer};

/// Checks that `path` names a file in a folder that exists and takes files.
///
/// # Errors
/// A missing folder, a folder of that name, and what the system says of a file made there.
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
        return Err(Error::IsFolder { path: path.to_owned() });
    }
    // Devices and pipes are written to where they are.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    atomic::probe(folder).map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// Checks that a report can be written into `folder`, which need not be there yet.
///
/// # Errors
/// A file of that name or in the place of one of its folders, and what the system says of a file made there.
pub fn check_report_folder(folder: &Path) -> Result<(), Error> {
    let there = nearest(folder).unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(Error::NotAFolder { path: folder.to_owned(), file: there.to_owned() });
    }
    atomic::probe(there).map_err(|source| Error::Write { path: folder.to_owned(), source })
}

/// Makes a folder for a report where there is none. If nothing comes into it, it goes with the result.
///
/// # Errors
/// What the system says.
pub fn make_folder(folder: &Path) -> Result<NewFolder, Error> {
    NewFolder::make(folder).map_err(|source| Error::Write { path: folder.to_owned(), source })
}

/// The part of a path that exists; `None` if that is the current folder.
fn nearest(path: &Path) -> Option<&Path> {
    path.ancestors().filter(|part| !part.as_os_str().is_empty()).find(|part| part.symlink_metadata().is_ok())
}

/// Writes to a temporary name in the folder of `path` and renames: afterwards there is the new file, or, after an
/// error, what was there before.
///
/// # Errors
/// Those of [`check_folder`], and what `write` or the system says.
pub fn write_atomically<W>(path: &Path, write: W) -> Result<(), Error>
where
    W: FnOnce(&mut Writer) -> io::Result<()>,
{
    let mut files = Files::default();
    files.add(path, write)?;
    files.publish()
}

/// Files of which none gets its name before all are complete.
#[derive(Debug, Default)]
pub struct Files(Vec<(PathBuf, Staged)>);

impl Files {
    /// Writes one more, under a temporary name.
    ///
    /// # Errors
    /// Those of [`check_folder`], and what `write` or the system says; nothing is left of the others then.
    pub fn add<W>(&mut self, path: &Path, write: W) -> Result<(), Error>
    where
        W: FnOnce(&mut Writer) -> io::Result<()>,
    {
        check_folder(path)?;
        let staged = Staged::write(path, write).map_err(|source| Error::Write { path: path.to_owned(), source })?;
        self.0.push((path.to_owned(), staged));
        Ok(())
    }

    /// Gives all of them their names, in the order in which they were added.
    ///
    /// # Errors
    /// What the system says.
    pub fn publish(self) -> Result<(), Error> {
        self.0.into_iter().try_for_each(|(path, staged)| {
            staged.publish(&path).map_err(|source| Error::Write { path: path.clone(), source })
        })
    }
}
