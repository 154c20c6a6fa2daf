//! The frames of a film, read back one by one.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::PathBuf;

use pellucid_engine::output::{self, Raster};
use png::{BitDepth, ColorType, Decoder};

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
    let mut reader = Decoder::new(BufReader::new(File::open(path)?)).read_info().map_err(io::Error::other)?;
    let (color, depth) = reader.output_color_type();
    let alpha = match (color, depth) {
        (ColorType::Rgb, BitDepth::Eight) => false,
        (ColorType::Rgba, BitDepth::Eight) => true,
        _ => return Err(io::Error::other("not a PNG of 8-bit RGB or RGBA, as frames are")),
    };
    let length = reader.output_buffer_size().ok_or_else(|| io::Error::other("too large"))?;
    let mut bytes = vec![0; length];
    let info = reader.next_frame(&mut bytes).map_err(io::Error::other)?;
    bytes.truncate(info.buffer_size());
    Ok(Raster { size: [info.width, info.height], alpha, bytes })
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
