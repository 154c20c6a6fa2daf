//! Files that appear whole or not at all.
//!
//! Data is written to a temporary file in the folder of the result, flushed to the disk, and renamed; until the rename
//! the earlier file stays in place. The temporary file is removed however the writing ends, by an error or by a signal
//! ([`discard_unfinished`]). Only SIGKILL and a power failure can leave one behind, with a recognizable name:
//! `.pellucid-XXXXXX.tmp`.

mod unfinished;

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::Path;

pub use unfinished::{NewFolder, Unfinished, discard_unfinished};

use pellucid_fault as fault;
use unfinished::Temporary;

/// Bytes that are collected before they are written.
const BUFFER_BYTES: usize = 1 << 18;

/// The writer that [`Staged::write`] passes to its callback.
pub type Writer = BufWriter<Draft>;

/// A file in the making.
#[derive(Debug)]
pub struct Draft {
    place: Destination,
    /// The first error of the system. Encoders wrap errors, which would hide the cause.
    failure: Option<io::Error>,
}

#[derive(Debug)]
enum Destination {
    Temporary(Temporary),
    /// Anything but a regular file, such as `/dev/null` or a pipe, keeps its name and is written to directly.
    Direct(File),
}

impl Draft {
    fn open(path: &Path) -> io::Result<Self> {
        let place = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => Destination::Direct(OpenOptions::new().write(true).open(path)?),
            _ => {
                fault::file("output/create")?;
                Destination::Temporary(Temporary::make(folder(path))?)
            }
        };
        Ok(Self { place, failure: None })
    }

    fn file(&mut self) -> &mut File {
        match &mut self.place {
            Destination::Temporary(temporary) => temporary.file(),
            Destination::Direct(file) => file,
        }
    }

    fn write_some(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(before) = fault::bytes("output/byte", bytes.len()) {
            self.file().write_all(&bytes[..before])?;
            fault::strike()?;
        }
        self.file().write(bytes)
    }

    /// Flushes to the disk: some file systems report only then that they are full.
    fn sync(&mut self) -> io::Result<()> {
        match self.file().sync_data() {
            // Pipes and some file systems can't, and then have nothing to say.
            Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
            synced => synced,
        }
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.write_some(bytes);
        if let Err(error) = &written
            && error.kind() != ErrorKind::Interrupted
        {
            let same = || error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error);
            self.failure.get_or_insert_with(same);
        }
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Moves the place of the next write, for formats that put tables before what they count. A pipe has no places to go
/// back to, which the system says.
impl Seek for Draft {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file().seek(to)
    }
}

/// A complete file without its final name yet. Dropping it removes it.
#[derive(Debug)]
pub struct Staged(Draft);

impl Staged {
    /// Writes the future content of `path` to a temporary file beside it.
    ///
    /// # Errors
    /// Errors of `write` or the system, and a folder at `path`.
    pub fn write<W>(path: &Path, write: W) -> io::Result<Self>
    where
        W: FnOnce(&mut Writer) -> io::Result<()>,
    {
        let mut staged = Self::write_quickly(path, write)?;
        staged.0.sync()?;
        Ok(staged)
    }

    /// Writes like [`Staged::write`], without flushing to the disk: for data that may be lost in a power failure.
    ///
    /// # Errors
    /// Returns the errors of [`Staged::write`].
    pub fn write_quickly<W>(path: &Path, write: W) -> io::Result<Self>
    where
        W: FnOnce(&mut Writer) -> io::Result<()>,
    {
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, Draft::open(path)?);
        let written = write(&mut out).and_then(|()| out.flush());
        // Taken apart, or the buffer would be written once more after an error.
        let (mut draft, _) = out.into_parts();
        written.map_err(|error| draft.failure.take().unwrap_or(error))?;
        Ok(Self(draft))
    }

    /// Gives the file its name and replaces the earlier file.
    ///
    /// # Errors
    /// Errors of the system; the earlier file then remains.
    pub fn publish(self, path: &Path) -> io::Result<()> {
        let Destination::Temporary(temporary) = self.0.place else { return Ok(()) };
        fault::file("output/rename")?;
        temporary.persist(path)?;
        fault::file("output/renamed")
    }
}

/// Writes a file, whole or not at all.
///
/// # Errors
/// Errors of `write` or the system; the earlier file then remains.
pub fn write<W>(path: &Path, write: W) -> io::Result<()>
where
    W: FnOnce(&mut Writer) -> io::Result<()>,
{
    Staged::write(path, write)?.publish(path)
}

/// Returns the folder of a file.
pub fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Tests by means of an unnamed file if a folder can be written to.
///
/// # Errors
/// Errors of the system.
pub fn probe(folder: &Path) -> io::Result<()> {
    tempfile::tempfile_in(folder).map(drop)
}

/// Returns the number of bytes that a file in a folder may still take; `None` where the system doesn't say.
pub fn free_bytes(folder: &Path) -> Option<u64> {
    fs4::available_space(folder).ok()
}

/// Returns advice to end an error message with; empty if the reason already says everything.
pub fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull => "; free some space there or write elsewhere",
        ErrorKind::QuotaExceeded => "; free some of your space there or write elsewhere",
        ErrorKind::FileTooLarge => "; raise the limit on file sizes (ulimit -f) or use another file system",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "; choose a folder with write permission",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_can_not_be_given_is_an_error_and_nothing_stays() {
        let parent = tempfile::tempdir().unwrap();
        let path = parent.path().join("picture.png");
        let staged = Staged::write(&path, |out| out.write_all(b"whole")).unwrap();
        fs::create_dir(&path).unwrap();
        staged.publish(&path).unwrap_err();
        assert!(path.is_dir());
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1);
    }
}
