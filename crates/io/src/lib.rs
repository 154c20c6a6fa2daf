//! Readers and writers of point-cloud files, and of pictures that stand for clouds.

pub mod bitmap;
mod channel;
mod columns;
mod crs;
pub mod decoder;
mod e57;
mod grid;
mod las;
mod memory;
mod number;
pub mod output;
mod parts;
mod pcd;
pub mod photo;
pub mod ply;
pub mod polygon;
mod prepared;
mod shared;
mod splats;
pub mod store;
mod text;
pub mod volume;

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use bytesize::ByteSize;

use pellucid_core::progress::Progress;

pub use columns::unit_or_zero;
pub use decoder::silence_decoder_panics;
pub use memory::{LEAST_MEMORY, has_memory, memory_for_points, peak_memory};
use pellucid_core::cloud::upright;
use pellucid_core::cloud::{Cloud, GPS_TIME, NUMBER_OF_RETURNS, POINT_SOURCE, RETURN_NUMBER, same_scalar};
use photo::Photo;
use shared::SharedFile;
pub use text::ColumnNames;

/// Points between two steps of a progress bar.
const PROGRESS_STEP: u64 = 1 << 16;

/// The warning about a hint.
const NAMES_WITHOUT_EFFECT: &str = "columns have no effect: they are for text files";

/// First bytes of a file that are looked at to find its format.
const START: u64 = 512;

/// Reason why a file could not be read or written. Every message starts with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// The file doesn't exist.
    #[error("{}: no such file", .0.display())]
    Missing(PathBuf),
    /// The path names a folder.
    #[error("{}: a folder, not a point cloud", .0.display())]
    Folder(PathBuf),
    /// The system refused to open or read the file.
    #[error("{}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A pipe or a device.
    #[error(
        "{}: a pipe or a device, which can't be read here, since clouds are read from several places of a file; write it to a \
         file first, as in `cat … > scan.laz`, and give the file's name",
        .0.display()
    )]
    NotAFile(PathBuf),
    /// The file has no bytes at all.
    #[error("{}: empty file (0 bytes)", .0.display())]
    Empty(PathBuf),
    /// Unknown format: neither the first bytes nor the extension belong to a known format. `start` has the first few
    /// bytes of the file, as text.
    #[error("{}: unknown format; expected a point cloud (PLY, LAS, LAZ, COPC, E57, PCD, PTS, PTX, or a table of numbers as \
         in XYZ, CSV and TXT), Gaussian splats (PLY, SPLAT, SPZ, SOG, KSPLAT, glTF) or a picture (PNG, JPEG, TIFF); the file starts with {start:?}", path.display())]
    UnknownFormat { path: PathBuf, start: String },
    /// A point cloud was given a place that only pictures have.
    #[error("{}: `photo` places a picture (PNG, JPEG, TIFF) in the world, but this is a point cloud; use `translate` and `scale`", .0.display())]
    NoPicture(PathBuf),
    /// The file is whole but no point is left to draw.
    #[error("{}: the cloud has no points{}", path.display(), non_finite_note(*.non_finite))]
    NoPoints { path: PathBuf, non_finite: usize },
    /// The file ends before the data its header announces: it is truncated, or the header is wrong. `what` has the
    /// announced and the actual amount, in bytes or points.
    #[error("{}: truncated file or wrong header: {what}", path.display())]
    Truncated { path: PathBuf, what: String },
    /// A place in the file (a line, a byte, a point or a part) breaks the rules of its format; `cause` is the defect
    /// there.
    #[error("{}: {place}: {cause}", path.display())]
    Malformed { path: PathBuf, place: String, cause: String },
    /// The points lack a coordinate.
    #[error("{}: element `vertex` has no property `{missing}`, only {found}", path.display())]
    MissingProperty { path: PathBuf, missing: &'static str, found: String },
    /// The points that the header announces, and that the file may well have, are more than memory can hold.
    #[error(
        "{}: {points} points take at least {} of memory, but only {} are free; `pellucid prepare {} -o DIR` converts them \
         to a store within --host-memory",
        path.display(), ByteSize(*needed), ByteSize(*free), path.display()
    )]
    TooLarge { path: PathBuf, points: u64, needed: u64, free: u64 },
    /// Somebody who watches wanted the work to end.
    #[error("{}: interrupted; run the same command to continue", path.display())]
    Cancelled { path: PathBuf },
    /// A folder holds something else than what is to be written.
    #[error("{}: the folder has other files; name a new or empty folder, or one with an octree to replace", .0.display())]
    Occupied(PathBuf),
    /// The file could not be written; an earlier file of this name is unchanged.
    #[error("{}: not written: {source}{}", path.display(), pellucid_core::atomic::remedy(source))]
    Write { path: PathBuf, source: std::io::Error },
    /// Gaussian splats and other points were to become one store.
    #[error(
        "{} has Gaussian splats, {} has points: a store can't mix them; write one store for each and use both in a scene",
        splats.display(), points.display()
    )]
    Mixed { splats: PathBuf, points: PathBuf },
    /// Points could not be put into a temporary file.
    #[error("{}: no space for the points of the ensembles: {source}; set TMPDIR to another folder", folder.display())]
    Temporary { folder: PathBuf, source: std::io::Error },
    /// Points that have to be put into order together take more memory than is allowed.
    #[error("{}: {points} points lie in one place and must be sorted together, which takes {} of memory; use --host-memory \
         {}", path.display(), ByteSize(*.needed), ByteSize(needed.next_multiple_of(1 << 20)))]
    Crowded { path: PathBuf, points: u64, needed: u64 },
}

