//! Gaussian splats in formats of their own. Those in PLY files are read by `ply`.
//!
//! | format | file | known by |
//! |---|---|---|
//! | `.splat` | [`raw`] | its extension |
//! | SPZ 1 to 4 | [`spz`] | `NGSP`, or gzip |
//! | SOG 2 | [`sog`] | ZIP, `meta.json`, or a folder with one |
//! | KSPLAT | [`ksplat`] | its extension |
//! | glTF with `KHR_gaussian_splatting` | [`gltf`] | `glTF`, or the extension of the text form |
//!
//! Each reader checks what the file announces against the bytes that there are, says how many splats it has, and how
//! one of them is decoded. [`Splats::gather`] does the rest alike for all: it decodes on all cores, leaves out what is
//! no splat, and makes a cloud.

mod gather;
mod gltf;
mod ksplat;
mod raw;
mod sog;
mod spz;
mod turn;

pub(super) use gather::{Splat, Splats, from_coefficient, left_out, quaternion, reason};
pub(crate) use gltf::decoded;
pub(super) use sog::{META, is_folder};

use std::path::Path;

use super::{Error, InputFile, SharedFile, memory};
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;

/// Splats of a packed file for each of its bytes, at most. Those of real files take several bytes each. A file that
/// announces more is one that was made to fill the memory.
const MOST_PER_BYTE: u64 = 32;

/// The reader of a format of files that hold nothing but splats.
pub(super) type Reader = fn(InputFile, &Progress) -> Result<Cloud, Error>;

/// Returns the reader of a file with these first bytes; if they are those of no format, that of its extension, which is
/// in lower case.
pub(super) fn reader(path: &Path, extension: &str, start: &[u8]) -> Option<Reader> {
    let is_text = start.trim_ascii_start().starts_with(b"{");
    match extension {
        _ if start.starts_with(spz::MAGIC) || start.starts_with(spz::GZIP) => Some(spz::read),
        _ if start.starts_with(sog::MAGIC) => Some(sog::read),
        _ if start.starts_with(gltf::MAGIC) => Some(gltf::read),
        "json" if is_text && path.file_name().is_some_and(|name| name == META) => Some(sog::read),
        "gltf" if is_text => Some(gltf::read),
        "splat" => Some(raw::read),
        "ksplat" => Some(ksplat::read),
        _ => None,
    }
}

/// Returns `true` if the extension, in lower case, is that of one of the formats.
pub(super) fn has_extension(extension: &str) -> bool {
    matches!(extension, "splat" | "spz" | "sog" | "ksplat" | "gltf" | "glb")
}

/// All bytes of a file, if the memory holds them.
fn all_bytes(source: InputFile) -> Result<(SharedFile, Vec<u8>), Error> {
    let file = SharedFile::from(source);
    memory::check(file.path(), file.len(), 1)?;
    let bytes = file.read(0, file.len())?;
    Ok((file, bytes))
}

/// Checks that memory can hold the splats that a file announces, and that a packed file of so many bytes may have as
/// many.
fn check_count(file: &SharedFile, place: &str, count: u64, degree: u32, packed: Option<u64>) -> Result<(), Error> {
    if let Some(bytes) = packed.filter(|bytes| count > bytes.saturating_mul(MOST_PER_BYTE)) {
        let cause = format!("{count} splats are announced, more than {MOST_PER_BYTE} for each of the {bytes} bytes");
        return Err(file.malformed(place, cause));
    }
    memory::check(file.path(), count, Splats::bytes(degree))
}
