//! PNG, JPEG and TIFF, decoded by the crate `image`.

use image::{DynamicImage, ImageBuffer, Limits, Pixel};

/// Signatures of the formats.
const PNG: &[u8] = b"\x89PNG";
const JPEG: &[u8] = &[0xff, 0xd8, 0xff];
const TIFF: [&[u8]; 2] = [b"II*\0", b"MM\0*"];

/// Returns `true` if a file that starts with these bytes claims to be in one of the formats.
pub(crate) fn is_bitmap(start: &[u8]) -> bool {
    [PNG, JPEG].iter().chain(&TIFF).any(|signature| start.starts_with(signature))
}

/// Limits under which a header is read: what it says beside the pixels (texts, color profiles) takes little more
/// memory than the file's `len` bytes.
pub(crate) fn limits(len: u64) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(len.saturating_mul(4).saturating_add(32 << 20));
    limits
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
