//! Files that several threads read from at once.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::{Error, InputFile};

/// An open file without a position of its own.
#[derive(Debug)]
pub(super) struct SharedFile {
    file: File,
    path: PathBuf,
    /// Length in bytes, when it was opened.
    len: u64,
}

impl SharedFile {
    /// Opens a file that isn't empty.
    pub fn open(path: &Path) -> Result<Self, Error> {
        InputFile::open(path).map(Self::from)
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn len(&self) -> u64 {
        self.len
    }

    /// Returns some bytes of the file. Memory is taken only for bytes that it had when it was opened.
    pub fn read(&self, start: u64, bytes: u64) -> Result<Vec<u8>, Error> {
        if start.checked_add(bytes).is_none_or(|end| end > self.len) {
            let len = self.len;
            return Err(self.truncated(format!("{bytes} bytes from byte {start} are needed, but the file has {len}")));
        }
        let mut buffer = vec![0; bytes as usize];
        read_at(&self.file, &mut buffer, start).map_err(|source| match source.kind() {
            ErrorKind::UnexpectedEof => self.truncated(format!(
                "it ends within the {bytes} bytes from byte {start}, so it became shorter while it was read"
            )),
            _ => Error::Read { path: self.path.clone(), source },
        })?;
        Ok(buffer)
    }

    pub fn malformed(&self, place: impl Into<String>, cause: impl Into<String>) -> Error {
        Error::malformed(&self.path, place, cause)
    }

    pub fn truncated(&self, what: impl Into<String>) -> Error {
        Error::Truncated { path: self.path.clone(), what: what.into() }
    }
}

impl From<InputFile> for SharedFile {
    fn from(source: InputFile) -> Self {
        Self { file: source.reader.into_inner(), path: source.path, len: source.len }
    }
}

#[cfg(unix)]
fn read_at(file: &File, buffer: &mut [u8], start: u64) -> std::io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, buffer, start)
}

#[cfg(windows)]
fn read_at(file: &File, mut buffer: &mut [u8], mut start: u64) -> std::io::Result<()> {
    while !buffer.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, buffer, start) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(read) => {
                buffer = &mut buffer[read..];
                start += read as u64;
            }
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_beyond_the_file_are_refused_before_memory_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ten");
        std::fs::write(&path, b"0123456789").unwrap();
        let file = SharedFile::from(InputFile::open(&path).unwrap());
        assert_eq!(file.read(3, 4).unwrap(), b"3456");
        assert_eq!(file.read(10, 0).unwrap(), b"");
        for (start, bytes) in [(3, 8), (0, u64::MAX), (u64::MAX, 1), (11, 0)] {
            assert!(matches!(file.read(start, bytes), Err(Error::Truncated { .. })), "{bytes} from {start}");
        }
        std::fs::write(&path, b"0123").unwrap();
        let error = file.read(2, 4).unwrap_err().to_string();
        assert!(error.contains("became shorter"), "{error}");
    }
}
