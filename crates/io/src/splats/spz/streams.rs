//! SPZ 4: a plain header, a table of lengths, and a Zstandard stream for each plane.

use super::planes::{NAMES, Planes, lengths};
use super::{Content, Error, Header, SharedFile};
use crate::decoder;
use crate::number::{long, word};

/// Bytes of the header.
const HEADER: u64 = 32;

/// Bytes of a line of the table: those of the stream, and those that come of it.
const LINE: u64 = 16;

/// Returns the planes of a file, and the records of extensions, which stand before the table. Only as much of a stream
/// is unpacked as its plane has.
pub(super) fn read(file: &SharedFile, bytes: &[u8], header: Header) -> Result<Content, Error> {
    if (bytes.len() as u64) < HEADER {
        return Err(file.truncated(format!("the file has {} bytes, but the header alone has {HEADER}", bytes.len())));
    }
    header.check(file, Some(bytes.len() as u64))?;
    let (streams, table) = (u64::from(bytes[15]), u64::from(word(bytes, 16)));
    let lengths = lengths(&header);
    // Planes without bytes have no stream.
    let expected = lengths.iter().filter(|len| **len > 0).count() as u64;
    if streams != expected {
        let cause = format!("{streams} streams, expected {expected} for harmonics of degree {}", header.degree);
        return Err(file.malformed("byte 15 of the header", cause));
    }
    let mut place = table + streams * LINE;
    if table < HEADER || place > bytes.len() as u64 {
        let cause = format!("a table of {streams} streams at byte {table}, but the file has {} bytes", bytes.len());
        return Err(file.malformed("byte 16 of the header", cause));
    }
    let mut planes: [Vec<u8>; 6] = Default::default();
    let mut lines = bytes[table as usize..place as usize].chunks_exact(LINE as usize);
    for ((plane, len), name) in planes.iter_mut().zip(lengths).zip(NAMES) {
        let Some(line) = (if len > 0 { lines.next() } else { None }) else { continue };
        let (packed, raw) = (long(line, 0), long(line, 8));
        if raw != len {
            let cause = format!("{raw} bytes are announced, but {} splats have {len}", header.count);
            return Err(file.malformed(format!("stream of {name}"), cause));
        }
        let Some(end) = place.checked_add(packed).filter(|end| *end <= bytes.len() as u64) else {
            let cause = format!(
                "the stream of {name} has {packed} bytes from byte {place} on, but the file has {}",
                bytes.len()
            );
            return Err(file.truncated(cause));
        };
        *plane = unpacked(&bytes[place as usize..end as usize], len)
            .map_err(|cause| file.malformed(format!("stream of {name}"), cause))?;
        place = end;
    }
    let records = bytes[HEADER as usize..table as usize].to_vec();
    Ok(Content { planes: Planes::new(&header, planes), header, records })
}

/// The bytes of a stream, which are to be so many, or what is wrong with them.
fn unpacked(stream: &[u8], len: u64) -> Result<Vec<u8>, String> {
    let all = decoder::zstandard(stream, len)?;
    match all.len() as u64 {
        found if found == len => Ok(all),
        found if found < len => Err(format!("it ends after {found} of {len} bytes")),
        _ => Err(format!("it has more than the {len} bytes that are announced")),
    }
}
