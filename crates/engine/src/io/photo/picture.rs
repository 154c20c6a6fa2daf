//! PNG, JPEG and TIFF as pixels. What a header claims is compared with the file's length before memory is taken.

use glam::Vec3;
use image::{DynamicImage, GenericImageView, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::{MAX_PIXELS, Source, directory};
use crate::color::decode_srgb;
use crate::io::{Error, decoder};

/// Bytes that one byte of a file may become: Deflate, the strongest of the codings in use, makes at most 1032.
const LARGEST_RATIO: u64 = 1100;

/// Bytes of pixels that any file may hold, so that the rule above does not meet tiny flat pictures.
const ALWAYS_ALLOWED: u64 = 16 << 20;

/// The same of a JPEG, whose decoder makes up what is missing: a header alone would become a picture. Two bits for a block
/// of 64 samples, or one in a progressive file, are a ratio of at most 1024.
const ALWAYS_ALLOWED_JPEG: u64 = 1 << 20;

/// A decoded picture, turned as the camera was held (EXIF).
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Whether it has an alpha channel.
    pub has_alpha: bool,
    pixels: Pixels,
}

enum Pixels {
    /// 8 and 16 bits alike, and the linear values of all 2¹⁶ encoded ones.
    Encoded(image::ImageBuffer<image::Rgba<u16>, Vec<u16>>, Vec<f32>),
    /// Float: linear.
    Linear(image::Rgba32FImage),
}

impl Picture {
    /// Decodes a whole file. A panic of the decoder is the file's fault.
    pub fn read(mut source: Source) -> Result<Self, Error> {
        directory::check(&mut source)?;
        let path = source.path.clone();
        decoder::guard(|| Self::decode(source)).unwrap_or_else(|panic| {
            Err(Error::Malformed { path, place: "the picture".into(), cause: format!("the decoder gave up: {panic}") })
        })
    }

    fn decode(source: Source) -> Result<Self, Error> {
        let (path, len) = (source.path.clone(), source.len);
        let malformed =
            |place: &str, cause: String| Error::Malformed { path: path.clone(), place: place.into(), cause };
        let failed = |error: ImageError| match error {
            ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                Error::Truncated { path: path.clone(), what: format!("the pixels go on behind byte {len}") }
            }
            error => malformed("the picture", error.to_string()),
        };
        let reader = ImageReader::new(source.reader).with_guessed_format();
        let reader = reader.map_err(|source| Error::Read { path: path.clone(), source })?;
        let is_jpeg = reader.format() == Some(ImageFormat::Jpeg);
        let mut decoder = reader.into_decoder().map_err(failed)?;
        let (width, height) = decoder.dimensions();
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 {
            return Err(malformed("the header", format!("{width} × {height} pixels: there is nothing in it")));
        }
        if pixels > MAX_PIXELS {
            let cause = format!("{width} × {height} pixels, but {MAX_PIXELS} is the most; scale it down");
            return Err(malformed("the header", cause));
        }
        let bytes = decoder.total_bytes();
        let allowed = if is_jpeg { ALWAYS_ALLOWED_JPEG } else { ALWAYS_ALLOWED };
        if bytes > allowed && bytes / LARGEST_RATIO > len {
            let what = format!("{width} × {height} pixels of {bytes} bytes can't be in a file of {len}");
            return Err(Error::Truncated { path: path.clone(), what });
        }
        let mut limits = Limits::default();
        // The picture, and what its decoder keeps beside it.
        limits.max_alloc = Some(2 * bytes + (64 << 20));
        decoder.set_limits(limits).map_err(failed)?;
        let orientation = decoder.orientation().map_err(failed)?;
        let mut decoded = DynamicImage::from_decoder(decoder).map_err(failed)?;
        decoded.apply_orientation(orientation);
        Ok(Self::from(decoded))
    }

    /// Linear color and alpha of a pixel; column from the left, row from the top.
    pub fn pixel(&self, x: u32, y: u32) -> (Vec3, f32) {
        match &self.pixels {
            Pixels::Encoded(pixels, linear) => {
                let [r, g, b, a] = pixels.get_pixel(x, y).0;
                let decode = |value: u16| linear.get(usize::from(value)).copied().unwrap_or_default();
                (Vec3::new(decode(r), decode(g), decode(b)), f32::from(a) / f32::from(u16::MAX))
            }
            Pixels::Linear(pixels) => {
                let [r, g, b, a] = pixels.get_pixel(x, y).0.map(unit);
                (Vec3::new(r, g, b), a)
            }
        }
    }

    /// The stored values as numbers in [0, 1], row by row from the top; of colored pictures the mean of R, G and B.
    pub fn gray(&self) -> Vec<f32> {
        fn mean(r: f64, g: f64, b: f64) -> f32 {
            ((r + g + b) / 3.0) as f32
        }
        match &self.pixels {
            Pixels::Encoded(pixels, _) => {
                let of = |[r, g, b, _]: [u16; 4]| mean(f64::from(r), f64::from(g), f64::from(b)) / f32::from(u16::MAX);
                pixels.pixels().map(|pixel| of(pixel.0)).collect()
            }
            Pixels::Linear(pixels) => {
                let of = |[r, g, b, _]: [f32; 4]| mean(unit(r).into(), unit(g).into(), unit(b).into());
                pixels.pixels().map(|pixel| of(pixel.0)).collect()
            }
        }
    }
}

impl From<DynamicImage> for Picture {
    fn from(decoded: DynamicImage) -> Self {
        let (width, height) = decoded.dimensions();
        let has_alpha = decoded.color().has_alpha();
        let is_float = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
        let pixels = if is_float {
            Pixels::Linear(decoded.into_rgba32f())
        } else {
            let linear = |value: u16| decode_srgb(f32::from(value) / f32::from(u16::MAX));
            Pixels::Encoded(decoded.into_rgba16(), (0..=u16::MAX).map(linear).collect())
        };
        Self { width, height, has_alpha, pixels }
    }
}

/// Cut to [0, 1]; 0 for what is no number.
fn unit(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}
