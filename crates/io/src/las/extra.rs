//! Extra bytes: dimensions that a LAS file adds to its point records (LAS 1.4, table 24).

use las::raw::Vlr;

use super::header::user_id;

/// Bytes of one descriptor in the record.
const DESCRIPTOR: usize = 192;

/// A named number in the extra bytes of each point.
#[derive(Debug)]
pub(super) struct Dimension {
    pub name: String,
    /// Bytes from the start of the extra bytes.
    offset: usize,
    kind: u8,
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
            1..=30 => size((kind - 1) % 10 + 1) * (usize::from(kind - 1) / 10 + 1),
            _ => break,
        };
        if offset + bytes > usize::from(extra_bytes) {
            break;
        }
        if (1..=10).contains(&kind) {
            let name = descriptor[4..36].split(|&byte| byte == 0).next().unwrap_or_default();
            let option = |bit: u8, at: usize, default| {
                if options >> bit & 1 == 1 { f64::from_le_bytes(eight(&descriptor[at..])) } else { default }
            };
            let name = String::from_utf8_lossy(name).trim().to_owned();
            dimensions.push(Dimension { name, offset, kind, scale: option(3, 112, 1.0), shift: option(4, 136, 0.0) });
        }
        offset += bytes;
    }
    dimensions
}

/// Bytes of the kinds 1 to 10.
fn size(kind: u8) -> usize {
    match kind {
        1 | 2 => 1,
        3 | 4 => 2,
        5 | 6 | 9 => 4,
        _ => 8,
    }
}

/// The first eight bytes, zeros for those that are missing.
fn eight(bytes: &[u8]) -> [u8; 8] {
    let mut eight = [0; 8];
    let known = bytes.len().min(8);
    eight[..known].copy_from_slice(&bytes[..known]);
    eight
}

impl Dimension {
    /// Returns the value in the extra bytes of one point, scaled.
    pub fn value(&self, extra: &[u8]) -> f32 {
        let bytes = eight(&extra[self.offset..]);
        let [b0, b1, b2, b3, ..] = bytes;
        let stored = match self.kind {
            1 => b0.into(),
            2 => (b0 as i8).into(),
            3 => u16::from_le_bytes([b0, b1]).into(),
            4 => i16::from_le_bytes([b0, b1]).into(),
            5 => u32::from_le_bytes([b0, b1, b2, b3]).into(),
            6 => i32::from_le_bytes([b0, b1, b2, b3]).into(),
            7 => u64::from_le_bytes(bytes) as f64,
            8 => i64::from_le_bytes(bytes) as f64,
            9 => f32::from_le_bytes([b0, b1, b2, b3]).into(),
            _ => f64::from_le_bytes(bytes),
        };
        (stored * self.scale + self.shift) as f32
    }
}
