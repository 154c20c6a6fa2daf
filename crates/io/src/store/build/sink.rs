//! Files of a build, which grow at their ends and are only part of a store when it is whole.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use crate::Error;
use pellucid_fault as fault;

/// A file that bytes are put behind.
#[derive(Debug)]
pub(super) struct Sink {
    path: PathBuf,
    file: File,
    len: u64,
}

impl Sink {
    /// Returns a file with its first bytes, as many as are to be kept; they must be there.
    pub fn keep(path: &Path, len: u64) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_path_buf(), source };
        fault::file("output/create").map_err(failed)?;
        let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(path).map_err(failed)?;
        let found = file.metadata().map_err(failed)?.len();
        if found < len {
            let what = format!("{len} bytes of an earlier run are needed, but the file has {found}");
            return Err(Error::Truncated { path: path.to_path_buf(), what });
        }
        file.set_len(len).map_err(failed)?;
        io::Seek::seek(&mut file, io::SeekFrom::Start(len)).map_err(failed)?;
        Ok(Self { path: path.to_path_buf(), file, len })
    }

    /// Returns an empty file.
    pub fn new(path: &Path) -> Result<Self, Error> {
        Self::keep(path, 0)
    }

    /// Writes a whole file to the disk.
    pub fn put(path: &Path, parts: &[&[u8]]) -> Result<(), Error> {
        let mut file = Self::new(path)?;
        parts.iter().try_for_each(|bytes| file.write(bytes))?;
        file.sync()
    }

    /// Returns its bytes so far.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Puts bytes behind the others.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), Error> {
        fault::write_all(&mut self.file, bytes).map_err(|source| Error::Write { path: self.path.clone(), source })?;
        self.len += bytes.len() as u64;
        Ok(())
    }

    /// Flushes to the disk: some file systems report only then that they are full.
    pub fn sync(&mut self) -> Result<(), Error> {
        self.file.sync_data().map_err(|source| Error::Write { path: self.path.clone(), source })
    }
}
