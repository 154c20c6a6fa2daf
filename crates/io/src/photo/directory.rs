//! The directory of a TIFF file. Its claims are compared with the file's length, because the decoder allocates memory
//! without doing so.

use std::io::{Read, Seek, SeekFrom};

use super::InputFile;
use crate::Error;

/// Bytes of an entry: tag, type, number of values, and the values or where they are.
const ENTRY: usize = 12;

/// Fails if an entry of the first directory has more values than the file could hold. Leaves the source at its start;
/// files that are no TIFF, or end too early, are left to the decoder.
pub(super) fn check(source: &mut InputFile) -> Result<(), Error> {
    let entries = entries(source);
    source.reader.rewind().map_err(|e| source.read_error(e))?;
    let Ok(Some(entries)) = entries else { return Ok(()) };
    for (tag, kind, count) in entries {
        if u64::from(count) * size(kind) > source.len {
            let (len, what) = (source.len, format!("tag {tag} of the TIFF directory announces {count} values"));
            return Err(source.truncated(format!("{what}, but the file has only {len} bytes")));
        }
    }
    Ok(())
}

/// Tag, type and number of values of an entry.
type Entry = (u16, u16, u32);

/// The entries of the first directory; `None` if the file is no TIFF.
fn entries(source: &mut InputFile) -> std::io::Result<Option<Vec<Entry>>> {
    let mut start = [0; 8];
    source.reader.read_exact(&mut start)?;
    let is_little = match &start[..4] {
        b"II*\0" => true,
        b"MM\0*" => false,
        _ => return Ok(None),
    };
    let two = |b: [u8; 2]| if is_little { u16::from_le_bytes(b) } else { u16::from_be_bytes(b) };
    let four = |b: [u8; 4]| if is_little { u32::from_le_bytes(b) } else { u32::from_be_bytes(b) };
    let [.., a, b, c, d] = start;
    source.reader.seek(SeekFrom::Start(four([a, b, c, d]).into()))?;
    let mut count = [0; 2];
    source.reader.read_exact(&mut count)?;
    // 65 535 of them at most.
    let mut bytes = vec![0; usize::from(two(count)) * ENTRY];
    source.reader.read_exact(&mut bytes)?;
    let entry = |e: &[u8; ENTRY]| (two([e[0], e[1]]), two([e[2], e[3]]), four([e[4], e[5], e[6], e[7]]));
    Ok(Some(bytes.as_chunks().0.iter().map(entry).collect()))
}

/// Bytes of a value of a type; one for unknown types.
fn size(kind: u16) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 1,
    }
}
