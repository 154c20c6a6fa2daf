//! Extra bytes: dimensions that a LAS file adds to its point records (LAS 1.4, table 24).

use las::raw::Vlr;

use super::header::user_id;
use crate::number::NumberType;

/// The kinds from 1 on.
const KINDS: [NumberType; 10] = [
    NumberType::Uint8,
    NumberType::Int8,
    NumberType::Uint16,
    NumberType::Int16,
    NumberType::Uint32,
    NumberType::Int32,
    NumberType::Uint64,
    NumberType::Int64,
    NumberType::Float,
    NumberType::Double,
];

/// Bytes of one descriptor in the record.
const DESCRIPTOR: usize = 192;

/// A named number in the extra bytes of each point.
#[derive(Debug)]
pub(super) struct Dimension {
    pub name: String,
    /// Bytes from the start of the extra bytes.
    offset: usize,
    kind: NumberType,
    scale: f64,
    shift: f64,
}

/// Returns the described scalar dimensions within the extra bytes. Arrays and undescribed bytes are skipped.
pub(super) fn dimensions(vlrs: &[Vlr], extra_bytes: u16) -> Vec<Dimension> {
    let Some(vlr) = vlrs.iter().find(|vlr| user_id(vlr) == b"LASF_Spec" && vlr.record_id == 4) else {
        return Vec::new();
    };
    let mut dimensions = Vec::new();
    let mut offset = 0;
    for descriptor in vlr.data.chunks_exact(DESCRIPTOR) {
        let (kind, options) = (descriptor[2], descriptor[3]);
        // Kinds 11–30 are arrays of two and three; kind 0 is as many bytes as the options say.
        let bytes = match kind {
            0 => options.into(),
            1..=30 => {
                let (kind, more) = ((kind - 1) % 10, (kind - 1) / 10);
                KINDS[usize::from(kind)].bytes().unwrap_or(0) * (usize::from(more) + 1)
            }
            _ => break,
        };
        if offset + bytes > usize::from(extra_bytes) {
            break;
        }
        if let Some(&kind) = usize::from(kind).checked_sub(1).and_then(|kind| KINDS.get(kind)) {
            let name = descriptor[4..36].split(|&byte| byte == 0).next().unwrap_or_default();
            let option = |bit: u8, at: usize, default| {
                if options >> bit & 1 == 1 { NumberType::Double.read(&descriptor[at..]) } else { default }
            };
            let name = String::from_utf8_lossy(name).trim().to_owned();
            dimensions.push(Dimension { name, offset, kind, scale: option(3, 112, 1.0), shift: option(4, 136, 0.0) });
        }
        offset += bytes;
    }
    dimensions
}

impl Dimension {
    /// Returns the value in the extra bytes of one point, scaled.
    pub fn value(&self, extra: &[u8]) -> f32 {
        (self.kind.read(&extra[self.offset..]) * self.scale + self.shift) as f32
    }
}
