//! PNG, JPEG and TIFF, decoded by the crate `image`.

use std::error::Error;

use image::error::ImageFormatHint;
use image::{DynamicImage, ImageBuffer, ImageError, ImageFormat, Limits, Pixel};

/// The first bytes of files.
const SIGNATURES: [(&[u8], ImageFormat); 4] = [
    (b"\x89PNG", ImageFormat::Png),
    (&[0xff, 0xd8, 0xff], ImageFormat::Jpeg),
    (b"II*\0", ImageFormat::Tiff),
    (b"MM\0*", ImageFormat::Tiff),
];

/// Returns the format that a file claims with its first bytes.
pub(crate) fn format(start: &[u8]) -> Option<ImageFormat> {
    SIGNATURES.into_iter().find(|(signature, _)| start.starts_with(signature)).map(|(_, format)| format)
}

/// Limits under which a header is read: what it says beside the pixels (texts, color profiles) takes little more
/// memory than the file's `len` bytes.
pub(crate) fn limits(len: u64) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(len.saturating_mul(4).saturating_add(32 << 20));
    limits
}

/// Cause of a failure, behind the format's name.
pub(crate) fn reason(error: &ImageError) -> String {
    if let ImageError::Decoding(failure) = error
        && let (ImageFormatHint::Exact(format), Some(cause)) = (failure.format_hint(), failure.source())
    {
        return format!("{}: {cause}", format!("{format:?}").to_uppercase());
    }
    error.to_string()
}

/// Red, green, blue and alpha of a pixel.
pub(crate) enum Sample {
    /// 8 or 16 bits, sRGB-encoded except alpha: 0 to 65535.
    Encoded([u16; 4]),
    /// Any numbers, NaN too.
    Linear([f32; 4]),
}

impl Sample {
    /// Returns the pixel in a column and row; opaque where the picture has no alpha.
    pub fn of(picture: &DynamicImage, x: u32, y: u32) -> Self {
        // 255 becomes 65535.
        let wide = |bytes: [u8; 4]| Self::Encoded(bytes.map(|byte| u16::from(byte) * 257));
        match picture {
            DynamicImage::ImageLuma8(picture) => wide(rgba(picture, x, y)),
            DynamicImage::ImageLumaA8(picture) => wide(rgba(picture, x, y)),
            DynamicImage::ImageRgb8(picture) => wide(rgba(picture, x, y)),
            DynamicImage::ImageRgba8(picture) => wide(rgba(picture, x, y)),
            DynamicImage::ImageLuma16(picture) => Self::Encoded(rgba(picture, x, y)),
            DynamicImage::ImageLumaA16(picture) => Self::Encoded(rgba(picture, x, y)),
            DynamicImage::ImageRgb16(picture) => Self::Encoded(rgba(picture, x, y)),
            DynamicImage::ImageRgba16(picture) => Self::Encoded(rgba(picture, x, y)),
            DynamicImage::ImageRgb32F(picture) => Self::Linear(rgba(picture, x, y)),
            DynamicImage::ImageRgba32F(picture) => Self::Linear(rgba(picture, x, y)),
            // The crate has no others so far.
            _ => Self::Encoded([0; 4]),
        }
    }
}

fn rgba<P: Pixel>(picture: &ImageBuffer<P, Vec<P::Subpixel>>, x: u32, y: u32) -> [P::Subpixel; 4] {
    picture.get_pixel(x, y).to_rgba().0
}
