//! Fields of the header and records that LAS has since 1.4.

use super::extra;
use super::header::until_zero;
use crate::number::{long, short, word};
use crate::{Error, InputFile};

/// Place of the first of the fields in the header, and their bytes.
const FIELDS: (u64, usize) = (235, 20);

/// Bytes of an extended variable-length record before its data.
const HEADER: u64 = 60;

/// Descriptors of extra bytes take no more, since a point has at most 65535 of them.
const MOST_DESCRIBED: u64 = 192 << 16;

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

/// Returns the descriptors of extra bytes in extended records, one behind the other. Records that the file has no
/// bytes for are ignored, as are all behind them.
pub(super) fn extra_bytes(source: &mut InputFile, large: &LargeFields) -> Result<Vec<u8>, Error> {
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
        if extra::is_record(user, id) && len <= MOST_DESCRIBED {
            found.extend(source.bytes(data, len as usize)?);
        }
        at = data + len;
    }
    Ok(found)
}