impl Error {
    /// Makes an error of a place in a file that breaks the rules.
    pub(crate) fn malformed(path: &Path, place: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_path_buf(), place: place.into(), cause: cause.into() }
    }

    /// Makes an error of what the system says against opening a file.
    pub(crate) fn opening(path: &Path) -> impl Fn(std::io::Error) -> Self {
        move |source| match (source.kind(), path.to_path_buf()) {
            (ErrorKind::NotFound, path) => Self::Missing(path),
            (_, path) => Self::Read { path, source },
        }
    }
}

fn non_finite_note(count: usize) -> String {
    if count == 0 { String::new() } else { format!(" (all {count} have a coordinate that is not finite)") }
}

/// Information about a file that its bytes don't contain.
#[derive(Debug, Clone, Copy, Default)]
pub struct Hints<'a> {
    /// The placement of a picture.
    pub photo: Option<&'a Photo>,
    /// The names of a text file's columns.
    pub columns: Option<&'a ColumnNames>,
    /// Columns of LAS files to keep.
    pub las: LasColumns,
}

/// Columns of LAS files that are read only if they are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LasColumns {
    /// Number and count of returns, even if every pulse has one.
    pub returns: bool,
    /// The source of each point, mostly a flight line, as `point_source_id`.
    pub source: bool,
    /// The GPS time as `gps_time`, in seconds since the earliest: float32 can't tell moments of a week otherwise.
    pub gps_time: bool,
}

impl LasColumns {
    /// Returns the columns that these or others ask for.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        Self {
            returns: self.returns || more.returns,
            source: self.source || more.source,
            gps_time: self.gps_time || more.gps_time,
        }
    }

    /// Returns those of them that a cloud doesn't have.
    #[must_use]
    pub fn lacking(self, cloud: &Cloud) -> Self {
        let lacks = |name| cloud.scalar(name).is_none();
        Self {
            returns: self.returns && lacks(RETURN_NUMBER),
            source: self.source && lacks(POINT_SOURCE),
            gps_time: self.gps_time && lacks(GPS_TIME),
        }
    }

    /// Returns the column that a scalar of this name is; none for other names.
    pub fn named(name: &str) -> Self {
        let same = |known| same_scalar(name, known);
        Self {
            returns: same(RETURN_NUMBER) || same(NUMBER_OF_RETURNS),
            source: same(POINT_SOURCE),
            gps_time: same(GPS_TIME),
        }
    }
}

/// Reads a point cloud in a format of docs/formats.md, recognized by the first bytes, else by the extension; or a
/// picture (PNG, JPEG, TIFF) as a plane of points at the origin.
///
/// The bar's length is set to the number of points, or an estimate of it, and its position follows them.
///
/// # Errors
/// The file is missing, of unknown format, damaged or without a finite point. Memory use follows the file's actual
/// content, not its header's claims.
pub fn load(path: &Path, progress: &Progress) -> Result<Cloud, Error> {
    load_with(path, Hints::default(), progress)
}

/// Reads a cloud like [`load`], but `hints` place a picture and name the columns of a text file. If the file names its
/// columns itself, the hint has no effect, which becomes one of its warnings.
///
/// # Errors
/// Returns the errors of [`load`], and an error for a picture's placement for a file that is not a picture; a number of
/// columns that differs from the number of names.
pub fn load_with(path: &Path, hints: Hints, progress: &Progress) -> Result<Cloud, Error> {
    if store::is_folder(path) {
        let mut cloud = store::whole(&*store::open(path, hints, progress)?, progress)?;
        upright::lay(&mut cloud);
        return check_some(path, cloud);
    }
    if splats::is_folder(path) {
        let path = path.join(splats::META);
        return load_with(&path, hints, progress);
    }
    let mut source = InputFile::open(path)?;
    let start = source.peek()?;
    let path = source.path.clone();
    let format = Format::detect(&source, &start);
    if hints.photo.is_some() && !matches!(format, Ok(Format::Picture)) {
        return Err(Error::NoPicture(path));
    }
    let format = format?;
    let mut cloud = match format {
        Format::Picture => photo::read(source, hints.photo.unwrap_or(&Photo::default()), progress)?,
        Format::Las => las::read(source, hints.las, progress)?,
        Format::Ply => ply::read(source, progress)?,
        Format::E57 => e57::read(&mut source, progress)?,
        Format::Pcd => pcd::read(&mut source, progress)?,
        Format::Splats(read) => read(source, progress)?,
        Format::Text(kind) => text::read(&mut source, &start, kind, hints.columns, progress)?,
    };
    if hints.columns.is_some() && !matches!(format, Format::Text(_)) {
        cloud.warnings.push(NAMES_WITHOUT_EFFECT.to_owned());
    }
    upright::lay(&mut cloud);
    check_some(&path, cloud)
}

