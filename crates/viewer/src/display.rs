//! Converts an image on the host to the bytes on the screen, which equal those of its PNG. Images whose colors are on
//! the device are encoded there ([`pellucid_engine::methods::encode`]).

use std::sync::{Arc, LazyLock};

use glam::Vec3;
use rayon::prelude::*;

use pellucid_core::image::Image;
use pellucid_core::parallel;
use pellucid_engine::Result;
use pellucid_engine::methods::encode::{Encoder, Showing, byte_steps};
use pellucid_gpu::{Buffer, Device, Slice};
use pellucid_io::output::to_byte;
use pellucid_scene::{ColorSpace, Scene};

/// The linear values at which each byte begins, and one that nothing reaches.
static STEPS: LazyLock<[f32; 257]> = LazyLock::new(|| byte_steps(ColorSpace::Linear));

/// The sRGB byte of a linear value: the number of steps that it reaches; NaN is 0.
fn srgb_byte(value: f32) -> u8 {
    STEPS[1..256].partition_point(|step| *step <= value) as u8
}

/// R, G, B and 255 of each composed pixel, whose values are those of a color space.
pub fn bytes(pixels: &[[f32; 3]], color: ColorSpace) -> Vec<u8> {
    let mut bytes = vec![u8::MAX; 4 * pixels.len()];
    bytes.par_chunks_exact_mut(4).zip(pixels).for_each(|(pixel, composed)| {
        for (byte, value) in pixel.iter_mut().zip(composed) {
            *byte = match color {
                ColorSpace::Linear => srgb_byte(*value),
                ColorSpace::Encoded => to_byte(*value),
            };
        }
    });
    bytes
}

/// An image of a scene, which may have fewer pixels than the scene says.
#[derive(Clone, Copy)]
pub struct SceneImage<'a> {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The scene.
    pub scene: &'a Scene,
}

impl SceneImage<'_> {
    /// True if it has fewer pixels.
    pub fn is_coarse(&self) -> bool {
        self.size != self.scene.image.size
    }

    /// Composes pixels over the background, as many as the scene says, row by row: values of the color space in force.
    pub fn composed(&self, rgba: &[[f32; 4]]) -> Vec<[f32; 3]> {
        let image = &self.scene.image;
        let background = pellucid_io::output::background(image.background.color(), image.color_space());
        let pixels = parallel::map_each(rgba, |rgba| Image::over(*rgba, background));
        if self.is_coarse() { enlarge(&pixels, self.size, image.size) } else { pixels }
    }
}

/// Encodes pictures for display, on the GPU if the colors are resident there.
pub struct ScreenEncoder {
    encoder: Encoder,
    /// True if the screen has blue first in memory.
    blue_first: bool,
}

impl ScreenEncoder {
    /// Makes an encoder for a screen of a device.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn new(device: &Device, blue_first: bool) -> Result<Self> {
        Ok(Self { encoder: Encoder::new(device)?, blue_first })
    }

    /// The bytes of an image whose colors are on the device.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn encode(&mut self, colors: Slice<'_, [f32; 4]>, image: SceneImage<'_>) -> Result<Arc<Buffer<u32>>> {
        let Scene { image: wanted, .. } = image.scene;
        let showing = Showing {
            image: image.size,
            picture: wanted.size,
            background: wanted.background.color(),
            color: wanted.color_space(),
            blue_first: self.blue_first,
        };
        Ok(self.encoder.encode(colors, &showing)?)
    }

    /// The bytes of composed pixels.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn upload(&mut self, composed: &[[f32; 3]], scene: &Scene) -> Result<Arc<Buffer<u32>>> {
        let rgba = bytes(composed, scene.image.color_space());
        Ok(self.encoder.upload(&rgba, scene.image.size, self.blue_first)?)
    }
}

/// Maps pixels of the screen to those of a coarser picture with the same camera. The centers of both coincide, and a
/// row of the screen is `from[1] / to[1]` rows of the picture.
#[derive(Debug, Clone, Copy)]
struct Scaling {
    from: [usize; 2],
    to: [usize; 2],
}

impl Scaling {
    /// The position of a pixel center, in pixels from the center of the first one.
    fn place(&self, axis: usize, at: usize) -> f64 {
        let scale = self.from[1] as f64 / self.to[1] as f64;
        (at as f64 + 0.5 - 0.5 * self.to[axis] as f64) * scale + 0.5 * self.from[axis] as f64 - 0.5
    }

    /// The two pixels on either side of this position, and the weight of the second one.
    fn between(&self, axis: usize, at: usize) -> (usize, usize, f32) {
        let last = self.from[axis].saturating_sub(1);
        let place = self.place(axis, at).clamp(0.0, last as f64);
        let first = place as usize;
        (first, (first + 1).min(last), (place - first as f64) as f32)
    }

