//! Converts the numbers of a point to a row of columns: unpacks colors, skips padding, numbers groups.

use super::header::{Field, Header};
use crate::columns::{Column, ScalarType};
use crate::number::number;

/// The use of a field.
enum Use {
    /// Unused: padding, or a group of no numbers.
    Skip,
    /// Each number is a column.
    Numbers,
    /// Bytes of a word: blue, green, red from the lowest up, and alpha if present.
    Packed { alpha: bool },
}

/// The fields of a point and the columns that they become.
pub(super) struct PcdLayout<'a> {
    fields: Vec<(&'a Field, Use)>,
    pub columns: Vec<Column>,
}

impl<'a> PcdLayout<'a> {
    /// The header's size must have been checked against the file's, since every number of a group is a column.
    pub fn for_header(header: &'a Header) -> Self {
        let mut columns = Vec::new();
        let fields = header.fields.iter().map(|field| {
            let used = usage(field);
            match used {
                Use::Skip => {}
                Use::Packed { alpha } => {
                    let names = ["red", "green", "blue", "alpha"].into_iter().take(3 + usize::from(alpha));
                    columns.extend(names.map(|name| Column::new(name, ScalarType::UChar)));
                }
                Use::Numbers if field.count == 1 => columns.push(Column::new(&field.name, field.scalar())),
                Use::Numbers => {
                    columns
                        .extend((0..field.count).map(|i| Column::new(format!("{}_{i}", field.name), field.scalar())));
                }
            }
            (field, used)
        });
        Self { fields: fields.collect(), columns }
    }

    /// Makes a row of the bytes of a point.
    pub fn bytes(&self, mut record: &[u8], row: &mut Vec<f64>) {
        row.clear();
        for (field, used) in &self.fields {
            let (bytes, rest) = record.split_at(field.bytes() as usize);
            record = rest;
            match used {
                Use::Skip => {}
                Use::Numbers => row.extend(bytes.chunks_exact(field.size).map(|number| field.kind.read(number))),
                Use::Packed { alpha } => unpack(bytes.try_into().unwrap_or_default(), *alpha, row),
            }
        }
    }

    /// Makes a row of the words of a point; fails with what is wrong with one of them.
    pub fn words<'w>(&self, mut words: impl Iterator<Item = &'w str>, row: &mut Vec<f64>) -> Result<(), String> {
        row.clear();
        for (field, used) in &self.fields {
            for _ in 0..field.count {
                let word = words.next().ok_or_else(|| format!("there is no value for field `{}`", field.name))?;
                let wrong = || format!("field `{}`: `{word}` is not a number", field.name);
                match used {
                    Use::Skip => {}
                    Use::Numbers => row.push(number(word).ok_or_else(wrong)?),
                    Use::Packed { alpha } => {
                        let packed = packed(word).ok_or_else(wrong)?;
                        unpack(packed.to_le_bytes(), *alpha, row);
                    }
                }
            }
        }
        match words.count() {
            0 => Ok(()),
            more => Err(format!("{more} more values than there are fields")),
        }
    }
}

fn usage(field: &Field) -> Use {
    let packed = |name: &str| field.size == 4 && field.count == 1 && field.name.eq_ignore_ascii_case(name);
    match field.name.as_str() {
        _ if field.count == 0 => Use::Skip,
        "_" => Use::Skip,
        _ if packed("rgb") => Use::Packed { alpha: false },
        _ if packed("rgba") => Use::Packed { alpha: true },
        _ => Use::Numbers,
    }
}

/// Opaque white, the color of points without one.
const WHITE: u32 = u32::MAX;

/// A packed color in text: an integer, or the float whose bits it is. A word for what is no number has lost the bits.
fn packed(word: &str) -> Option<u32> {
    let signed = || word.parse::<i32>().ok().map(i32::cast_unsigned);
    let float = |float: f32| if float.is_nan() { WHITE } else { float.to_bits() };
    let special = || number(word).filter(|value| value.is_nan()).map(|_| WHITE);
    word.parse().ok().or_else(signed).or_else(|| word.parse().ok().map(float)).or_else(special)
}

fn unpack([blue, green, red, alpha]: [u8; 4], has_alpha: bool, row: &mut Vec<f64>) {
    row.extend([red, green, blue].map(f64::from));
    if has_alpha {
        row.push(alpha.into());
    }
}
