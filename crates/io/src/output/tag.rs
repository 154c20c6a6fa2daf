//! Metadata of files that are there.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use exr::prelude::{AttributeValue, MetaData};

use super::read::{decode, open};
use super::{Error, Format};

/// Name of the camera with which a picture was made: the keys of `[camera]`, as TOML.
pub const CAMERA_TAG: &str = "pellucid:camera";

/// The last bytes of every PNG: an empty chunk IEND with its length and checksum.
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xae\x42\x60\x82";

/// Returns the value of a name in a PNG or EXR that this program wrote (see [`super::WriteOptions::metadata`]); `None`
/// for any other file, for one that is not whole, and for one that can't be read.
pub fn metadata(path: &Path, name: &str) -> Option<String> {
    match Format::from_extension(path).ok()? {
        Format::Png => of_png(path, name),
        Format::Exr => of_exr(path, name),
    }
}

/// Size of a picture, and the value of a name in its metadata.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tagged {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The value; `None` if the picture doesn't have the name.
    pub value: Option<String>,
}

/// Returns the size of a PNG or EXR and the value of a name in its metadata, without its pixels.
///
/// # Errors
/// Returns an error if the extension is neither `.png` nor `.exr`, and if the file is missing or damaged.
pub fn tagged(path: &Path, name: &str) -> Result<Tagged, Error> {
    let damaged = |reason: String| Error::Decode { path: path.to_owned(), reason };
    match Format::from_extension(path)? {
        Format::Png => decode(path, || {
            let reader = png::Decoder::new(open(path)?.0).read_info().map_err(|error| damaged(error.to_string()))?;
            let info = reader.info();
            Ok(Tagged { size: [info.width, info.height], value: text_of(info, name) })
        }),
        Format::Exr => decode(path, || {
            let meta =
                MetaData::read_from_buffered(open(path)?.0, false).map_err(|error| damaged(error.to_string()))?;
            let size = meta.headers.first().map(|header| [header.layer_size.0, header.layer_size.1]);
            let size = size.unwrap_or_default().map(|side| u32::try_from(side).unwrap_or(u32::MAX));
            Ok(Tagged { size, value: attribute_of(&meta, name) })
        }),
    }
}

fn of_png(path: &Path, name: &str) -> Option<String> {
    let mut file = File::open(path).ok()?;
    let mut end = [0; PNG_END.len()];
    file.seek(SeekFrom::End(-(PNG_END.len() as i64))).ok()?;
    file.read_exact(&mut end).ok()?;
    file.rewind().ok()?;
    if end != PNG_END {
        return None;
    }
    let reader = png::Decoder::new(BufReader::new(file)).read_info().ok()?;
    text_of(reader.info(), name)
}

/// The text of a PNG with this keyword.
fn text_of(info: &png::Info<'_>, name: &str) -> Option<String> {
    let latin =
        info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == name).map(|chunk| chunk.text.clone());
    let unicode = || info.utf8_text.iter().find(|chunk| chunk.keyword == name)?.get_text().ok();
    latin.or_else(unicode)
}

fn of_exr(path: &Path, name: &str) -> Option<String> {
    let meta = MetaData::read_from_buffered(BufReader::new(File::open(path).ok()?), false).ok()?;
    attribute_of(&meta, name)
}

/// The text of an EXR with this name.
fn attribute_of(meta: &MetaData, name: &str) -> Option<String> {
    let header = meta.headers.first()?;
    let all = header.shared_attributes.other.iter().chain(&header.own_attributes.other);
    let value = all.into_iter().find(|(known, _)| **known == *name)?.1;
    match value {
        // UTF-8, which the decoder takes for Latin-1.
        AttributeValue::Text(text) => String::from_utf8(text.as_slice().to_vec()).ok(),
        _ => None,
    }
}