    /// The pixel that holds this place.
    fn nearest(&self, axis: usize, at: usize) -> usize {
        let last = self.from[axis].saturating_sub(1);
        self.place(axis, at).round().clamp(0.0, last as f64) as usize
    }
}

/// Enlarges a coarser picture to the size of the screen by bilinear interpolation. Sizes are columns and rows.
fn enlarge(pixels: &[[f32; 3]], from: [u32; 2], to: [u32; 2]) -> Vec<[f32; 3]> {
    let scaling = Scaling { from: from.map(|n| n as usize), to: to.map(|n| n as usize) };
    let width = scaling.to[0];
    let columns: Vec<_> = (0..width).map(|x| scaling.between(0, x)).collect();
    let mut out = vec![[0.0; 3]; width * scaling.to[1]];
    out.par_chunks_exact_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        let (above, below, down) = scaling.between(1, y);
        let row_of = |y: usize| &pixels[y * scaling.from[0]..(y + 1) * scaling.from[0]];
        let (above, below) = (row_of(above), row_of(below));
        for (pixel, (left, right, along)) in row.iter_mut().zip(&columns) {
            let mixed = |row: &[[f32; 3]]| Vec3::from(row[*left]).lerp(Vec3::from(row[*right]), *along);
            *pixel = mixed(above).lerp(mixed(below), down).to_array();
        }
    });
    out
}

/// Enlarges depths by taking the nearest pixel: no surface lies between a foreground depth and the background behind
/// it.
pub fn enlarge_depths(depths: &[f32], from: [u32; 2], to: [u32; 2]) -> Vec<f32> {
    let scaling = Scaling { from: from.map(|n| n as usize), to: to.map(|n| n as usize) };
    let columns: Vec<_> = (0..scaling.to[0]).map(|x| scaling.nearest(0, x)).collect();
    let row = |y| {
        let start = scaling.nearest(1, y) * scaling.from[0];
        columns.iter().map(move |x| depths[start + x])
    };
    (0..scaling.to[1]).flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::color::encode_srgb;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn every_byte_is_that_of_the_png() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(7);
        let near =
            |value: f32| (-3..=3).map(move |ulps: i32| f32::from_bits(value.to_bits().wrapping_add_signed(ulps)));
        let steps = STEPS[1..256].iter().copied().flat_map(near);
        let odd = [0.0, -0.0, -1.0, 1.0, 1.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE];
        let chance = (0..200_000).map(|_| random.random_range(-0.1..1.1f32).powi(3));
        for value in steps.chain(odd).chain(chance) {
            assert_eq!(srgb_byte(value), to_byte(encode_srgb(value)), "{value}");
        }
    }

    #[test]
    fn a_coarser_picture_lies_where_the_finer_one_would() {
        // A ramp is the same at any size except at the border, where no data lies beyond the last pixel.
        let ramp = |[w, h]: [u32; 2], step: f32| -> Vec<[f32; 3]> {
            let value = |i: u32, n: u32| (i as f32 + 0.5 - 0.5 * n as f32) * step;
            (0..w * h).map(|i| [value(i % w, w), value(i / w, h), 1.0]).collect()
        };
        // 9 rows become 17, a factor of 1.889, so that 31 columns span 16.41 of the 16.
        for (from, to) in [([15, 11], [30, 22]), ([16, 9], [31, 17]), ([8, 6], [8, 6]), ([6, 4], [41, 29])] {
            let step = to[1] as f32 / from[1] as f32;
            let (enlarged, fine) = (enlarge(&ramp(from, step), from, to), ramp(to, 1.0));
            let border = step.ceil() as u32;
            for (i, (a, b)) in enlarged.iter().zip(&fine).enumerate() {
                let (x, y) = (i as u32 % to[0], i as u32 / to[0]);
                let inside = x >= border && y >= border && x + border < to[0] && y + border < to[1];
                let near = (a[0] - b[0]).abs() < 1e-4 && (a[1] - b[1]).abs() < 1e-4;
                assert!((!inside || near) && a[2] == 1.0, "{from:?} {to:?} {x} {y}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn depths_are_those_of_pixels() {
        let depths = [1.0, f32::INFINITY, 3.0, 4.0];
        let large = enlarge_depths(&depths, [2, 2], [4, 4]);
        assert_eq!(large[..4], [1.0, 1.0, f32::INFINITY, f32::INFINITY]);
        assert_eq!(large[12..], [3.0, 3.0, 4.0, 4.0]);
        assert_eq!(enlarge_depths(&depths, [2, 2], [2, 2]), depths);
    }
}
