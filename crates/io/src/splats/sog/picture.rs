//! Lossless WebP pictures, whose bytes are numbers.

use std::io::Cursor;

use image_webp::WebPDecoder;

use super::super::MOST_PER_BYTE;
use super::files::Files;
use crate::{Error, decoder};

/// Pixels of a picture beyond those of its splats: writers make pictures about square, with sides that are multiples of
/// four.
const MOST_SPARE: u64 = 1 << 16;

/// Red, green, blue and alpha of pixels.
pub(super) struct Pixels {
    bytes: Vec<u8>,
    /// Bytes of a pixel: 3 without alpha, which then is 255.
    channels: usize,
}

impl Pixels {
    /// Returns a pixel, row by row.
    pub fn at(&self, place: usize) -> [u8; 4] {
        match self.bytes.get(place * self.channels..).unwrap_or_default() {
            [red, green, blue, alpha, ..] if self.channels == 4 => [*red, *green, *blue, *alpha],
            [red, green, blue, ..] => [*red, *green, *blue, 255],
            _ => [0; 4],
        }
    }
}

/// Reads a picture with a pixel for each of some splats.
pub(super) fn read(files: &Files, name: &str, splats: u64) -> Result<Pixels, Error> {
    decode(files, name, |[width, height], packed| {
        let pixels = width * height;
        if splats > packed.saturating_mul(MOST_PER_BYTE) {
            return Err(format!("{packed} bytes for {splats} splats: more than {MOST_PER_BYTE} splats for each byte"));
        }
        if pixels < splats {
            return Err(format!(
                "{width} × {height} pixels are fewer than the {splats} splats that meta.json announces"
            ));
        }
        if pixels > 2 * splats + MOST_SPARE {
            return Err(format!(
                "{width} × {height} pixels are far more than the {splats} splats that meta.json announces"
            ));
        }
        Ok(())
    })
}

/// Reads a picture of this width and at least this height.
pub(super) fn read_sized(files: &Files, name: &str, [width, height]: [u64; 2]) -> Result<Pixels, Error> {
    decode(files, name, |[found, rows], _| {
        if found != width || rows < height || rows > height + MOST_SPARE / width.max(1) {
            return Err(format!("{found} × {rows} pixels, expected {width} × {height} for this palette"));
        }
        Ok(())
    })
}

/// Decodes a picture whose size and number of bytes pass a check.
fn decode(files: &Files, name: &str, check: impl FnOnce([u64; 2], u64) -> Result<(), String>) -> Result<Pixels, Error> {
    let bytes = files.read(name)?;
    let packed = bytes.len() as u64;
    let decoded = decoder::guard(|| {
        let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(|e| format!("not a WebP picture: {e}"))?;
        let (width, height) = decoder.dimensions();
        check([width.into(), height.into()], packed)?;
        if decoder.is_animated() || decoder.is_lossy() {
            return Err(
                "the WebP picture is lossy or animated, expected a lossless one, as its bytes are numbers".to_owned()
            );
        }
        let mut bytes = vec![0; decoder.output_buffer_size().unwrap_or(0)];
        decoder.read_image(&mut bytes).map_err(|e| e.to_string())?;
        Ok(Pixels { bytes, channels: if decoder.has_alpha() { 4 } else { 3 } })
    });
    decoded.and_then(|result| result).map_err(|cause| files.malformed(name, cause))
}
