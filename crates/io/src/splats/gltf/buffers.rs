//! The buffers of a glTF file: in it, beside it, or written in its text.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::super::all_bytes;
use super::document::{Buffer, Document};
use crate::{Error, InputFile, SharedFile};

/// All buffers.
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

impl<'a> Buffers<'a> {
    pub fn read(file: &SharedFile, document: &Document, binary: Option<&'a [u8]>) -> Result<Self, Error> {
        let read = |(number, buffer): (usize, &Buffer)| {
            let bytes = one(file, number, buffer, binary)?;
            let found = bytes.len() as u64;
            if found < buffer.byte_length {
                let announced = buffer.byte_length;
                return Err(file.truncated(format!("buffer {number} has {found} bytes, but {announced} are announced")));
            }
            Ok(bytes)
        };
        document.buffers.iter().enumerate().map(read).collect::<Result<_, Error>>().map(Self)
    }

    /// Returns the bytes of a buffer.
    pub fn get(&self, number: usize) -> Option<&[u8]> {
        self.0.get(number).map(|bytes| &**bytes)
    }

    /// Returns the number of bytes of all.
    pub fn len(&self) -> u64 {
        self.0.iter().map(|bytes| bytes.len() as u64).sum()
    }
}

fn one<'a>(
    file: &SharedFile,
    number: usize,
    buffer: &Buffer,
    binary: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>, Error> {
    let wrong = |cause: &str| file.malformed(format!("buffer {number}"), cause);
    let Some(uri) = &buffer.uri else {
        let within = binary.filter(|_| number == 0);
        return within
            .map(Cow::Borrowed)
            .ok_or_else(|| wrong("it has no `uri`, and no bytes follow the text of the file"));
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, content) = data.split_once(',').ok_or_else(|| wrong("its data: URI has no comma"))?;
        if !kind.ends_with(";base64") {
            return Err(wrong("its data: URI is not base64"));
        }
        let bytes = BASE64_STANDARD.decode(content).map_err(|e| wrong(&format!("base64: {e}")))?;
        return Ok(bytes.into());
    }
    let name = decoded(uri).filter(|name| !name.contains("://") && !Path::new(name).is_absolute());
    let name = name.ok_or_else(|| wrong(&format!("{uri:?} is not the name of a file next to this one")))?;
    let path = file.path().parent().map(PathBuf::from).unwrap_or_default().join(name);
    Ok(all_bytes(InputFile::open(&path)?)?.1.into())
}

/// The text of a URI: a percent sign and two digits stand for a byte.
pub fn decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let (digits, rest) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend(rest.as_bytes());
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_uris() {
        for (uri, name) in [("a.bin", "a.bin"), ("a%20b.bin", "a b.bin"), ("%C3%A4", "ä")] {
            assert_eq!(decoded(uri).as_deref(), Some(name));
        }
        for wrong in ["a%2", "a%", "%zz", "%ff", "%ä"] {
            assert_eq!(decoded(wrong), None, "{wrong}");
        }
    }
}
