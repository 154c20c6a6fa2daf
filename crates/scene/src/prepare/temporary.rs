//! Temporary files of words of 32 bits, which are written and read in any order.

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use pellucid_fault as fault;

/// A file without a name: it goes with the process.
#[derive(Debug)]
pub(super) struct TemporaryFile(Mutex<File>);

impl TemporaryFile {
    /// Returns an empty one in a folder.
    pub fn new(folder: &Path) -> Result<Self> {
        Ok(Self(Mutex::new(tempfile::tempfile_in(folder)?)))
    }

    /// Writes words from a place on.
    pub fn write(&self, start: u64, words: &[u32]) -> Result<()> {
        let mut file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(4 * start))?;
        fault::write_all(&mut *file, bytemuck::cast_slice(words))
    }

    /// Reads words from a place on.
    pub fn read(&self, start: u64, words: &mut [u32]) -> Result<()> {
        let mut file = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(4 * start))?;
        file.read_exact(bytemuck::cast_slice_mut(words))
    }
}