/// A cloud with points; the error says why it has none.
fn check_some(path: &Path, cloud: Cloud) -> Result<Cloud, Error> {
    let path = path.to_path_buf();
    match splats::reason(&cloud) {
        _ if !cloud.is_empty() => Ok(cloud),
        Some(why) => Err(Error::Malformed { path, place: "splats".to_owned(), cause: why.to_owned() }),
        None => Err(Error::NoPoints { path, non_finite: cloud.non_finite }),
    }
}

/// A format of files.
#[derive(Clone, Copy)]
enum Format {
    Picture,
    Las,
    Ply,
    E57,
    Pcd,
    Splats(splats::Reader),
    Text(text::TextFormat),
}

impl Format {
    /// The format of a file with these first bytes: by the bytes, else by the extension, else a table if it contains
    /// numbers.
    fn detect(source: &InputFile, start: &[u8]) -> Result<Self, Error> {
        let extension = source.path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        if let Some(reader) = splats::reader(&source.path, &extension, start) {
            return Ok(Self::Splats(reader));
        }
        let expected = match extension.as_str() {
            _ if bitmap::format(start).is_some() => return Ok(Self::Picture),
            _ if start.starts_with(b"LASF") => return Ok(Self::Las),
            _ if start.starts_with(b"ply") => return Ok(Self::Ply),
            _ if start.starts_with(e57::MAGIC) => return Ok(Self::E57),
            _ if pcd::is_pcd(start) || extension == "pcd" => return Ok(Self::Pcd),
            "ply" => "ply",
            "las" | "laz" => "LASF",
            "e57" => "ASTM-E57",
            "png" => "\\x89PNG",
            "jpg" | "jpeg" => "\\xff\\xd8\\xff",
            "tif" | "tiff" => "II*\\0",
            "spz" => "NGSP` or `\\x1f\\x8b",
            "sog" => "PK",
            "glb" => "glTF",
            "gltf" => "{",
            other => match text::TextFormat::of_extension(other) {
                Some(kind) => return Ok(Self::Text(kind)),
                None if text::looks_like_one(start) => return Ok(Self::Text(text::TextFormat::Table)),
                None => "",
            },
        };
        let start = String::from_utf8_lossy(&start[..start.len().min(8)]).into_owned();
        if expected.is_empty() {
            return Err(Error::UnknownFormat { path: source.path.clone(), start });
        }
        Err(source.malformed("byte 0", format!("expected `{expected}`, found {start:?}")))
    }
}

/// Returns `true` if the file's extension is that of a point-cloud format.
pub fn is_cloud(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    matches!(extension.as_str(), "ply" | "las" | "laz" | "e57" | "pcd")
        || splats::has_extension(&extension)
        || text::TextFormat::of_extension(&extension).is_some()
}

/// An open file with what error messages and size checks need.
struct InputFile {
    reader: BufReader<File>,
    path: PathBuf,
    /// Length in bytes.
    len: u64,
}

impl InputFile {
    fn open(path: &Path) -> Result<Self, Error> {
        let (owned, failed) = (path.to_path_buf(), Error::opening(path));
        let file = File::open(path).map_err(&failed)?;
        let metadata = file.metadata().map_err(&failed)?;
        if metadata.is_dir() {
            return Err(Error::Folder(owned));
        }
        // A pipe or a device has no length to check claims against.
        if !metadata.is_file() {
            return Err(Error::NotAFile(owned));
        }
        if metadata.len() == 0 {
            return Err(Error::Empty(owned));
        }
        Ok(Self { reader: BufReader::with_capacity(1 << 20, file), path: owned, len: metadata.len() })
    }

    /// The file's first few bytes; the reader is back at its start afterwards.
    fn peek(&mut self) -> Result<Vec<u8>, Error> {
        let mut start = Vec::new();
        let read = self.reader.by_ref().take(START).read_to_end(&mut start);
        read.and_then(|_| self.reader.rewind()).map_err(|e| self.read_error(e))?;
        Ok(start)
    }

    /// Some bytes of the file.
    fn bytes(&mut self, start: u64, len: usize) -> Result<Vec<u8>, Error> {
        let mut bytes = vec![0; len];
        let read = self.reader.seek(SeekFrom::Start(start)).and_then(|_| self.reader.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|e| self.read_error(e))
    }

    /// All bytes of the file, from its start.
    fn all(&mut self) -> Result<Vec<u8>, Error> {
        let mut bytes = Vec::new();
        let read = self.reader.by_ref().take(self.len).read_to_end(&mut bytes);
        read.map_err(|e| self.read_error(e)).map(|_| bytes)
    }

    fn read_error(&self, source: std::io::Error) -> Error {
        Error::Read { path: self.path.clone(), source }
    }

    fn malformed(&self, place: impl Into<String>, cause: impl Into<String>) -> Error {
        Error::malformed(&self.path, place, cause)
    }

    fn truncated(&self, what: impl Into<String>) -> Error {
        Error::Truncated { path: self.path.clone(), what: what.into() }
    }
}
