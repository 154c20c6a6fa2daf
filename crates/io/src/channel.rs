//! Color and alpha channels: finds the stored number of full intensity, and converts the others to linear light.

use glam::Vec3;
use rayon::prelude::*;

use super::columns::ScalarType;
use pellucid_core::color::{decode_srgb, linear_values};
use pellucid_core::parallel;

/// Floats up to this limit are meant to be at most 1; the excess is rounding.
const UNIT: f32 = 1.0 + 1e-3;

/// A color or alpha channel.
#[derive(Debug)]
pub(super) struct Channel {
    /// Index of the column in a row.
    pub at: usize,
    scale: Scale,
}

#[derive(Debug, Clone, Copy)]
enum Scale {
    /// Integers up to this are 0–1. Signed bytes are bytes that someone declared wrongly.
    Integer {
        largest: u16,
        signed_byte: bool,
        /// Linear values of all of them.
        linear: &'static [f32],
    },
    Float,
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

    /// Returns the channel of numbers at a place of the row whose range is that of all of them.
    pub fn of_any_range(at: usize) -> Self {
        Self { at, scale: Scale::Measured }
    }

    /// Returns `true` if the range is that of all values, which are stored until it is known.
    pub fn is_measured(&self) -> bool {
        matches!(self.scale, Scale::Measured)
    }

    /// Returns the channel at a place of the row, by the type that it is stored as.
    pub fn new(at: usize, scalar: &ScalarType) -> Self {
        let scale = match scalar {
            ScalarType::Float | ScalarType::Double => Scale::Float,
            integer => {
                let largest = if *integer == ScalarType::UShort { u16::MAX } else { 255 };
                let (signed_byte, linear) = (*integer == ScalarType::Char, linear_values(largest));
                Scale::Integer { largest, signed_byte, linear }
            }
        };
        Self { at, scale }
    }

    /// The stored integer, clamped to its range.
    #[inline]
    fn integer(value: f64, largest: u16, signed_byte: bool) -> u16 {
        let value = if signed_byte && value < 0.0 { value + 256.0 } else { value };
        // The conversion saturates, and turns NaN into 0.
        (value as u16).min(largest)
    }

    /// Returns the linear value of an sRGB-encoded channel, or what is stored if its range is not known yet.
    #[inline]
    pub fn linear(&self, value: f64) -> f32 {
        match self.scale {
            Scale::Integer { largest, signed_byte, linear } => {
                linear[usize::from(Self::integer(value, largest, signed_byte))]
            }
            Scale::Float => decode_srgb(unit_or(0.0, value as f32)),
            Scale::Linear => unit_or(0.0, value as f32),
            Scale::Measured => value as f32,
        }
    }

    /// Returns the value clamped to [0, 1]; NaN counts as 1. One whose range is not known yet stays as it is.
    #[inline]
    pub fn unit(&self, value: f64) -> f32 {
        match self.scale {
            Scale::Integer { largest, signed_byte, .. } => {
                f32::from(Self::integer(value, largest, signed_byte)) / f32::from(largest)
            }
            Scale::Float | Scale::Linear => unit_or(1.0, value as f32),
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
/// larger, else 255, else 65535. `None` if no value is above 0.
pub(super) fn full_scale(largest: Option<f32>) -> Option<f32> {
    Some(match largest.filter(|&largest| largest > 0.0)? {
        largest if largest <= UNIT => 1.0,
        largest if largest <= 255.0 => 255.0,
        _ => 65535.0,
    })
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
        let shorts = decoded_all(&[[256.0, 0.0, 0.0], [f32::INFINITY, f32::NAN, 0.0], [f32::NAN; 3]]).unwrap();
        assert_eq!(shorts, [Vec3::new(decoded(256.0, 65535.0), 0.0, 0.0), Vec3::X, Vec3::ONE]);
    }
}
