//! Extra bytes: dimensions that a LAS file adds to its point records (LAS 1.4, table 24).

use super::header::until_zero;
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
    /// The stored number of points without a value.
    no_data: Option<f64>,
}

/// Returns `true` for a record that describes extra bytes.
pub(super) fn is_record(user: &[u8], id: u16) -> bool {
    user == b"LASF_Spec" && id == 4
}

/// Returns the described scalar dimensions within the extra bytes. Arrays and undescribed bytes are skipped.
/// `descriptors` are those of all records, one behind the other.
pub(super) fn dimensions(descriptors: &[u8], extra_bytes: u16) -> Vec<Dimension> {
    let mut dimensions = Vec::new();
    let mut offset = 0;
    for descriptor in descriptors.chunks_exact(DESCRIPTOR) {
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
            let has = |bit: u8| options >> bit & 1 == 1;
            let option = |bit: u8, at: usize, default| {
                if has(bit) { NumberType::Double.read(&descriptor[at..]) } else { default }
            };
            let name = String::from_utf8_lossy(until_zero(&descriptor[4..36])).trim().to_owned();
            let (scale, shift) = (option(3, 112, 1.0), option(4, 136, 0.0));
            let no_data = has(0).then(|| no_data(kind, &descriptor[40..]));
            dimensions.push(Dimension { name, offset, kind, scale, shift, no_data });
        }
        offset += bytes;
    }
    dimensions
}

/// Returns the number that means "no value". It is stored in the widest type of the dimension's class, whose first
/// bytes are the number itself, also where a writer forgot the sign.
fn no_data(kind: NumberType, bytes: &[u8]) -> f64 {
    match kind {
        // Numbers of points are rounded to float32 as well.
        NumberType::Float => f64::from(NumberType::Double.read(bytes) as f32),
        kind => kind.read(bytes),
    }
}

impl Dimension {
    /// Returns the value in the extra bytes of one point, scaled; NaN if it has none.
    pub fn value(&self, extra: &[u8]) -> f32 {
        let stored = self.kind.read(&extra[self.offset..]);
        if self.no_data == Some(stored) { f32::NAN } else { (stored * self.scale + self.shift) as f32 }
    }
}
