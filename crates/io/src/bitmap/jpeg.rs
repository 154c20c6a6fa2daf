//! JPEG: gray, or colors in whatever coding as red, green and blue of 8 bits.

use std::io::Read;

use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{Bitmap, Error, Orientation, Samples};

pub(crate) struct Decoder {
    file: Vec<u8>,
    width: u32,
    height: u32,
    colors: ColorSpace,
    orientation: Orientation,
}

impl Decoder {
    pub fn new(mut reader: impl Read) -> Result<Self, Error> {
        let mut file = Vec::new();
        reader.read_to_end(&mut file)?;
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&file), options());
        decoder.decode_headers()?;
        let incomplete = || Error::Malformed("JPEG: the header has no size".into());
        let (width, height) = decoder.dimensions().ok_or_else(incomplete)?;
        // A JPEG states both in 16 bits.
        let (width, height) = (width as u32, height as u32);
        let colors = match decoder.input_colorspace().ok_or_else(incomplete)? {
            known @ (ColorSpace::Luma | ColorSpace::LumaA | ColorSpace::RGB | ColorSpace::RGBA) => known,
            _ => ColorSpace::RGB,
        };
        let exif = decoder.exif().and_then(|exif| Orientation::from_exif(exif));
        let orientation = exif.unwrap_or_default();
        Ok(Self { width, height, colors, orientation, file })
    }

    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub fn bytes_per_pixel(&self) -> u64 {
        self.colors.num_components() as u64
    }

    pub fn orientation(&self) -> Orientation {
        self.orientation
    }

    pub fn read(self) -> Result<Bitmap, Error> {
        let channels = self.colors.num_components();
        let options = options().jpeg_set_out_colorspace(self.colors);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&self.file), options);
        // At most 2³² pixels of 4 bytes.
        let mut samples = vec![0; self.width as usize * self.height as usize * channels];
        decoder.decode_into(&mut samples)?;
        Ok(Bitmap { width: self.width, height: self.height, channels, samples: Samples::U8(samples) })
    }
}

/// Sizes are the caller's business, and what a camera wrote is read as far as it can be.
fn options() -> DecoderOptions {
    DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX)
}

impl From<DecodeErrors> for Error {
    fn from(error: DecodeErrors) -> Self {
        Self::Malformed(format!("JPEG: {error}"))
    }
}
