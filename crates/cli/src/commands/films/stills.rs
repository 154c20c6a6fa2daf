//! The frames of a film, read back one by one.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::PathBuf;

use image::DynamicImage;
use image::codecs::png::PngDecoder;
use pellucid_io::output::{self, Raster};

/// Frames as PNG files of one size, with or without alpha.
pub struct Stills<'a> {
    files: &'a [PathBuf],
    size: [u32; 2],
    alpha: bool,
}

impl<'a> Stills<'a> {
    /// Frames that the renderer wrote; there is at least one.
    ///
    /// # Errors
    /// The first can't be read.
    pub fn open(files: &'a [PathBuf]) -> Result<Self, pellucid_engine::Error> {
        let path = files.first().cloned().unwrap_or_default();
        let first = read(&path).map_err(|source| output::Error::Read { path, source })?;
        Ok(Self { files, size: first.size, alpha: first.alpha })
    }

    pub fn count(&self) -> usize {
        self.files.len()
    }

    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub fn alpha(&self) -> bool {
        self.alpha
    }

    /// The frames in their order.
    ///
    /// # Errors
    /// A file that was changed since it was written; the error names it.
    pub fn iter(&self) -> impl Iterator<Item = io::Result<Raster>> {
        self.files.iter().map(|path| {
            let named = |reason: String| io::Error::other(format!("{}: {reason}", path.display()));
            let raster = read(path).map_err(|error| named(error.to_string()))?;
            if raster.size != self.size || raster.alpha != self.alpha {
                return Err(named(
                    "the frame was changed: its size or its channels are not those of the first".to_owned(),
                ));
            }
            Ok(raster)
        })
    }
}

fn read(path: &PathBuf) -> io::Result<Raster> {
    let decoder = PngDecoder::new(BufReader::new(File::open(path)?));
    let picture = decoder.and_then(DynamicImage::from_decoder).map_err(io::Error::other)?;
    let (size, alpha) = ([picture.width(), picture.height()], picture.color().has_alpha());
    match picture {
        DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_) => {
            Ok(Raster { size, alpha, bytes: picture.into_bytes() })
        }
        _ => Err(io::Error::other("not a PNG of 8-bit RGB or RGBA, as frames are")),
    }
}

/// A picture whose sides are even: the last column and the last row are repeated where they have to be.
pub fn even(raster: Raster) -> Raster {
    let Raster { size: [width, height], alpha, bytes } = raster;
    let [wide, high] = [width, height].map(|side| side.next_multiple_of(2));
    let channels = if alpha { 4 } else { 3 };
    let mut out = Vec::with_capacity(wide as usize * high as usize * channels);
    for row in bytes.chunks_exact(width as usize * channels) {
        out.extend_from_slice(row);
        if wide > width {
            out.extend_from_slice(&row[row.len() - channels..]);
        }
    }
    if high > height {
        out.extend_from_within(out.len() - wide as usize * channels..);
    }
    Raster { size: [wide, high], alpha, bytes: out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_column_and_row_make_sides_even() {
        let odd = Raster { size: [1, 3], alpha: false, bytes: (0..9).collect() };
        let even = even(odd);
        assert_eq!(even.size, [2, 4]);
        assert_eq!(even.bytes, [0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5, 6, 7, 8, 6, 7, 8, 6, 7, 8, 6, 7, 8]);
        let same = Raster { size: [2, 2], alpha: true, bytes: (0..16).collect() };
        assert_eq!(super::even(same.clone()), same);
    }
}
