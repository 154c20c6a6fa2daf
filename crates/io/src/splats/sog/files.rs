//! The files of SOG splats, in an archive or in a folder.

use std::io::Read;
use std::path::PathBuf;

use flate2::bufread::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};

use super::super::all_bytes;
use super::{MAGIC, META};
use crate::{Error, InputFile, SharedFile};

/// Bytes that may come of a byte of an archive, at most. Pictures can't be packed any further, and text not by so much.
const MOST_PER_BYTE: u64 = 64;

/// Locations of the files.
pub(super) enum Files {
    /// An archive in memory, and the folder in it.
    Archive { file: SharedFile, bytes: Vec<u8>, folder: String },
    /// The folder with a `meta.json`, which is this file.
    Folder { file: SharedFile, folder: PathBuf, meta: Vec<u8> },
}

impl Files {
    pub fn open(source: InputFile) -> Result<Self, Error> {
        let (file, bytes) = all_bytes(source)?;
        if !bytes.starts_with(MAGIC) {
            let folder = file.path().parent().map(PathBuf::from).unwrap_or_default();
            return Ok(Self::Folder { file, folder, meta: bytes });
        }
        let names = names(&bytes).map_err(|cause| file.malformed("ZIP archive", cause))?;
        let folders = names.iter().filter_map(|name| name.strip_suffix(META));
        let mut folders = folders.filter(|folder| folder.is_empty() || folder.ends_with('/'));
        match folders.next().map(str::to_owned) {
            Some(folder) => Ok(Self::Archive { file, bytes, folder }),
            None => {
                let cause =
                    format!("the ZIP archive has no {META}, which SOG splats need, but {} other files", names.len());
                Err(file.malformed("ZIP archive", cause))
            }
        }
    }

    /// Returns the archive, or the file of the folder, as messages name it.
    pub fn file(&self) -> &SharedFile {
        match self {
            Self::Archive { file, .. } | Self::Folder { file, .. } => file,
        }
    }

    /// Returns the content of a file.
    pub fn read(&self, name: &str) -> Result<Vec<u8>, Error> {
        if name.is_empty() || name.contains(['/', '\\', '\0']) || name == ".." {
            return Err(self.malformed(META, format!("{name:?} is not the name of a file in the same folder")));
        }
        match self {
            Self::Folder { meta, .. } if name == META => Ok(meta.clone()),
            Self::Folder { folder, .. } => Ok(all_bytes(InputFile::open(&folder.join(name))?)?.1),
            Self::Archive { bytes, folder, .. } => {
                let entry = entry(bytes, &format!("{folder}{name}"));
                entry.map_err(|cause| self.malformed(name, cause))
            }
        }
    }

    /// Returns the error of a file that breaks the rules.
    pub fn malformed(&self, name: &str, cause: impl Into<String>) -> Error {
        match self {
            Self::Folder { folder, .. } => Error::malformed(&folder.join(name), "content", cause),
            Self::Archive { file, .. } => file.malformed(name, cause),
        }
    }
}

/// The names of the files of an archive, or what is wrong with it.
fn names(archive: &[u8]) -> Result<Vec<String>, String> {
    let archive = ZipArchive::from_slice(archive).map_err(|e| e.to_string())?;
    let mut entries = archive.entries();
    let mut names = Vec::new();
    while let Some(entry) = entries.next_entry().map_err(|e| e.to_string())? {
        names.push(String::from_utf8_lossy(entry.file_path().as_ref()).into_owned());
    }
    Ok(names)
}

/// The content of a file of an archive, or what is wrong with it. No more is unpacked than the archive says.
fn entry(archive: &[u8], name: &str) -> Result<Vec<u8>, String> {
    let archive = ZipArchive::from_slice(archive).map_err(|e| e.to_string())?;
    let mut entries = archive.entries();
    let place = loop {
        match entries.next_entry().map_err(|e| e.to_string())? {
            Some(entry) if entry.file_path().as_ref() == name.as_bytes() => {
                break (entry.wayfinder(), entry.compression_method(), entry.uncompressed_size_hint());
            }
            Some(_) => {}
            None => return Err(format!("the ZIP archive has no file {name}")),
        }
    };
    let (place, method, len) = place;
    let entry = archive.get_entry(place).map_err(|e| e.to_string())?;
    let packed = entry.data();
    if len > (packed.len() as u64).saturating_mul(MOST_PER_BYTE) {
        return Err(format!(
            "{len} bytes are announced for {} compressed ones, more than {MOST_PER_BYTE} for each",
            packed.len()
        ));
    }
    let mut content = Vec::new();
    let read = match method {
        CompressionMethod::STORE => entry.verifying_reader(packed).take(len + 1).read_to_end(&mut content),
        CompressionMethod::DEFLATE => {
            entry.verifying_reader(DeflateDecoder::new(packed)).take(len + 1).read_to_end(&mut content)
        }
        other => return Err(format!("packed by method {other:?}, expected stored or deflated")),
    };
    read.map_err(|e| e.to_string())?;
    if content.len() as u64 != len {
        return Err(format!("{} bytes, but the archive announces {len}", content.len()));
    }
    Ok(content)
}
