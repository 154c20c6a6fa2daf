//! PNG: gray or colored, with and without alpha, palettes resolved, 8 or 16 bits.

use std::io::{BufRead, Seek};

use png::{BitDepth, DecodingError, Limits, Reader, Transformations};

use super::{Bitmap, Error, Orientation, Samples};

/// Bytes that chunks other than the pixels may take.
const CHUNKS: usize = 512 << 20;

pub(crate) struct Decoder<R: BufRead + Seek>(Reader<R>);

impl<R: BufRead + Seek> Decoder<R> {
    pub fn new(reader: R) -> Result<Self, Error> {
        let mut decoder = png::Decoder::new_with_limits(reader, Limits { bytes: CHUNKS });
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        // Fewer bits than 8 become 8, palettes colors, transparent colors an alpha channel.
        decoder.set_transformations(Transformations::EXPAND);
        Ok(Self(decoder.read_info()?))
    }

    pub fn size(&self) -> (u32, u32) {
        self.0.info().size()
    }

    pub fn bytes_per_pixel(&self) -> u64 {
        let (color, depth) = self.0.output_color_type();
        color.samples() as u64 * if depth == BitDepth::Sixteen { 2 } else { 1 }
    }

    pub fn orientation(&self) -> Orientation {
        self.0.info().exif_metadata.as_deref().and_then(Orientation::from_exif).unwrap_or_default()
    }

    pub fn read(mut self) -> Result<Bitmap, Error> {
        let (width, height) = self.size();
        let (color, depth) = self.0.output_color_type();
        let bytes = self.0.output_buffer_size();
        let bytes = bytes.ok_or_else(|| Error::Malformed("the picture is larger than this machine's memory".into()))?;
        let samples = if depth == BitDepth::Sixteen {
            let mut samples = vec![0u16; bytes / 2];
            self.0.next_frame(bytemuck::cast_slice_mut(&mut samples))?;
            samples.iter_mut().for_each(|sample| *sample = u16::from_be(*sample));
            Samples::U16(samples)
        } else {
            let mut samples = vec![0u8; bytes];
            self.0.next_frame(&mut samples)?;
            Samples::U8(samples)
        };
        Ok(Bitmap { width, height, channels: color.samples(), samples })
    }
}

impl From<DecodingError> for Error {
    fn from(error: DecodingError) -> Self {
        match error {
            DecodingError::IoError(error) => Self::Read(error),
            error => Self::Malformed(format!("PNG: {error}")),
        }
    }
}
