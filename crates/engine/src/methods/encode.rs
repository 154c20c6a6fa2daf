//! Images as the bytes that a window shows or a PNG has, found where the colors are: on the device.

use std::sync::Arc;

use glam::Vec3;

use crate::color::{decode_srgb, encode_srgb};
use crate::gpu::Error;
use crate::image::HARDLY;
use crate::methods::prelude::*;
use crate::output::{background, to_byte};
use crate::scene::ColorSpace;
use pellucid_core::parallel;

gpu_struct! {
    /// Push constants of `image/encode`.
    pub struct EncodePush {
        count: u32, // Pixels of the rows.
        first_row: u32, // Their first row in the picture.
        width: u32, // Columns and rows of the picture.
        height: u32,
        image_width: u32, // Columns and rows of the image.
        image_height: u32,
        scale: f32,
        background_r: f32, // Of the space that the image's colors have.
        background_g: f32,
        background_b: f32,
        encoded: u32, // 1 if the image's colors are encoded.
        blue_first: u32, // 1 if blue comes first in memory.
        covers: u32, // 1 if the last byte is the pixel's cover, and not 255.
        faint: f32, // A below which cover is faint.
        opaque: f32, // A above which it is full.
    }
}

pass! {
    /// Puts pixels of an image over a background and encodes them as bytes, those of the PNG: for a window that shows
    /// them, where coarser drafts are enlarged, and for a PNG, beside each pixel's cover.
    pub EncodePixels(EncodePush) = "image/encode" in "image/encode" {
        image: Read<[f32; 4]>,
        steps: Read<f32>,
        bytes: ReadWrite<u32>,
    }
}

/// Returns the values of a color space at which each byte begins: the least float32 that [`to_byte`] makes this byte of
/// once it is encoded. Nothing reaches the last one.
pub fn byte_steps(color: ColorSpace) -> [f32; 257] {
    let byte = |value: f32| match color {
        ColorSpace::Linear => to_byte(encode_srgb(value)),
        ColorSpace::Encoded => to_byte(value),
    };
    let mut steps = [f32::INFINITY; 257];
    steps[0] = 0.0;
    for (step, least) in (0u8..=255).zip(&mut steps).skip(1) {
        let encoded = (f32::from(step) - 0.5) / 255.0;
        let guess = if color == ColorSpace::Linear { decode_srgb(encoded) } else { encoded };
        // Positive floats are in the order of their bits.
        let mut bits = guess.to_bits();
        while byte(f32::from_bits(bits)) >= step {
            bits -= 1;
        }
        while byte(f32::from_bits(bits)) < step {
            bits += 1;
        }
        *least = f32::from_bits(bits);
    }
    steps
}

/// Way in which a window shows an image.
#[derive(Debug, Clone, Copy)]
pub struct Showing {
    /// Columns and rows of the image.
    pub image: [u32; 2],
    /// Columns and rows of the picture.
    pub picture: [u32; 2],
    /// The background, linear.
    pub background: Vec3,
    /// The space of its colors.
    pub color: ColorSpace,
    /// `true` if the window wants B, G, R, A in memory, and not R, G, B, A.
    pub blue_first: bool,
}

impl Showing {
    /// Returns what the pass needs to know, for some rows from the first on.
    fn push(&self, [first_row, rows]: [u32; 2]) -> EncodePush {
        let ([image_width, image_height], [width, height]) = (self.image, self.picture);
        let background = background(self.background, self.color);
        EncodePush {
            count: rows * width,
            first_row,
            width,
            height,
            image_width,
            image_height,
            scale: (f64::from(image_height) / f64::from(height)) as f32,
            background_r: background.x,
            background_g: background.y,
            background_b: background.z,
            encoded: u32::from(self.color == ColorSpace::Encoded),
            blue_first: u32::from(self.blue_first),
            covers: 0,
            faint: HARDLY,
            opaque: 1.0 - HARDLY,
        }
    }
}

/// The steps of bytes on a device.
struct Steps([Buffer<f32>; 2]);

impl Steps {
    fn new(device: &Device) -> Result<Self, Error> {
        let steps_of = |color| -> Result<_, Error> {
            let steps = byte_steps(color);
            // Written in place: until the first picture no submission can fail.
            let mut buffer = device.buffer("steps of bytes", steps.len() as u64, Memory::Upload)?;
            buffer.write(&steps);
            Ok(buffer)
        };
        Ok(Self([steps_of(ColorSpace::Linear)?, steps_of(ColorSpace::Encoded)?]))
    }

    /// Returns those of a color space.
    fn of(&self, color: ColorSpace) -> Slice<'_, f32> {
        self.0[usize::from(color == ColorSpace::Encoded)].all()
    }
}

/// Encodes the pixels of windows as they come to the host: R, G, B of an opaque PNG and the pixel's
/// [`Cover`](crate::image::Cover).
pub(super) struct PixelEncoder {
    steps: Steps,
    /// The background, linear.
    background: Vec3,
    color: ColorSpace,
}

