//! Compressed splats in PLY files, by PlayCanvas: 256 splats share a chunk with their ranges, and a splat has four
//! words.
//!
//! - `chunk`: floats `min_x` … `max_z`, `min_scale_x` … `max_scale_z`, perhaps `min_r` … `max_b`.
//! - `vertex`: words `packed_position` and `packed_scale` (11, 10 and 11 bits), `packed_rotation` (the largest of w, x,
//!   y, z, then three times 10 bits), `packed_color` (four bytes).
//! - `sh`, perhaps: bytes `f_rest_0` ….

use glam::{DQuat, DVec3};

use super::header::{Element, PlyHeader, ScalarType, size};
use super::payload;
use crate::splats::{Splat, Splats, quaternion};
use crate::{Error, InputFile, SharedFile, memory};
use pellucid_core::cloud::gaussians::{MAX_DEGREE, coefficients};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;

/// Splats of a chunk.
const CHUNK: usize = 256;

/// Words of a splat.
const PACKED: [&str; 4] = ["packed_position", "packed_rotation", "packed_scale", "packed_color"];

/// Ranges of a chunk: each with its three axes, and its two ends.
const RANGES: [[&str; 6]; 3] = [
    ["min_x", "min_y", "min_z", "max_x", "max_y", "max_z"],
    ["min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z"],
    ["min_r", "min_g", "min_b", "max_r", "max_g", "max_b"],
];

/// A file of compressed splats whose header is read.
pub(crate) struct Compressed {
    source: InputFile,
    header: PlyHeader,
    vertex: usize,
}

/// Returns `true` if the vertices are compressed splats.
pub(super) fn are_compressed(vertex: &Element) -> bool {
    PACKED.iter().all(|name| vertex.place(name).is_some())
}

/// Records of one size, and the places of some of their values.
struct Records {
    bytes: Vec<u8>,
    len: usize,
    values: Vec<(usize, ScalarType)>,
    little_endian: bool,
}

impl Compressed {
    pub(super) fn new(source: InputFile, header: PlyHeader, vertex: usize) -> Self {
        Self { source, header, vertex }
    }

    /// Reads all splats.
    pub fn read(self, progress: &Progress) -> Result<Cloud, Error> {
        let Self { source, header, vertex } = self;
        let file = SharedFile::from(source);
        let count = header.elements[vertex].count;
        let wrong = |cause: String| file.malformed("header", cause);
        let named = |name: &str| header.elements.iter().position(|element| element.name == name);
        let chunk = named("chunk")
            .ok_or_else(|| wrong("compressed splats need an element `chunk`, but there is none".to_owned()))?;
        let chunks = header.elements[chunk].count;
        if chunks != count.div_ceil(CHUNK as u64) {
            return Err(wrong(format!("{chunks} chunks of {CHUNK} splats don't match {count} splats")));
        }
        let harmonics = named("sh").map(|at| (at, &header.elements[at]));
        let degree = harmonics.map_or(Ok(0), |(_, element)| degree(element, count)).map_err(wrong)?;
        memory::check(file.path(), count, Splats::bytes(degree))?;
        let has_colors = header.elements[chunk].place(RANGES[2][0]).is_some();
        let ranges: Vec<_> = RANGES.iter().take(if has_colors { 3 } else { 2 }).flatten().copied().collect();
        let ranges = Records::read(&file, &header, chunk, &ranges)?;
        let words = Records::read(&file, &header, vertex, &PACKED)?;
        let names: Vec<_> = (0..3 * coefficients(degree)).map(|at| format!("f_rest_{at}")).collect();
        let names: Vec<_> = names.iter().map(String::as_str).collect();
        let rest = harmonics.map(|(at, _)| Records::read(&file, &header, at, &names)).transpose()?;
        let splats = Splats::gather(count as usize, degree, progress, |at, harmonics| {
            if let Some(rest) = &rest {
                let each = harmonics.len();
                for (place, color) in harmonics.iter_mut().enumerate() {
                    *color = DVec3::from([0, 1, 2].map(|c| coefficient(rest.value(at, c * each + place)))).as_vec3();
                }
            }
            splat(&words, at, &ranges, has_colors)
        });
        Ok(splats.finish(UpAxis::NegativeY))
    }
}

/// The degree of the harmonics of an element, or what is wrong with it.
fn degree(element: &Element, count: u64) -> Result<u32, String> {
    let found = element.properties.len();
    if element.count != count {
        return Err(format!("element `sh` has {} records for {count} splats", element.count));
    }
    let degree = (0..=MAX_DEGREE).find(|degree| 3 * coefficients(*degree) == found);
    degree.ok_or_else(|| format!("{found} properties of element `sh`, expected 0, 9, 24, 45 or 72"))
}

