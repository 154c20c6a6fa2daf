//! Images in linear light, as they are compared.

use glam::Vec3;

use super::Error;
use crate::color::ColorSpace;
use crate::image::{Image, LinearImage};
use crate::io::has_memory;
use crate::output;

/// Bytes of a pixel: 12 of the image, and three times as many for differences from others.
const BYTES_PER_PIXEL: u64 = 4 * 12;

/// Returns an image over a background (linear RGB) in linear light, to be compared with others.
///
/// # Errors
/// [`Error::HostMemory`] where there is no memory for it and for what a comparison makes of it.
pub fn linear(image: &Image, background: Vec3, color: ColorSpace) -> Result<LinearImage, Error> {
    let Image { width, height, .. } = *image;
    let bytes = BYTES_PER_PIXEL * u64::from(width) * u64::from(height);
    match has_memory(bytes) {
        true => Ok(output::linear(image, background, color)),
        false => Err(Error::HostMemory { width, height, bytes }),
    }
}
