//! Fields of the header and records that LAS has since 1.4.

use super::header::until_zero;
use crate::number::{long, short, word};
use crate::{Error, InputFile};

/// Place of the first of the fields in the header, and their bytes.
const FIELDS: (u64, usize) = (235, 20);

/// Bytes of an extended variable-length record before its data.
const HEADER: u64 = 60;

/// Records that are read take no more: descriptors of extra bytes, of which a point has at most 65535.
const MOST_BYTES: u64 = 192 << 16;

/// Records that are read at most.
const MOST_RECORDS: usize = 64;

/// A record of the header or behind the points.
#[derive(Debug)]
pub(super) struct Record {
    /// User of the record, without the zeros behind the name.
    pub user: Vec<u8>,
    pub id: u16,
    pub data: Vec<u8>,
}

/// Fields for files that are larger than 32 bits can say.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LargeFields {
    /// The first byte of the extended records.
    start: u64,
    /// The number of these records.
    records: u32,
    /// The number of points.
    pub points: u64,
}

impl LargeFields {
    /// Reads the fields; before 1.4 they are all 0.
    pub fn read(source: &mut InputFile, minor: u8) -> Result<Self, Error> {
        if minor < 4 {
            return Ok(Self::default());
        }
        let (at, len) = FIELDS;
        if source.len < at + len as u64 {
            return Err(source.truncated(format!("the file ends within the LAS header, at byte {}", source.len)));
        }
        let bytes = source.bytes(at, len)?;
        Ok(Self { start: long(&bytes, 0), records: word(&bytes, 8), points: long(&bytes, 12) })
    }
}

/// Returns the extended records that are wanted, by user and identifier. Records that the file has no bytes for are
/// ignored, as are all behind them.
pub(super) fn read(
    source: &mut InputFile,
    large: &LargeFields,
    is_wanted: impl Fn(&[u8], u16) -> bool,
) -> Result<Vec<Record>, Error> {
    let mut found = Vec::new();
    let mut at = large.start;
    for _ in 0..large.records {
        let data = at.saturating_add(HEADER);
        if at == 0 || data > source.len {
            break;
        }
        let header = source.bytes(at, HEADER as usize)?;
        let (user, id, len) = (until_zero(&header[2..18]), short(&header, 18), long(&header, 20));
        if len > source.len - data {
            break;
        }
        if is_wanted(user, id) && found.len() < MOST_RECORDS && len <= MOST_BYTES {
            let (user, data) = (user.to_vec(), source.bytes(data, len as usize)?);
            found.push(Record { user, id, data });
        }
        at = data + len;
    }
    Ok(found)
}
