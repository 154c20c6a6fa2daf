//! Text files of numbers, one point per line: XYZ, CSV, TXT and their like, PTS and PTX.
//!
//! Fields are separated by blanks, tabs, commas or semicolons; lines end in LF or CR LF. Lines that start with `#`
//! or `//` are ignored, except for names of columns right before the first point. The columns are named by the user, by
//! a line of names, or inferred from their number and values; docs/formats.md has the rules. Colors and alphas share a
//! common range: 1, 255 or 65535.

mod batch;
mod lines;
mod names;
mod ptx;
mod table;

use pellucid_core::progress::Progress;

use super::{Error, InputFile};
pub use names::ColumnNames;
use pellucid_core::cloud::{Cloud, UpAxis};
pub(super) use table::looks_like_one;

/// The kinds of text files.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum TextFormat {
    /// A table, which may begin with names.
    Table,
    /// Scans that each begin with their number of points.
    Pts,
    /// Scans that each begin with their grid and pose.
    Ptx,
}

impl TextFormat {
    /// Returns the kind that files of an extension have, in lower case; `None` if they are no text.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "pts" => Some(Self::Pts),
            "ptx" => Some(Self::Ptx),
            "xyz" | "xyzn" | "xyzrgb" | "xyzi" | "txt" | "csv" | "tsv" | "asc" => Some(Self::Table),
            _ => None,
        }
    }
}

/// Reads the points of a text file; `start` are its first bytes.
pub(super) fn read(
    source: &mut InputFile,
    start: &[u8],
    kind: TextFormat,
    names: Option<&ColumnNames>,
    progress: &Progress,
) -> Result<Cloud, Error> {
    if start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff") {
        return Err(source.malformed("byte 0", "UTF-16 text is not supported; save the file as UTF-8"));
    }
    if let Some(at) = start.iter().position(|&byte| byte == 0) {
        return Err(source.malformed(format!("byte {at}"), "binary data, not text"));
    }
    let mut cloud = match kind {
        TextFormat::Ptx => ptx::read(source, names, progress)?,
        TextFormat::Table | TextFormat::Pts => table::read(source, kind == TextFormat::Pts, names, progress)?,
    };
    (cloud.up, cloud.up_is_convention) = (UpAxis::Z, true);
    Ok(cloud)
}
