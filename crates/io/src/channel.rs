//! Color and alpha channels: finds the stored number of full intensity, and converts the others to linear light.

use glam::Vec3;
use rayon::prelude::*;

use super::columns::ScalarType;
use pellucid_core::color::{FULL_INTEGERS, decode_srgb, linear_values};
use pellucid_core::parallel;

/// Colors up to this limit are meant to be at most 1, and the excess is clamped: bytes of at most 2 would be black.
const UNIT: f32 = 2.0;

/// Writers that count to 256 mean 255.
const MOST_OF_BYTES: f32 = 256.0;

/// A color or alpha channel.
#[derive(Debug)]
pub(super) struct Channel {
    /// Index of the column in a row.
    pub at: usize,
    scale: Scale,
}

#[derive(Debug, Clone, Copy)]
enum Scale {
    /// Bytes. Signed bytes are bytes that someone declared wrongly.
    Byte {
        signed: bool,
        /// Linear values of all of them.
        linear: &'static [f32],
    },
    /// Linear values, as stored.
    Linear,
    /// Numbers that stay as they are until the largest of them is known.
    Measured,
}

impl Channel {
    /// Returns the channel of linear floats at a place of the row.
    pub fn linear_float(at: usize) -> Self {
        Self { at, scale: Scale::Linear }
    }

    /// Returns `true` if the range is that of all values, which are stored until it is known.
    pub fn is_measured(&self) -> bool {
        matches!(self.scale, Scale::Measured)
    }

    /// Returns the channel at a place of the row, by the type that it is stored as: only bytes tell their range, since
    /// writers put bytes into shorts, integers and floats.
    pub fn new(at: usize, scalar: &ScalarType) -> Self {
        let byte = |signed| Scale::Byte { signed, linear: linear_values(u8::MAX.into()) };
        let scale = match scalar {
            ScalarType::UChar => byte(false),
            ScalarType::Char => byte(true),
            _ => Scale::Measured,
        };
        Self { at, scale }
    }

    /// Returns the channel of the numbers of this one, as they are stored.
    pub fn stored(self) -> Self {
        Self { scale: Scale::Measured, ..self }
    }

    /// The stored byte.
    #[inline]
    fn byte(value: f64, signed: bool) -> u8 {
        let value = if signed && value < 0.0 { value + 256.0 } else { value };
        // The conversion saturates, and turns NaN into 0.
        value as u8
    }

    /// Returns the linear value of an sRGB-encoded channel, or what is stored if its range is not known yet.
    #[inline]
    pub fn linear(&self, value: f64) -> f32 {
        match self.scale {
            Scale::Byte { signed, linear } => linear[usize::from(Self::byte(value, signed))],
            Scale::Linear => unit_or(0.0, value as f32),
            Scale::Measured => value as f32,
        }
    }

    /// Returns the value clamped to [0, 1]; NaN counts as 1. One whose range is not known yet stays as it is.
    #[inline]
    pub fn unit(&self, value: f64) -> f32 {
        match self.scale {
            Scale::Byte { signed, .. } => f32::from(Self::byte(value, signed)) / 255.0,
            Scale::Linear => unit_or(1.0, value as f32),
            Scale::Measured => value as f32,
        }
    }
}

/// Returns a value clamped to [0, 1], and another one in place of NaN.
#[inline]
pub(super) fn unit_or(other: f32, value: f32) -> f32 {
    if value.is_nan() { other } else { value.clamp(0.0, 1.0) }
}

/// Returns the largest finite value.
pub(super) fn largest(values: impl ParallelIterator<Item = f32>) -> Option<f32> {
    values.filter(|value| value.is_finite()).max_by(f32::total_cmp)
}

/// Returns the number of full intensity in values whose type doesn't define it, by the largest of them: 1 if that is no
/// larger, else that of the fewest bits that hold it ([`full_integer`]). `None` if no value is above 0.
pub(super) fn full_scale(largest: Option<f32>) -> Option<f32> {
    let largest = largest.filter(|&largest| largest > 0.0)?;
    Some(if largest <= UNIT { 1.0 } else { full_integer(largest).into() })
}

/// Returns the number of full intensity in integers of which this is the largest: many writers put 8, 10 or 12 bits
/// into wider fields.
pub(super) fn full_integer(largest: f32) -> u16 {
    let bytes = largest <= MOST_OF_BYTES;
    let full = FULL_INTEGERS.into_iter().find(|&full| bytes || largest <= f32::from(full));
    full.unwrap_or(u16::MAX)
}

/// Returns linear colors from sRGB-encoded ones, by the number of full intensity ([`full_scale`]). A color without any
/// number is white, like points without color.
pub(super) fn measured(mut colors: Vec<Vec3>, full: f32) -> Vec<Vec3> {
    let channel = |value: f32| if value.is_nan() { 0.0 } else { decode_srgb((value / full).clamp(0.0, 1.0)) };
    let linear = |color: &Vec3| {
        let encoded = color.to_array();
        if encoded.iter().all(|value| value.is_nan()) { Vec3::ONE } else { Vec3::from(encoded.map(channel)) }
    };
    parallel::for_each_mut(&mut colors, |_, color| *color = linear(color));
    colors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear colors of a table of encoded ones.
    fn decoded_all(encoded: &[[f32; 3]]) -> Option<Vec<Vec3>> {
        let full = full_scale(largest(encoded.par_iter().flat_map_iter(|color| *color)))?;
        Some(measured(encoded.iter().copied().map(Vec3::from).collect(), full))
    }

    #[test]
    fn the_range_is_that_of_all_values() {
        let decoded = |value: f32, full: f32| decode_srgb(value / full);
        assert_eq!(decoded_all(&[[0.0; 3], [-1.0, f32::NAN, 0.0]]), None);
        assert_eq!(decoded_all(&[[0.5, 1.0, 0.0]]).unwrap(), [Vec3::new(decoded(0.5, 1.0), 1.0, 0.0)]);
        let bytes = decoded_all(&[[0.5, 1.0, 0.0], [51.0, 255.0, -3.0]]).unwrap();
        assert_eq!(bytes[0], Vec3::new(decoded(0.5, 255.0), decoded(1.0, 255.0), 0.0));
        assert_eq!(bytes[1], Vec3::new(decoded(51.0, 255.0), 1.0, 0.0));
        let shorts = decoded_all(&[[5e3, 0.0, 0.0], [f32::INFINITY, f32::NAN, 0.0], [f32::NAN; 3]]).unwrap();
        assert_eq!(shorts, [Vec3::new(decoded(5e3, 65535.0), 0.0, 0.0), Vec3::X, Vec3::ONE]);
    }

    #[test]
    fn full_intensity_is_that_of_the_fewest_bits() {
        for (largest, full) in [
            (0.5, 1.0),
            (1.0, 1.0),
            (1.5, 1.0),
            (3.0, 255.0),
            (255.0, 255.0),
            (256.0, 255.0),
            (257.0, 1023.0),
            (1023.0, 1023.0),
            (3200.0, 4095.0),
            (4096.0, 65535.0),
            (1e9, 65535.0),
        ] {
            assert_eq!(full_scale(Some(largest)), Some(full), "{largest}");
        }
        assert_eq!([None, Some(0.0), Some(-7.0)].map(full_scale), [None; 3]);
    }
}
