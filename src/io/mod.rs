//! Point-cloud files, and pictures that stand for clouds.

mod decoder;
mod las;
pub mod photo;
pub mod ply;
pub mod volume;

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek};
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use crate::cloud::Cloud;
use photo::Photo;

/// Points between two steps of a progress bar.
const PROGRESS_STEP: u64 = 1 << 16;

/// Why a file could not be read or written. Every message starts with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no such file.
    #[error("{}: no such file", path.display())]
    Missing {
        /// The file asked for.
        path: PathBuf,
    },
    /// The path names a folder.
    #[error("{}: a folder, not a point cloud", path.display())]
    Folder {
        /// The path asked for.
        path: PathBuf,
    },
    /// The system refused to open or read the file.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file has no bytes at all.
    #[error("{}: empty file (0 bytes)", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Neither the first bytes nor the extension belong to a known format.
    #[error("{}: not a point cloud in a known format (PLY, LAS, LAZ, COPC) nor a picture (PNG, JPEG, TIFF); it starts with {start:?}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// Its first few bytes, as text.
        start: String,
    },
    /// A point cloud was given a place that only pictures have.
    #[error("{}: `photo` places a picture (PNG, JPEG, TIFF) in the world, but this is a point cloud; use `translate` and `scale`", path.display())]
    NoPicture {
        /// The file.
        path: PathBuf,
    },
    /// The file is whole but no point is left to draw.
    #[error("{}: cloud without points{}", path.display(), non_finite_note(*.non_finite))]
    NoPoints {
        /// The file.
        path: PathBuf,
        /// Points dropped for a coordinate that is not finite.
        non_finite: usize,
    },
    /// The file ends before what its header announces: truncated, or the header lies.
    #[error("{}: truncated file or wrong header: {what}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// What was announced and what is there, in bytes or points.
        what: String,
    },
    /// A place in the file breaks the rules of its format.
    #[error("{}: {place}: {cause}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, byte, point or part of the file.
        place: String,
        /// What is wrong there.
        cause: String,
    },
    /// The points lack a coordinate.
    #[error("{}: element `vertex` has no property `{missing}`, only {found}", path.display())]
    MissingProperty {
        /// The file.
        path: PathBuf,
        /// The coordinate.
        missing: &'static str,
        /// The properties there are.
        found: String,
    },
    /// The file could not be written; whatever stood there before is untouched.
    #[error("{}: not written: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
}

fn non_finite_note(count: usize) -> String {
    if count == 0 { String::new() } else { format!(" (all {count} have a coordinate that is not finite)") }
}

/// Reads a point cloud: PLY, LAS or LAZ (COPC files as LAZ), told apart by the first bytes, else by the extension; or a
/// picture (PNG, JPEG, TIFF) as a plane of points at the origin, see [`load_placed`].
///
/// The bar's length is set to the number of points and its position follows them.
///
/// # Errors
/// If the file is missing, of no known format, damaged or without a finite point. Memory follows what the file holds,
/// not what its header claims.
pub fn load(path: &Path, progress: &ProgressBar) -> Result<Cloud, Error> {
    load_placed(path, None, progress)
}

/// As [`load`]; a picture stands where `photo` says.
///
/// # Errors
/// Those of [`load`], and if `photo` is given for a file that is no picture.
pub fn load_placed(path: &Path, photo: Option<&Photo>, progress: &ProgressBar) -> Result<Cloud, Error> {
    let mut source = Source::open(path)?;
    let start = source.peek()?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let path = source.path.clone();
    let cloud = if photo::is_picture(&start) {
        photo::read(source, photo.unwrap_or(&Photo::default()), progress)?
    } else if photo.is_some() {
        return Err(Error::NoPicture { path });
    } else if start.starts_with(b"LASF") {
        las::read(&mut source, progress)?
    } else if start.starts_with(b"ply") {
        ply::read(&mut source, progress)?
    } else {
        let start = String::from_utf8_lossy(&start).into_owned();
        let expected = match extension.as_str() {
            "ply" => "ply",
            "las" | "laz" => "LASF",
            "png" => "\\x89PNG",
            "jpg" | "jpeg" => "\\xff\\xd8\\xff",
            "tif" | "tiff" => "II*\\0",
            _ => return Err(Error::UnknownFormat { path, start }),
        };
        return Err(source.malformed("byte 0", format!("expected `{expected}`, found {start:?}")));
    };
    if cloud.is_empty() {
        return Err(Error::NoPoints { path, non_finite: cloud.non_finite });
    }
    Ok(cloud)
}

/// An open file with what error messages and size checks need.
struct Source {
    reader: BufReader<File>,
    path: PathBuf,
    /// Length in bytes.
    len: u64,
}

impl Source {
    fn open(path: &Path) -> Result<Self, Error> {
        let owned = path.to_path_buf();
        let file = match File::open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == ErrorKind::NotFound => return Err(Error::Missing { path: owned }),
            Err(source) => return Err(Error::Read { path: owned, source }),
        };
        let metadata = match file.metadata() {
            Ok(metadata) => metadata,
            Err(source) => return Err(Error::Read { path: owned, source }),
        };
        if metadata.is_dir() {
            return Err(Error::Folder { path: owned });
        }
        // A pipe or a device has no length to check claims against.
        if metadata.len() == 0 {
            return Err(Error::Empty { path: owned });
        }
        Ok(Self { reader: BufReader::with_capacity(1 << 20, file), path: owned, len: metadata.len() })
    }

    /// The file's first few bytes; the reader is back at its start afterwards.
    fn peek(&mut self) -> Result<Vec<u8>, Error> {
        let mut start = Vec::new();
        let read = self.reader.by_ref().take(8).read_to_end(&mut start);
        read.and_then(|_| self.reader.rewind()).map_err(|e| self.read_error(e))?;
        Ok(start)
    }

    fn read_error(&self, source: std::io::Error) -> Error {
        Error::Read { path: self.path.clone(), source }
    }

    fn malformed(&self, place: impl Into<String>, cause: impl Into<String>) -> Error {
        Error::Malformed { path: self.path.clone(), place: place.into(), cause: cause.into() }
    }

    fn truncated(&self, what: impl Into<String>) -> Error {
        Error::Truncated { path: self.path.clone(), what: what.into() }
    }
}