impl PixelEncoder {
    /// Creates an encoder of pixels with black behind them.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self { steps: Steps::new(device)?, background: Vec3::ZERO, color: ColorSpace::Linear })
    }

    /// Takes the background and the color space of a frame.
    pub fn follow(&mut self, frame: &Frame) {
        (self.background, self.color) = (frame.background, frame.color);
    }

    /// Records the encoding of all pixels of an image.
    pub fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        image: Slice<'a, [f32; 4]>,
        bytes: Slice<'a, u32>,
    ) -> Result<(), Error> {
        // As one row: pixels have no neighbors here.
        let row = [image.len() as u32, 1];
        let of_window =
            Showing { image: row, picture: row, background: self.background, color: self.color, blue_first: false };
        let push = EncodePush { covers: 1, ..of_window.push([0, 1]) };
        let (steps, count) = (self.steps.of(self.color), image.len());
        recorder.run(&EncodePixels { image, steps, bytes }, push, &Run::new(Dispatch::Invocations(count)))
    }
}

/// Encodes images into buffers, each of which is used again when nobody else holds it.
pub struct Encoder {
    device: Device,
    steps: Steps,
    buffers: Vec<Arc<Buffer<u32>>>,
}

impl Encoder {
    /// Creates the encoder of images on a device.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn new(device: &Device) -> Result<Self, Error> {
        Ok(Self { device: device.clone(), steps: Steps::new(device)?, buffers: Vec::new() })
    }

    /// Returns the bytes of an image on the device, 4 a pixel of the picture, row by row.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn encode(&mut self, image: Slice<'_, [f32; 4]>, how: &Showing) -> Result<Arc<Buffer<u32>>, Error> {
        let shown = self.unused(how.picture)?;
        let [width, height] = how.picture;
        let steps = self.steps.of(how.color);
        let mut recorder = self.device.recorder()?;
        let rows = rows_of_binding(width, self.device.limits().binding_bytes);
        for first_row in (0..height).step_by(rows as usize) {
            let rows = rows.min(height - first_row);
            let count = u64::from(rows) * u64::from(width);
            let bytes = shown.slice(u64::from(first_row) * u64::from(width), count);
            let push = how.push([first_row, rows]);
            recorder.run(&EncodePixels { image, steps, bytes }, push, &Run::new(Dispatch::Invocations(count)))?;
        }
        recorder.submit("image/encode")?;
        Ok(shown)
    }

    /// Returns the same of R, G, B, A bytes on the host, of a picture with so many columns and rows.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn upload(&mut self, rgba: &[u8], size: [u32; 2], blue_first: bool) -> Result<Arc<Buffer<u32>>, Error> {
        let shown = self.unused(size)?;
        let word = |i: usize| {
            let [r, g, b, a] = std::array::from_fn(|channel| rgba[4 * i + channel]);
            u32::from_le_bytes(if blue_first { [b, g, r, a] } else { [r, g, b, a] })
        };
        let fill = |range: Range<usize>, to: &mut [u32]| {
            parallel::for_each_mut(to, |i, to| *to = word(range.start + i));
        };
        shown.upload_by(shown.len(), fill)?;
        Ok(shown)
    }

    /// A buffer for a picture of this size that nobody else holds.
    fn unused(&mut self, [width, height]: [u32; 2]) -> Result<Arc<Buffer<u32>>, Error> {
        let pixels = u64::from(width) * u64::from(height);
        // Those of other sizes go as soon as the window shows another picture.
        self.buffers.retain_mut(|buffer| buffer.len() == pixels || Arc::get_mut(buffer).is_none());
        if let Some(unused) =
            self.buffers.iter_mut().find_map(|buffer| Arc::get_mut(buffer).is_some().then_some(buffer))
        {
            return Ok(unused.clone());
        }
        let buffer = Arc::new(self.device.buffer("picture of the window", pixels, Memory::Device)?);
        self.buffers.push(buffer.clone());
        Ok(buffer)
    }
}

/// Rows of a picture that a binding holds, such that each part but the last ends where another binding may begin.
fn rows_of_binding(width: u32, binding_bytes: u64) -> u32 {
    let rows = binding_bytes / 4 / u64::from(width.max(1));
    u32::try_from(rows / 64 * 64).unwrap_or(u32::MAX).max(64)
}

/// Returns the pass.
pub(crate) fn shaders() -> Vec<Shader> {
    vec![Shader::plain::<EncodePixels>()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_where_bytes_begin() {
        for color in [ColorSpace::Linear, ColorSpace::Encoded] {
            let steps = byte_steps(color);
            assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{color:?}");
            for (byte, step) in (0u8..=255).zip(steps).skip(1) {
                let before = f32::from_bits(step.to_bits() - 1);
                let encoded = [before, step].map(|v| if color == ColorSpace::Linear { encode_srgb(v) } else { v });
                assert_eq!(encoded.map(to_byte), [byte - 1, byte], "{color:?}");
            }
        }
    }

    #[test]
    fn parts_begin_where_bindings_may() {
        for (width, bytes) in [(1, 1 << 27), (16_384, 1 << 27), (1919, 1 << 30), (16_384, 1 << 22)] {
            let rows = rows_of_binding(width, bytes);
            assert!(
                rows.is_multiple_of(64) && u64::from(rows) * u64::from(width) * 4 <= bytes.max(1 << 22),
                "{width} {rows}"
            );
        }
    }
}
