//! PNG, JPEG and TIFF as the samples that they store.
//!
//! A [`Decoder`] reads the header first, so that callers can compare its claims with the file's length before
//! [`Decoder::read`] takes memory for the pixels.

mod jpeg;
mod orientation;
mod png;
mod tiff;

use std::io::{self, BufRead, Seek};

pub(crate) use orientation::Orientation;
pub(crate) use png::Decoder as PngDecoder;

/// Signatures of the formats.
const PNG: &[u8] = b"\x89PNG";
const JPEG: &[u8] = &[0xff, 0xd8, 0xff];
const TIFF: [&[u8]; 2] = [b"II*\0", b"MM\0*"];

/// Returns `true` if a file that starts with these bytes claims to be in one of the formats.
pub(crate) fn is_bitmap(start: &[u8]) -> bool {
    [PNG, JPEG].iter().chain(&TIFF).any(|signature| start.starts_with(signature))
}

/// Reason why a file could not be decoded.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The system failed, or the file ended too early.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// The bytes break the format's rules, or use what its decoder does not know.
    #[error("{0}")]
    Malformed(String),
}

/// Decoded pixels, row by row from the top as the file stores them.
pub(crate) struct Bitmap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples of a pixel: 1 (gray), 2 (gray, alpha), 3 (red, green, blue) or 4 (red, green, blue, alpha).
    pub channels: usize,
    /// Samples of all pixels: width × height × channels of them.
    pub samples: Samples,
}

/// Stored numbers.
pub(crate) enum Samples {
    /// 0 to 255, sRGB-encoded except alpha.
    U8(Vec<u8>),
    /// 0 to 65535, sRGB-encoded except alpha.
    U16(Vec<u16>),
    /// Linear; any number, NaN too.
    F32(Vec<f32>),
}

impl Bitmap {
    /// Returns `true` if pixels have an alpha.
    pub fn has_alpha(&self) -> bool {
        self.channels.is_multiple_of(2)
    }
}

/// Red, green, blue and alpha of a pixel; `opaque` where it has no alpha.
pub(crate) fn rgba<T: Copy>(samples: &[T], channels: usize, pixel: usize, opaque: T) -> [T; 4] {
    let pixel = &samples[pixel * channels..][..channels];
    let alpha = if channels.is_multiple_of(2) { pixel[channels - 1] } else { opaque };
    let [red, green, blue] = if channels < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
    [red, green, blue, alpha]
}

/// A file whose header was read.
pub(crate) enum Decoder<R: BufRead + Seek> {
    Png(Box<png::Decoder<R>>),
    Jpeg(jpeg::Decoder),
    Tiff(Box<tiff::Decoder<R>>),
}

impl<R: BufRead + Seek> Decoder<R> {
    /// Reads the header of a file whose first bytes name its format.
    pub fn new(mut reader: R) -> Result<Self, Error> {
        let start = reader.fill_buf()?;
        if start.starts_with(PNG) {
            png::Decoder::new(reader).map(|decoder| Self::Png(Box::new(decoder)))
        } else if start.starts_with(JPEG) {
            jpeg::Decoder::new(reader).map(Self::Jpeg)
        } else {
            tiff::Decoder::new(reader).map(|decoder| Self::Tiff(Box::new(decoder)))
        }
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        match self {
            Self::Png(decoder) => decoder.size(),
            Self::Jpeg(decoder) => decoder.size(),
            Self::Tiff(decoder) => decoder.size(),
        }
    }

    /// Returns the number of bytes of the decoded pixels.
    pub fn bytes(&self) -> u64 {
        let (width, height) = self.size();
        let pixel = match self {
            Self::Png(decoder) => decoder.bytes_per_pixel(),
            Self::Jpeg(decoder) => decoder.bytes_per_pixel(),
            Self::Tiff(decoder) => decoder.bytes_per_pixel(),
        };
        (u64::from(width) * u64::from(height)).saturating_mul(pixel)
    }

    /// Returns the orientation by which the stored pixels have to be turned.
    pub fn orientation(&mut self) -> Result<Orientation, Error> {
        match self {
            Self::Png(decoder) => Ok(decoder.orientation()),
            Self::Jpeg(decoder) => Ok(decoder.orientation()),
            Self::Tiff(decoder) => decoder.orientation(),
        }
    }

    /// Decodes the pixels. `memory`: bytes that they and what the decoder retains in addition may take.
    pub fn read(self, memory: u64) -> Result<Bitmap, Error> {
        match self {
            Self::Png(decoder) => decoder.read(),
            Self::Jpeg(decoder) => decoder.read(),
            Self::Tiff(decoder) => decoder.read(memory),
        }
    }
}
