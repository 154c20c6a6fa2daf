//! PNG and EXR as linear values, for comparison.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::{Error, Format};
use crate::color::decode_srgb;
use crate::scene::MAX_SIDE;

/// Linear RGB, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// As many as width × height.
    pub pixels: Vec<[f32; 3]>,
}

/// Reads a PNG (sRGB-decoded; an alpha channel is composed over black, in linear light) or the R, G, B of an EXR.
///
/// # Errors
/// An extension other than `.png` and `.exr`, a missing or damaged file, more than 2²⁸ pixels.
pub fn read_image(path: &Path) -> Result<LinearImage, Error> {
    match Format::of(path)? {
        Format::Png => read_png(path),
        Format::Exr => read_exr(path),
    }
}

fn open(path: &Path) -> Result<BufReader<File>, Error> {
    let failed = |source| Error::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(Error::IsFolder { path: path.to_owned() });
    }
    Ok(BufReader::new(file))
}

fn check_size(path: &Path, width: u64, height: u64) -> Result<(), Error> {
    if width.max(height) > u64::from(MAX_SIDE) {
        return Err(Error::TooLarge { path: path.to_owned(), width, height });
    }
    Ok(())
}

fn read_png(path: &Path) -> Result<LinearImage, Error> {
    let failed = |error: image::ImageError| Error::Decode { path: path.to_owned(), reason: error.to_string() };
    let mut decoder = image::codecs::png::PngDecoder::new(open(path)?).map_err(failed)?;
    let (width, height) = image::ImageDecoder::dimensions(&decoder);
    check_size(path, width.into(), height.into())?;
    // The largest allowed image at 16 bits, RGBA; the decoder's default would refuse it.
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(u64::from(MAX_SIDE).pow(2) * 8);
    image::ImageDecoder::set_limits(&mut decoder, limits).map_err(failed)?;
    let picture = image::DynamicImage::from_decoder(decoder).map_err(failed)?.into_rgba32f();
    let pixels = picture.pixels().map(|image::Rgba([r, g, b, a])| [r, g, b].map(|value| decode_srgb(*value) * a));
    Ok(LinearImage { width, height, pixels: pixels.collect() })
}

fn read_exr(path: &Path) -> Result<LinearImage, Error> {
    use exr::prelude::*;
    let failed = |error: Error| super::Error::Decode { path: path.to_owned(), reason: error.to_string() };
    // The pixels are allocated from the header alone, so it is checked first.
    let meta = MetaData::read_from_buffered(open(path)?, false).map_err(failed)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.0 as u64, header.layer_size.1 as u64)?;
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
        .from_unbuffered(open(path)?)
        .map_err(failed)?;
    let Vec2(width, height) = picture.layer_data.size;
    let pixels = picture.layer_data.channel_data.pixels.1;
    // Both fit: check_size allowed at most MAX_SIDE.
    Ok(LinearImage { width: width as u32, height: height as u32, pixels })
}
