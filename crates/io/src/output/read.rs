//! PNG and EXR as linear values, for comparison.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder, ImageError};

use super::{Error, Format};
use crate::bitmap::{self, Sample};
use crate::decoder::guard;
use pellucid_core::color::decode_srgb;
use pellucid_core::image::{LinearImage, MAX_SIDE};

/// Bytes that one byte of a file may become: Deflate, the strongest of the codings in use, makes at most 1032. A pixel
/// has at least a byte, but in a PNG it may have a bit.
const DEFLATE: u64 = 1100;

/// Pixels that any file may claim.
const ALWAYS_ALLOWED: u64 = 1 << 20;

/// Reads a PNG (sRGB-decoded; an alpha channel is composed over black, in linear light) or the R, G, B of an EXR.
///
/// # Errors
/// Returns an error if the extension is neither `.png` nor `.exr`, if the file is missing or damaged, or if it claims
/// more than 2²⁸ pixels or more than it can hold.
pub fn read_image(path: &Path) -> Result<LinearImage, Error> {
    match Format::from_extension(path)? {
        Format::Png => decode(path, || read_png(path)),
        Format::Exr => decode(path, || read_exr(path)),
    }
}

/// A file and its length in bytes.
pub(super) fn open(path: &Path) -> Result<(BufReader<File>, u64), Error> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_dir() {
        return Err(Error::IsFolder(path.to_owned()));
    }
    Ok((BufReader::new(file), metadata.len()))
}

/// Compares the size in a header with the limit, and with the file's length, before memory is allocated. `ratio`:
/// pixels that a byte of the file may expand to.
fn check_size(path: &Path, width: u64, height: u64, len: u64, ratio: u64) -> Result<(), Error> {
    if width.max(height) > u64::from(MAX_SIDE) {
        return Err(Error::TooLarge { path: path.to_owned(), width, height });
    }
    let pixels = width * height;
    if pixels > ALWAYS_ALLOWED && pixels / ratio > len {
        let reason = format!("truncated file or wrong header: {width} × {height} pixels don't fit in {len} bytes");
        return Err(Error::Decode { path: path.to_owned(), reason });
    }
    Ok(())
}

/// Runs a decoder; any defect of the file, even one that makes it panic, becomes an error.
pub(super) fn decode<T>(path: &Path, decoder: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    guard(decoder).unwrap_or_else(|panic| {
        Err(Error::Decode { path: path.to_owned(), reason: format!("the decoder gave up: {panic}") })
    })
}

fn read_png(path: &Path) -> Result<LinearImage, Error> {
    let failed = |error: ImageError| Error::Decode { path: path.to_owned(), reason: bitmap::reason(&error) };
    let (reader, len) = open(path)?;
    let decoder = PngDecoder::with_limits(reader, bitmap::limits(len)).map_err(failed)?;
    let (width, height) = decoder.dimensions();
    check_size(path, width.into(), height.into(), len, 8 * DEFLATE)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(failed)?;
    let linear = |(x, y): (u32, u32)| {
        let [r, g, b, a] = match Sample::of(&picture, x, y) {
            Sample::Encoded(sample) => sample.map(|value| f32::from(value) / f32::from(u16::MAX)),
            Sample::Linear(sample) => sample,
        };
        [r, g, b].map(|value| decode_srgb(value) * a)
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(linear).collect();
    Ok(LinearImage { width, height, pixels })
}

fn read_exr(path: &Path) -> Result<LinearImage, Error> {
    use exr::prelude::*;
    let failed = |error: Error| super::Error::Decode { path: path.to_owned(), reason: error.to_string() };
    // The pixels are allocated from the header alone, so it is checked first.
    let (reader, len) = open(path)?;
    let meta = MetaData::read_from_buffered(reader, false).map_err(failed)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.0 as u64, header.layer_size.1 as u64, len, DEFLATE)?;
    }
    let picture = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.0, vec![[0.0f32; 3]; size.area()]),
            |(width, pixels), at, (r, g, b): (f32, f32, f32)| {
                if let Some(pixel) = pixels.get_mut(at.1 * *width + at.0) {
                    *pixel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        // A panic on one of the decoder's threads would end the program.
        .non_parallel()
        .from_unbuffered(open(path)?.0)
        .map_err(failed)?;
    let Vec2(width, height) = picture.layer_data.size;
    let pixels = picture.layer_data.channel_data.pixels.1;
    // Both fit: check_size allowed at most MAX_SIDE.
    Ok(LinearImage { width: width as u32, height: height as u32, pixels })
}
