//! 8-bit PNG.

use std::io::{self, Write};

use super::{Raster, WriteOptions, background};
use pellucid_core::color::ColorSpace;
use pellucid_core::color::encode_srgb;
use pellucid_core::image::Image;

/// Returns the pixels that [`write_image`](super::write_image) writes into a PNG, for those who draw onto them first:
/// the image composed over the background, or with straight alpha if it is to stay transparent. Bytes that came with
/// the image are taken as they are.
pub fn raster(image: &Image, options: &WriteOptions) -> Raster {
    let encoded = |value: f32| match options.color {
        ColorSpace::Linear => encode_srgb(value),
        ColorSpace::Encoded => value,
    };
    let bytes: Vec<u8> = if let Some(bytes) = &image.bytes {
        bytes.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()
    } else if options.transparent {
        let pixels = image.rgba.iter().map(|&[r, g, b, a]| straight([r, g, b], a, encoded));
        pixels.flatten().collect()
    } else {
        image
            .composed(background(options.background, options.color))
            .iter()
            .flatten()
            .map(|value| to_byte(encoded(*value)))
            .collect()
    };
    Raster { size: [image.width, image.height], alpha: options.transparent && image.bytes.is_none(), bytes }
}

/// Straight color and alpha of a premultiplied pixel; nothing at all where nothing was drawn.
fn straight(color: [f32; 3], alpha: f32, encoded: impl Fn(f32) -> f32) -> [u8; 4] {
    if alpha > 0.0 {
        let [r, g, b] = color.map(|value| to_byte(encoded(value / alpha)));
        [r, g, b, to_byte(alpha)]
    } else {
        [0; 4]
    }
}

/// Returns the nearest of 256 steps; NaN is 0.
pub fn to_byte(value: f32) -> u8 {
    // In float64, since 255·x + 0.5 in float32 would round values just below a half up to the next step. The cast of
    // NaN is 0.
    (255.0 * f64::from(value.clamp(0.0, 1.0)) + 0.5).floor() as u8
}

/// A PNG with text chunks.
pub(super) fn encode(out: impl Write, raster: &Raster, metadata: &[(String, String)]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, raster.size[0], raster.size[1]);
    encoder.set_color(if raster.alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (name, value) in metadata {
        // tEXt is Latin-1, which every reader knows; iTXt is UTF-8.
        if value.is_ascii() {
            encoder.add_text_chunk(name.clone(), value.clone())?;
        } else {
            encoder.add_itxt_chunk(name.clone(), value.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&raster.bytes)?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_rounded_clamped_and_never_nan() {
        assert_eq!([0.0, 1.0, 2.0, -1.0, f32::NAN, f32::INFINITY].map(to_byte), [0, 255, 255, 0, 0, 255]);
        // The step from 0 to 1 is at 0.5/255 = 0.00196078.
        assert_eq!([0.001_960_7, 0.001_960_9].map(to_byte), [0, 1]);
        assert_eq!(
            (0..=255u8).map(|b| to_byte(f32::from(b) / 255.0)).collect::<Vec<_>>(),
            (0..=255).collect::<Vec<_>>()
        );
    }

    #[test]
    fn straight_color_is_divided_before_it_is_encoded() {
        // Linear 0.107020570/0.5 = 0.21404114 is sRGB 0.5: 127.5, a hair above by rounding up.
        let [r, g, _, a] = straight([0.107_020_6, 0.5, 0.0], 0.5, encode_srgb);
        assert!((127..=128).contains(&r), "{r}");
        assert_eq!((g, a), (255, 128));
        assert_eq!(straight([0.0; 3], 0.0, encode_srgb), [0; 4]);
    }
}
