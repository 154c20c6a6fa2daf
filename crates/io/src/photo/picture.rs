//! PNG, JPEG and TIFF as pixels. A header's claims are compared with the file's length before memory is allocated.

use std::io::{BufRead, ErrorKind};
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};

use super::{InputFile, MAX_PIXELS, directory};
use crate::bitmap::{self, Sample};
use crate::channel::unit_or;
use crate::{Error, decoder, has_memory};
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
    /// Decodes a whole file.
    pub fn read(mut source: InputFile) -> Result<Self, Error> {
        directory::check(&mut source)?;
        let path = source.path.clone();
        guarded(&path, || Self::decode(source))
    }

    fn decode(source: InputFile) -> Result<Self, Error> {
        let failure = Failure { path: source.path.clone(), len: source.len };
        let len = source.len;
        let (mut decoder, format) = header(source)?;
        let (width, height) = decoder.dimensions();
        let bytes = decoder.total_bytes();
        let allowed = if format == ImageFormat::Jpeg { ALWAYS_ALLOWED_JPEG } else { ALWAYS_ALLOWED };
        if bytes > allowed && bytes / LARGEST_RATIO > len {
            let what = format!("{width} × {height} pixels of {bytes} bytes don't fit in a file of {len} bytes");
            return Err(Error::Truncated { path: failure.path, what });
        }
        // The picture, and what its decoder keeps beside it.
        let needed = bytes.saturating_mul(2).saturating_add(64 << 20);
        if !has_memory(needed) {
            let cause =
                format!("{width} × {height} pixels need {} of memory; scale the picture down", ByteSize(needed));
            return Err(Error::malformed(&failure.path, "the header", cause));
        }
        let failed = |error| failure.because(error);
        let orientation = decoder.orientation().map_err(failed)?;
        let mut limits = bitmap::limits(len);
        limits.max_alloc = Some(needed);
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

/// Returns the number of pixels that a file claims.
pub fn pixels(mut source: InputFile) -> Result<u64, Error> {
    directory::check(&mut source)?;
    let path = source.path.clone();
    guarded(&path, || header(source).map(|(decoder, _)| count(&decoder)))
}

/// A panic of the decoder is the file's fault.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    decoder::guard(read)
        .unwrap_or_else(|panic| Err(Error::malformed(path, "the picture", format!("the decoder gave up: {panic}"))))
}

/// Reads what stands before the pixels.
fn header(mut source: InputFile) -> Result<(impl ImageDecoder, ImageFormat), Error> {
    let failure = Failure { path: source.path.clone(), len: source.len };
    let failed = |error| failure.because(error);
    let start = source.reader.fill_buf().map_err(|error| failed(error.into()))?;
    // Files without a known signature, which height maps may be, are the TIFF decoder's to refuse.
    let format = bitmap::format(start).unwrap_or(ImageFormat::Tiff);
    let mut reader = ImageReader::with_format(source.reader, format);
    reader.limits(bitmap::limits(failure.len));
    let decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let cause = match count(&decoder) {
        0 => format!("{width} × {height} pixels, so the picture is empty"),
        1..=MAX_PIXELS => return Ok((decoder, format)),
        _ => format!("{width} × {height} pixels, but at most {MAX_PIXELS} are supported; scale the picture down"),
    };
    Err(Error::malformed(&failure.path, "the header", cause))
}

fn count(decoder: &impl ImageDecoder) -> u64 {
    let (width, height) = decoder.dimensions();
    u64::from(width) * u64::from(height)
}

/// The file that can't be decoded, and its length.
struct Failure {
    path: PathBuf,
    len: u64,
}

impl Failure {
    fn because(&self, error: ImageError) -> Error {
        match error {
            ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
                let what = format!("the pixels continue past the last byte, {}", self.len);
                Error::Truncated { path: self.path.clone(), what }
            }
            error => Error::malformed(&self.path, "the picture", bitmap::reason(&error)),
        }
    }
}
