//! APNG: all colors, and transparency.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use super::interrupted;
use super::page::Caption;
use super::stills::Stills;

/// Writes an animation, which plays for ever if the path is closed, else once.
pub fn write(out: impl Write, stills: &Stills<'_>, fps: u32, caption: &Caption, step: &dyn Fn()) -> io::Result<()> {
    let [width, height] = stills.size();
    let mut encoder = Encoder::new(out, width, height);
    encoder.set_color(if stills.alpha() { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_animated(stills.count() as u32, u32::from(!caption.closed))?;
    encoder.set_frame_delay(1, fps as u16)?;
    for (name, value) in &caption.metadata {
        if value.is_ascii() {
            encoder.add_text_chunk(name.clone(), value.clone())?;
        } else {
            encoder.add_itxt_chunk(name.clone(), value.clone())?;
        }
    }
    let mut writer = encoder.write_header()?;
    for still in stills.iter() {
        interrupted()?;
        writer.write_image_data(&still?.bytes)?;
        step();
    }
    Ok(writer.finish()?)
}
