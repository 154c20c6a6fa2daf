//! `--html`: a page that turns the scene, out of pictures of it.

use std::io::{self, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bytesize::ByteSize;
use glam::Vec3;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use maud::{PreEscaped, html};
use pellucid_core::color::encode_srgb;
use pellucid_io::output::{Raster, to_byte};
use pellucid_lab::report::page;

use super::interrupted;
use super::stills::Stills;
use crate::commands::typed::quoted;

/// Quality of the JPEG pictures, of 100; docs/films.md has what others would take.
const QUALITY: u8 = 85;

/// A page above is long on its way, and slow to open.
const LARGE: u64 = 100 << 20;

/// Linear luminance of a background from which on text is dark: sRGB 0.5, halfway between black and white to the eye.
const LIGHT: f32 = 0.214;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Placeholder of the frames in the page. No text has it, since its brackets would be escaped.
const FRAMES: &str = "<!--frames-->";

/// Text about the frames.
pub struct Caption {
    /// The scene's name.
    pub title: String,
    pub points: u64,
    pub method: &'static str,
    /// True if the first frame follows the last.
    pub closed: bool,
    /// Linear RGB.
    pub background: Vec3,
    /// Metadata as in a single picture.
    pub metadata: Vec<(String, String)>,
}

/// Writes the page, frame after frame.
pub fn write(
    out: &mut impl Write,
    stills: &Stills<'_>,
    fps: u32,
    caption: &Caption,
    warn: &dyn Fn(String),
    step: &dyn Fn(),
) -> io::Result<()> {
    let whole = whole(stills, fps, caption);
    let (before, after) =
        whole.split_once(FRAMES).ok_or_else(|| io::Error::other("a page without a place for frames"))?;
    out.write_all(before.as_bytes())?;
    for (number, still) in stills.iter().enumerate() {
        interrupted()?;
        let picture = STANDARD.encode(jpeg(&still?)?);
        if number == 0 {
            let bytes = (picture.len() * stills.count()) as u64;
            if bytes > LARGE {
                let size = ByteSize(bytes);
                warn(format!("the page will have about {size}; a smaller --size or fewer --frames make it lighter"));
            }
        }
        let address = format!("data:image/jpeg;base64,{picture}");
        out.write_all(html! { img src=(address) alt=""; }.into_string().as_bytes())?;
        step();
    }
    out.write_all(after.as_bytes())
}

/// The page without its frames.
fn whole(stills: &Stills<'_>, fps: u32, caption: &Caption) -> String {
    let Caption { title, points, method, closed, .. } = caption;
    let [width, height] = stills.size();
    let (count, last) = (stills.count(), stills.count() - 1);
    let how = if *closed { "Drag to turn" } else { "Drag to move along the path" };
    let style = format!("{}{STYLE}", colors(caption.background));
    let body = html! {
        main {
            h1 { (title) }
            canvas width=(width) height=(height) role="img" aria-label=(format!("{title}, {count} views")) data-closed=(closed) data-fps=(fps) {}
            noscript { p { "The picture turns by JavaScript, which is switched off here." } }
            div.controls {
                button type="button" { "Play" }
                input type="range" min="0" max=(last) step="1" value="0" aria-label="view";
                output { "frame 1 of " (count) }
            }
            p.about {
                (how) ", or use the slider, the arrow keys, Home, End, and Space to play. "
                (page::grouped(*points)) " points, method " (method) ", " (count) " pictures, made by pellucid: "
                code { (command()) }
            }
            div #frames hidden { (PreEscaped(FRAMES)) }
        }
        (page::script(SCRIPT))
    };
    page::document(title, &style, &body)
}

/// The background's color, and one that can be read on it.
fn colors(background: Vec3) -> String {
    let [r, g, b] = background.to_array().map(|value| to_byte(encode_srgb(value)));
    let is_light = background.dot(Vec3::new(0.2126, 0.7152, 0.0722)) > LIGHT;
    let (scheme, ink) = if is_light { ("light", "#1c1c1c") } else { ("dark", "#ededed") };
    format!(":root {{ color-scheme: {scheme}; --paper: rgb({r} {g} {b}); --ink: {ink}; }}\n")
}

/// The command as it was typed. Folders from the root on are left out: they name people, and mean nothing elsewhere.
fn command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| {
        let path = Path::new(&argument);
        let name = path.file_name().filter(|_| path.is_absolute()).unwrap_or(&argument);
        quoted(&name.to_string_lossy())
    });
    std::iter::once("pellucid".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn jpeg(raster: &Raster) -> io::Result<Vec<u8>> {
    let side = |side: u32| u16::try_from(side).map_err(|_| io::Error::other("a JPEG has at most 65535 pixels a side"));
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, QUALITY);
    // Single points have colors of their own, which chroma of half the size would blur.
    encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
    encoder.set_optimized_huffman_tables(true);
    encoder
        .encode(&raster.bytes, side(raster.size[0])?, side(raster.size[1])?, ColorType::Rgb)
        .map_err(io::Error::other)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_can_be_read_on_the_background() {
        assert!(colors(Vec3::ONE).contains("color-scheme: light; --paper: rgb(255 255 255); --ink: #1c1c1c"));
        assert!(colors(Vec3::ZERO).contains("color-scheme: dark; --paper: rgb(0 0 0); --ink: #ededed"));
    }
}
