//! Removes leftovers of unfinished work: temporary files, and new folders that are still empty.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

/// All that is unfinished, in the order in which it was made.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn lock() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

fn forget(list: &mut Vec<PathBuf>, path: &Path) {
    list.retain(|other| other != path);
}

/// While it lives no output file appears.
#[derive(Debug)]
#[must_use]
pub struct Unfinished(#[expect(dead_code, reason = "held, not read")] MutexGuard<'static, Vec<PathBuf>>);

/// Removes unfinished files, for code that is about to end the program, such as a signal handler. Until the result is
/// dropped, no new file is started and none gets its name.
pub fn discard_unfinished() -> Unfinished {
    let list = lock();
    for path in list.iter().rev() {
        // An error can't be reported here.
        let _ = if path.is_dir() { fs::remove_dir(path) } else { fs::remove_file(path) };
    }
    Unfinished(list)
}

/// A temporary file; dropping it removes it.
#[derive(Debug)]
pub(super) struct Temporary(Option<NamedTempFile>);

impl Temporary {
    /// Returns a new one with the permissions that any new file gets.
    pub(super) fn make(folder: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".pellucid-").suffix(".tmp");
        // Temporary files are private by default.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut list = lock();
        let file = builder.tempfile_in(folder)?;
        list.push(file.path().to_owned());
        Ok(Self(Some(file)))
    }

    pub(super) fn file(&mut self) -> &mut File {
        self.0.as_mut().expect("there until it is dropped").as_file_mut()
    }

    /// Gives it its name.
    pub(super) fn persist(mut self, path: &Path) -> io::Result<()> {
        let Some(file) = self.0.take() else { return Ok(()) };
        let (temporary, mut list) = (file.path().to_owned(), lock());
        let persisted = file.persist(path).map(drop).map_err(|error| error.error);
        forget(&mut list, &temporary);
        persisted
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            let path = file.path().to_owned();
            drop(file);
            forget(&mut lock(), &path);
        }
    }
}

/// A folder that is there now, with those above it. Those of them that are new and still empty when this is dropped go
/// again.
#[derive(Debug)]
pub struct NewFolder(Vec<PathBuf>);

impl NewFolder {
    /// Creates a folder if it doesn't exist.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn make(folder: &Path) -> io::Result<Self> {
        let is_missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
        let mut missing: Vec<_> = folder.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        missing.reverse();
        let mut list = lock();
        list.extend(missing.iter().cloned());
        drop(list);
        // From here on, what was made of it goes again if the rest can't be.
        let new = Self(missing);
        fs::create_dir_all(folder)?;
        Ok(new)
    }
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        let mut list = lock();
        for path in self.0.iter().rev() {
            // A folder with content stays.
            let _ = fs::remove_dir(path);
            forget(&mut list, path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_folders_without_content_go_again() {
        let folder = tempfile::tempdir().unwrap();
        let (outer, inner) = (folder.path().join("a"), folder.path().join("a/b/c"));
        drop(NewFolder::make(&inner).unwrap());
        assert!(!outer.exists(), "empty ones");
        let new = NewFolder::make(&inner).unwrap();
        fs::write(folder.path().join("a/file"), "").unwrap();
        drop(new);
        assert!(outer.exists() && !folder.path().join("a/b").exists(), "what holds something stays");
        drop(NewFolder::make(&outer).unwrap());
        drop(NewFolder::make(folder.path()).unwrap());
        assert!(outer.exists(), "what was there stays");
        fs::write(folder.path().join("plain"), "").unwrap();
        assert!(NewFolder::make(&folder.path().join("plain/d")).is_err());
        assert!(NewFolder::make(&folder.path().join("e/f\0")).is_err() && !folder.path().join("e").exists());
    }
}
