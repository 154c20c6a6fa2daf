//! Files that are there whole or not at all.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use super::Error;

/// Checks that `path` names a file in a folder that exists.
///
/// # Errors
/// A missing folder, or a folder of that name.
pub fn check_folder(path: &Path) -> Result<(), Error> {
    let folder = folder(path);
    if !folder.is_dir() {
        return Err(Error::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    if path.is_dir() || path.file_name().is_none() {
        return Err(Error::IsFolder { path: path.to_owned() });
    }
    Ok(())
}

/// Writes to a temporary name in the folder of `path` and renames: afterwards there is the new file, or, after an
/// error, what was there before.
///
/// # Errors
/// Those of [`check_folder`], and what `write` or the system says.
pub fn write_atomically<W>(path: &Path, write: W) -> Result<(), Error>
where
    W: FnOnce(&mut BufWriter<&std::fs::File>) -> io::Result<()>,
{
    check_folder(path)?;
    let failed = |source| Error::Write { path: path.to_owned(), source };
    let file = temporary(folder(path)).map_err(failed)?;
    let mut buffered = BufWriter::new(file.as_file());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(failed)?;
    drop(buffered);
    file.persist(path).map_err(|error| failed(error.error))?;
    Ok(())
}

/// What the encoders need of a file.
pub(super) trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pellucid-").suffix(".tmp");
    // Temporary files are private by default; a result has the permissions that any new file gets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
