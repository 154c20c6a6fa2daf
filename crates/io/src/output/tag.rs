//! Metadata of files that are there.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::Format;

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
    let info = reader.info();
    let latin =
        info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == name).map(|chunk| chunk.text.clone());
    let unicode = || info.utf8_text.iter().find(|chunk| chunk.keyword == name)?.get_text().ok();
    latin.or_else(unicode)
}

fn of_exr(path: &Path, name: &str) -> Option<String> {
    use exr::prelude::{AttributeValue, MetaData};
    let meta = MetaData::read_from_buffered(BufReader::new(File::open(path).ok()?), false).ok()?;
    let header = meta.headers.first()?;
    let all = header.shared_attributes.other.iter().chain(&header.own_attributes.other);
    let value = all.into_iter().find(|(known, _)| **known == *name)?.1;
    match value {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    }
}
