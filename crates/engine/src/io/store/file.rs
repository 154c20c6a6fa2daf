//! Files that several threads read at once.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::io::Error;

/// An open file.
#[derive(Debug)]
pub(crate) struct Shared {
    path: PathBuf,
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
    len: u64,
}

impl Shared {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let failed = |source: std::io::Error| match source.kind() {
            ErrorKind::NotFound => Error::Missing { path: path.to_path_buf() },
            _ => Error::Read { path: path.to_path_buf(), source },
        };
        let file = File::open(path).map_err(failed)?;
        let len = file.metadata().map_err(failed)?.len();
        #[cfg(not(unix))]
        let file = std::sync::Mutex::new(file);
        Ok(Self { path: path.to_path_buf(), file, len })
    }

    /// Its bytes when it was opened.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// Some bytes of it. Memory is taken for no more than the file had when it was opened.
    pub fn read(&self, offset: u64, bytes: u64) -> Result<Vec<u8>, Error> {
        let truncated = || Error::Truncated {
            path: self.path.clone(),
            what: format!("{bytes} bytes from byte {offset} are needed, the file has {}", self.len),
        };
        let end = offset.checked_add(bytes).filter(|end| *end <= self.len);
        let (Some(_), Ok(len)) = (end, usize::try_from(bytes)) else { return Err(truncated()) };
        let mut read = vec![0; len];
        self.read_exact_at(&mut read, offset).map_err(|source| match source.kind() {
            // It became shorter.
            ErrorKind::UnexpectedEof => truncated(),
            _ => Error::Read { path: self.path.clone(), source },
        })?;
        Ok(read)
    }

    #[cfg(unix)]
    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> std::io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, offset)
    }

    #[cfg(not(unix))]
    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> std::io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}
