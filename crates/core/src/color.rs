//! sRGB encoding and decoding (IEC 61966-2-1), colors by name, and colors that stand for values.

pub mod classes;
pub mod colormap;
pub mod percentiles;
pub mod scale;
pub mod ticks;

use std::sync::OnceLock;

use glam::Vec3;

/// The space in which blending runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum ColorSpace {
    /// Linear light.
    #[default]
    Linear,
    /// The stored sRGB values as they are.
    Encoded,
}

/// Returns the linear value of an sRGB-encoded one. Values outside [0, 1] follow the same curve.
pub fn decode_srgb(encoded: f32) -> f32 {
    decode_srgb_f64(f64::from(encoded)) as f32
}

/// Numbers of full intensity in integers of 8, 10, 12 and 16 bits.
pub const FULL_INTEGERS: [u16; 4] = [255, 1023, 4095, u16::MAX];

/// Returns the linear values of all sRGB-encoded integers from 0 to `full`, which is one of [`FULL_INTEGERS`].
pub fn linear_values(full: u16) -> &'static [f32] {
    static VALUES: [OnceLock<Vec<f32>>; FULL_INTEGERS.len()] = [const { OnceLock::new() }; FULL_INTEGERS.len()];
    let linear = |encoded: u16| decode_srgb(f32::from(encoded) / f32::from(full));
    let at = FULL_INTEGERS.partition_point(|known| *known < full);
    VALUES[at].get_or_init(|| (0..=full).map(linear).collect())
}

/// sRGB-encoded value of a linear one. Negative values stay on the linear part.
pub fn encode_srgb(linear: f32) -> f32 {
    encode_srgb_f64(f64::from(linear)) as f32
}

/// [`decode_srgb`] in float64.
pub fn decode_srgb_f64(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// [`encode_srgb`] in float64.
pub fn encode_srgb_f64(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Returns linear R, G, B of a color that CSS has a word or a form for ("white", "#80c0ff", "hsl(120 50% 50%)"); `None`
/// for others, and for colors that one can see through.
pub fn named(text: &str) -> Option<Vec3> {
    let color = csscolorparser::parse(text).ok().filter(|color| color.a == 1.0)?;
    let [r, g, b] = [color.r, color.g, color.b].map(|value| decode_srgb(value.clamp(0.0, 1.0)));
    Some(Vec3::new(r, g, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        assert_eq!(named("white"), Some(Vec3::ONE));
        assert_eq!(named("Black"), Some(Vec3::ZERO));
        assert_eq!(named("#ff0080"), Some(Vec3::new(1.0, 0.0, decode_srgb(128.0 / 255.0))));
        for wrong in ["whit", "", "1,2,3", "#12345", "transparent", "#ff000080"] {
            assert_eq!(named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn the_two_are_inverse_on_every_8_bit_value() {
        for byte in 0..=255u16 {
            let encoded = f32::from(byte) / 255.0;
            let back = encode_srgb(decode_srgb(encoded));
            // Two roundings to float32 of values of at most 1, amplified by the slope 12.92 near black.
            assert!((back - encoded).abs() < 13.0 * f32::EPSILON, "{byte}: {back} != {encoded}");
        }
    }

    #[test]
    fn known_values() {
        assert!((decode_srgb(0.5) - 0.214_041_14).abs() < 1e-7);
        assert!((encode_srgb(0.5) - 0.735_357).abs() < 1e-7);
    }
}