/// The coefficient of a byte.
fn coefficient(byte: f64) -> f64 {
    let unit = if byte == 0.0 || byte == 255.0 { byte / 255.0 } else { (byte + 0.5) / 256.0 };
    (unit - 0.5) * 8.0
}

fn splat(words: &Records, at: usize, ranges: &Records, has_colors: bool) -> Splat {
    let [position, rotation, scale, color] = [0, 1, 2, 3].map(|place| words.value(at, place) as u32);
    let chunk = at / CHUNK;
    let range = |first: usize| DVec3::from([0, 1, 2].map(|axis| ranges.value(chunk, first + axis)));
    let between = |which: usize, t: DVec3| {
        let (least, most) = (range(6 * which), range(6 * which + 3));
        least * (1.0 - t) + most * t
    };
    let [red, green, blue, alpha] = [24, 16, 8, 0].map(|shift| bits(color, shift, 8));
    let (logarithms, color) = (between(1, three(scale)), DVec3::new(red, green, blue));
    Splat {
        // Positions were float32 before they were compressed.
        center: between(0, three(position)).as_vec3().as_dvec3(),
        extents: DVec3::new(logarithms.x.exp(), logarithms.y.exp(), logarithms.z.exp()),
        rotation: self::rotation(rotation),
        base: if has_colors { between(2, color) } else { color },
        linear: false,
        alpha,
    }
}

/// Some bits of a word, from 0 to 1.
fn bits(word: u32, shift: u32, count: u32) -> f64 {
    let most = (1 << count) - 1;
    f64::from(word >> shift & most) / f64::from(most)
}

/// Numbers of 11, 10 and 11 bits.
fn three(word: u32) -> DVec3 {
    DVec3::new(bits(word, 21, 11), bits(word, 11, 10), bits(word, 0, 11))
}

/// The largest of w, x, y and z by its number, then the others.
fn rotation(word: u32) -> DQuat {
    quaternion(word >> 30, [20, 10, 0].map(|shift| (bits(word, shift, 10) - 0.5) * std::f64::consts::SQRT_2))
}

impl Records {
    /// All records of an element; the named properties are its values.
    fn read(file: &SharedFile, header: &PlyHeader, at: usize, names: &[&str]) -> Result<Self, Error> {
        let wrong = |cause: String| file.malformed("header", cause);
        let mut start = u128::from(header.len);
        for element in &header.elements[..=at] {
            if element.scalars().len() < element.properties.len() {
                return Err(wrong(format!(
                    "element `{}` has a list, which compressed splats can't have",
                    element.name
                )));
            }
            start += u128::from(element.least_bytes()) * u128::from(element.count);
        }
        let element = &header.elements[at];
        let (len, bytes) = (element.least_bytes(), u128::from(element.least_bytes()) * u128::from(element.count));
        if start > u128::from(file.len()) {
            let what = format!(
                "{} records of element `{}` with {len} bytes each end at byte {start}",
                element.count, element.name
            );
            return Err(file.truncated(format!("{what}, but the file has {} bytes", file.len())));
        }
        let values = names.iter().map(|name| {
            element.place(name).ok_or_else(|| wrong(format!("element `{}` has no property `{name}`", element.name)))
        });
        Ok(Self {
            values: values.collect::<Result<_, Error>>()?,
            bytes: file.read((start - bytes) as u64, bytes as u64)?,
            len: len as usize,
            little_endian: header.encoding == ply_rs_bw::ply::Encoding::BinaryLittleEndian,
        })
    }

    /// A value of a record.
    fn value(&self, record: usize, value: usize) -> f64 {
        let (at, kind) = &self.values[value];
        let mut found = [0.0];
        let record = &self.bytes[record * self.len..][..self.len];
        payload::column(record, self.len, *at, kind, self.little_endian, &mut found);
        found[0]
    }
}

impl Element {
    /// The byte of a property in a record whose properties are no lists, and its type.
    fn place(&self, name: &str) -> Option<(usize, ScalarType)> {
        let mut at = 0;
        for property in &self.properties {
            let kind = property.kind.scalar()?;
            if property.name == name {
                return Some((at, kind.clone()));
            }
            at += size(kind) as usize;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_harmonics() {
        assert_eq!([0.0, 255.0, 127.0, 128.0].map(coefficient), [-4.0, 4.0, -0.015_625, 0.015_625]);
    }

    #[test]
    fn parts_of_words() {
        let all = three(0x7ff << 21 | 0x3ff << 11);
        assert_eq!(all, DVec3::new(1.0, 1.0, 0.0));
        let [x, y, z, w] = rotation(2 << 30 | 1023 << 20 | 512 << 10 | 511).to_array();
        assert!((w - 0.5 * std::f64::consts::SQRT_2).abs() < 1e-15 && (y - w).abs() < 1e-6, "{y} {w}");
        assert!(x > 0.0 && x < 1e-3 && z < 0.0 && z > -1e-3, "{x} {z}");
    }
}
