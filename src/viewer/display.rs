//! From an image to the bytes on the screen: those that its PNG has.

use glam::Vec3;
use rayon::prelude::*;

use crate::color::{decode_srgb, encode_srgb};
use crate::image::Image;
use crate::output::to_byte;
use crate::scene::ColorSpace;

/// Cells of the table that says where to begin.
const CELLS: usize = 4096;

/// sRGB bytes of linear values.
///
/// A byte is the number of steps below a value, so that 255 comparisons with the least value of each would do; a table leaves
/// one or two of them.
pub struct Display {
    /// The least value that becomes this byte.
    steps: [f32; 256],
    /// The byte at each cell's beginning.
    begin: Vec<u8>,
}

impl Display {
    pub fn new() -> Self {
        let byte = |value: f32| to_byte(encode_srgb(value));
        let mut steps = [0.0f32; 256];
        for (step, least) in (0u8..=255).zip(&mut steps).skip(1) {
            // Positive floats are in the order of their bits.
            let guess = decode_srgb((f32::from(step) - 0.5) / 255.0);
            let mut bits = guess.to_bits();
            while byte(f32::from_bits(bits)) >= step {
                bits -= 1;
            }
            while byte(f32::from_bits(bits)) < step {
                bits += 1;
            }
            *least = f32::from_bits(bits);
        }
        let begin = (0..=CELLS).map(|cell| byte(cell as f32 / CELLS as f32)).collect();
        Self { steps, begin }
    }

    /// The byte of a linear value; NaN is 0.
    fn byte(&self, value: f32) -> u8 {
        // The cast of NaN is 0.
        let value = value.clamp(0.0, 1.0);
        let mut byte = self.begin[(value * CELLS as f32) as usize];
        while byte < u8::MAX && value >= self.steps[usize::from(byte) + 1] {
            byte += 1;
        }
        byte
    }

    /// R, G, B and 255 of each pixel of an image over a background (linear, as the scene gives it).
    pub fn bytes(&self, image: &Image, background: Vec3, color: ColorSpace) -> Vec<u8> {
        let background = crate::output::background(background, color);
        let mut bytes = vec![u8::MAX; 4 * image.rgba.len()];
        bytes.par_chunks_exact_mut(4).zip(&image.rgba).for_each(|(pixel, rgba)| {
            let composed = Image::over(*rgba, background);
            for (byte, value) in pixel.iter_mut().zip(composed) {
                *byte = match color {
                    ColorSpace::Linear => self.byte(value),
                    ColorSpace::Encoded => to_byte(value),
                };
            }
        });
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn every_byte_is_that_of_the_png() {
        let display = Display::new();
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        let near =
            |value: f32| (-3..=3).map(move |ulps: i32| f32::from_bits(value.to_bits().wrapping_add_signed(ulps)));
        let steps = display.steps[1..].iter().copied().flat_map(near);
        let cells = (1..=CELLS).map(|cell| cell as f32 / CELLS as f32).flat_map(near);
        let odd = [0.0, -0.0, -1.0, 1.0, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE];
        let chance = (0..200_000).map(|_| random.random_range(-0.1..1.1f32).powi(3));
        for value in steps.chain(cells).chain(odd).chain(chance) {
            assert_eq!(display.byte(value), to_byte(encode_srgb(value)), "{value}");
        }
    }
}
