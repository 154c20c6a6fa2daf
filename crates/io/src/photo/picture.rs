//! PNG, JPEG and TIFF as pixels. A header's claims are compared with the file's length before memory is allocated.

use std::io::{BufRead, ErrorKind};

use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::{InputFile, MAX_PIXELS, directory};
use crate::bitmap::{self, Sample};
use crate::channel::unit_or;
use crate::{Error, decoder};
use pellucid_core::color::linear_values;

/// Bytes that one byte of a file may become: Deflate, the strongest of the codings in use, makes at most 1032.
const LARGEST_RATIO: u64 = 1100;

/// Bytes of pixels that any file may hold, so that the rule above does not meet tiny flat pictures.
const ALWAYS_ALLOWED: u64 = 16 << 20;

/// Bytes of pixels that any JPEG may hold, fewer than other files, since its decoder makes up what is missing: a header
/// alone would become a picture. Two bits for a block of 64 samples, or one in a progressive file, are a ratio of at
/// most 1024.
const ALWAYS_ALLOWED_JPEG: u64 = 1 << 20;

/// A decoded picture, rotated upright (EXIF).
pub struct Picture {
    /// Width in pixels, when upright.
    pub width: u32,
    /// Height in pixels, when upright.
    pub height: u32,
    /// `true` if it has an alpha channel.
    pub has_alpha: bool,
    upright: DynamicImage,
}

impl Picture {
    /// Decodes a whole file. A panic of the decoder is the file's fault.
    pub fn read(mut source: InputFile) -> Result<Self, Error> {
        directory::check(&mut source)?;
        let path = source.path.clone();
        decoder::guard(|| Self::decode(source)).unwrap_or_else(|panic| {
            Err(Error::malformed(&path, "the picture", format!("the decoder gave up: {panic}")))
        })
    }

    fn decode(mut source: InputFile) -> Result<Self, Error> {
        let (path, len) = (source.path.clone(), source.len);
        let malformed = |place: &str, cause: String| Error::malformed(&path, place, cause);
        let failed = |error: ImageError| match error {
            ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
                Error::Truncated { path: path.clone(), what: format!("the pixels continue past the last byte, {len}") }
            }
            error => malformed("the picture", bitmap::reason(&error)),
        };
        let start = source.reader.fill_buf().map_err(|error| failed(error.into()))?;
        // Files without a known signature, which height maps may be, are the TIFF decoder's to refuse.
        let format = bitmap::format(start).unwrap_or(ImageFormat::Tiff);
        let mut reader = ImageReader::with_format(source.reader, format);
        reader.limits(bitmap::limits(len));
        let mut decoder = reader.into_decoder().map_err(failed)?;
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(malformed("the header", format!("{width} × {height} pixels, so the picture is empty")));
        }
        if pixels > MAX_PIXELS {
            let cause =
                format!("{width} × {height} pixels, but at most {MAX_PIXELS} are supported; scale the picture down");
            return Err(malformed("the header", cause));
        }
        let bytes = decoder.total_bytes();
        let allowed = if format == ImageFormat::Jpeg { ALWAYS_ALLOWED_JPEG } else { ALWAYS_ALLOWED };
        if bytes > allowed && bytes / LARGEST_RATIO > len {
            let what = format!("{width} × {height} pixels of {bytes} bytes don't fit in a file of {len} bytes");
            return Err(Error::Truncated { path: path.clone(), what });
        }
        let orientation = decoder.orientation().map_err(failed)?;
        // The picture, and what its decoder keeps beside it.
        let mut limits = bitmap::limits(len);
        limits.max_alloc = Some(2 * bytes + (64 << 20));
        decoder.set_limits(limits).map_err(failed)?;
        let mut upright = DynamicImage::from_decoder(decoder).map_err(failed)?;
        upright.apply_orientation(orientation);
        let (width, height) = (upright.width(), upright.height());
        Ok(Self { width, height, has_alpha: upright.color().has_alpha(), upright })
    }

    /// Returns the linear color and alpha of a pixel; column from the left, row from the top.
    pub fn pixel(&self, x: u32, y: u32) -> (Vec3, f32) {
        match Sample::of(&self.upright, x, y) {
            Sample::Encoded([r, g, b, a]) => {
                let linear = linear_values(u16::MAX);
                (Vec3::from([r, g, b].map(|value| linear[usize::from(value)])), f32::from(a) / f32::from(u16::MAX))
            }
            Sample::Linear(sample) => {
                let [r, g, b, a] = sample.map(|value| unit_or(0.0, value));
                (Vec3::new(r, g, b), a)
            }
        }
    }

    /// Returns the stored values as numbers in [0, 1], row by row from the top; of colored pictures the mean of R, G
    /// and B.
    pub fn gray(&self) -> Vec<f32> {
        fn mean(r: f64, g: f64, b: f64) -> f32 {
            ((r + g + b) / 3.0) as f32
        }
        let gray = |x: u32, y: u32| match Sample::of(&self.upright, x, y) {
            Sample::Encoded([r, g, b, _]) => mean(r.into(), g.into(), b.into()) / f32::from(u16::MAX),
            Sample::Linear([r, g, b, _]) => {
                let [r, g, b] = [r, g, b].map(|value| unit_or(0.0, value).into());
                mean(r, g, b)
            }
        };
        (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y))).map(|(x, y)| gray(x, y)).collect()
    }
}
