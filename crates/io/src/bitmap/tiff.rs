//! TIFF: gray or colored, with and without alpha, also CMYK; 8 or 16 bits, or linear floats.

use std::io::{BufRead, Seek};

use tiff::decoder::{BufferLayoutPreference, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::{Bitmap, Error, Orientation, Samples};

pub(crate) struct Decoder<R: BufRead + Seek> {
    tiff: tiff::decoder::Decoder<R>,
    width: u32,
    height: u32,
    colors: ColorType,
}

impl<R: BufRead + Seek> Decoder<R> {
    pub fn new(reader: R) -> Result<Self, Error> {
        let mut tiff = tiff::decoder::Decoder::new(reader)?;
        let (width, height) = tiff.dimensions()?;
        let colors = tiff.colortype()?;
        let is_known = match colors {
            ColorType::Gray(bits) => matches!(bits, 1 | 8 | 16),
            ColorType::GrayA(bits) | ColorType::CMYK(bits) => matches!(bits, 8 | 16),
            ColorType::RGB(bits) | ColorType::RGBA(bits) => matches!(bits, 8 | 16 | 32),
            _ => false,
        };
        if !is_known {
            return Err(unknown(colors));
        }
        Ok(Self { tiff, width, height, colors })
    }

    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub fn bytes_per_pixel(&self) -> u64 {
        u64::from(self.colors.num_samples()) * u64::from(self.colors.bit_depth().div_ceil(8))
    }

    pub fn orientation(&mut self) -> Result<Orientation, Error> {
        let value = self.tiff.find_tag(Tag::Orientation)?;
        let value = value.and_then(|value| value.into_u16().ok());
        Ok(value.and_then(Orientation::from_number).unwrap_or_default())
    }

    pub fn read(self, memory: u64) -> Result<Bitmap, Error> {
        let Self { tiff, width, height, colors } = self;
        let pixels = (u64::from(width) * u64::from(height)).saturating_mul(u64::from(colors.num_samples()));
        let bytes = pixels.saturating_mul(u64::from(colors.bit_depth().div_ceil(8)));
        let size = |bytes: u64| usize::try_from(bytes).unwrap_or(usize::MAX);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = size(bytes);
        limits.intermediate_buffer_size = size(memory.saturating_sub(bytes));
        limits.ifd_value_size = limits.intermediate_buffer_size;
        let mut tiff = tiff.with_limits(limits);
        let mut samples = DecodingResult::U8(Vec::new());
        let layout = tiff.read_image_to_buffer(&mut samples)?;
        if samples.as_buffer(0).as_bytes().len() < layout.complete_len {
            return Err(Error::Malformed("TIFF: it announces more planes than it has pixels for".into()));
        }
        let stored = usize::from(colors.num_samples());
        let samples = match (samples, colors) {
            (DecodingResult::U8(rows), ColorType::Gray(1)) => Samples::U8(expanded(&rows, width as usize)),
            (DecodingResult::U8(samples), ColorType::CMYK(8)) => {
                Samples::U8(printed(&interleaved(samples, stored, &layout), 255.0, |light| light.round() as u8))
            }
            (DecodingResult::U16(samples), ColorType::CMYK(16)) => {
                Samples::U16(printed(&interleaved(samples, stored, &layout), 65535.0, |light| light.round() as u16))
            }
            (DecodingResult::U8(samples), _) => Samples::U8(interleaved(samples, stored, &layout)),
            (DecodingResult::U16(samples), _) => Samples::U16(interleaved(samples, stored, &layout)),
            (DecodingResult::F32(samples), _) => Samples::F32(interleaved(samples, stored, &layout)),
            _ => return Err(unknown(colors)),
        };
        let channels = if matches!(colors, ColorType::CMYK(_)) { 3 } else { stored };
        Ok(Bitmap { width, height, channels, samples })
    }
}

/// Pixels of samples that may lie in planes, one after the other.
fn interleaved<T: Copy + Default>(samples: Vec<T>, channels: usize, layout: &BufferLayoutPreference) -> Vec<T> {
    let stride = layout.plane_stride.map_or(0, |bytes| bytes.get() / size_of::<T>());
    if layout.planes <= 1 || stride == 0 {
        return samples;
    }
    let mut pixels = vec![T::default(); samples.len()];
    for (channel, plane) in samples.chunks_exact(stride).take(channels).enumerate() {
        pixels.iter_mut().skip(channel).step_by(channels).zip(plane).for_each(|(to, from)| *to = *from);
    }
    pixels
}

/// Bits as 0 and 255; each row starts with a byte.
fn expanded(rows: &[u8], width: usize) -> Vec<u8> {
    let bit = |row: &[u8], x: usize| if row[x / 8] << (x % 8) & 0x80 == 0 { 0 } else { 255 };
    rows.chunks_exact(width.div_ceil(8)).flat_map(|row| (0..width).map(move |x| bit(row, x))).collect()
}

/// Red, green and blue that are left of white behind cyan, magenta, yellow and black.
fn printed<T: Copy + Into<f32>>(inks: &[T], white: f32, stored: impl Fn(f32) -> T) -> Vec<T> {
    let light = |[c, m, y, k]: [T; 4]| {
        let through_black = 1.0 - k.into() / white;
        [c, m, y].map(|ink| stored((white - ink.into()) * through_black))
    };
    inks.as_chunks().0.iter().flat_map(|inks| light(*inks)).collect()
}

fn unknown(colors: ColorType) -> Error {
    Error::Malformed(format!("TIFF: pixels of this kind are not supported: {colors:?}"))
}

impl From<TiffError> for Error {
    fn from(error: TiffError) -> Self {
        match error {
            TiffError::IoError(error) => Self::Read(error),
            error => Self::Malformed(format!("TIFF: {error}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_become_bytes_and_rows_end_with_a_byte() {
        assert_eq!(expanded(&[0b1010_0000, 0b0111_1111], 3), [255, 0, 255, 0, 255, 255]);
        assert_eq!(expanded(&[0x80, 0x80], 9), [255, 0, 0, 0, 0, 0, 0, 0, 255]);
    }

    #[test]
    fn inks_take_light_away() {
        let bytes = [[0, 0, 0, 0], [255, 0, 51, 0]].concat();
        assert_eq!(printed(&bytes, 255.0, |light| light as u8), [255, 255, 255, 0, 255, 204]);
        assert_eq!(printed(&[0u16, 0, 0, 65535], 65535.0, |light| light as u16), [0, 0, 0]);
    }
}
