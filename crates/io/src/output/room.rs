//! Room for large files, asked for before the work.

use std::path::Path;

use bytesize::ByteSize;

use super::Error;
use pellucid_core::atomic;

/// Refuses a file that may take more than what is free where it goes. The earlier file of that name stays until the new
/// one is complete, so that its bytes don't count as free.
///
/// # Errors
/// Too little is free.
pub fn check(path: &Path, bytes: u64) -> Result<(), Error> {
    // Devices take any number.
    if path.exists() && !path.is_file() {
        return Ok(());
    }
    check_free(path, bytes, atomic::free_bytes(atomic::folder(path)))
}

/// Checks the room for a file, given what is free, if that is known.
fn check_free(path: &Path, bytes: u64, free: Option<u64>) -> Result<(), Error> {
    match free {
        Some(free) if bytes > free => {
            Err(Error::NoRoom { path: path.to_owned(), bytes: ByteSize(bytes), free: ByteSize(free) })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_larger_than_the_free_space_are_refused() {
        let path = Path::new("out/a.exr");
        assert!(check_free(path, 100, Some(100)).is_ok() && check_free(path, u64::MAX, None).is_ok());
        let error = check_free(path, 3 << 30, Some(2 << 30)).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("out/a.exr: may take 3.0 GiB, but only 2.0 GiB are free there"), "{text}");
        assert_eq!(error.exit_status(), 1);
    }

    #[test]
    fn the_system_says_what_is_free() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert!(check(&path, 1).is_ok());
        assert!(matches!(check(&path, 1 << 62), Err(Error::NoRoom { .. })));
        #[cfg(unix)]
        assert!(check(Path::new("/dev/null"), 1 << 62).is_ok());
    }
}
