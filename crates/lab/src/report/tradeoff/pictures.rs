//! Pictures for the page: reduced, so that dozens of them fit one file, and each only once.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ImageError, Rgb, RgbImage, imageops};
use rayon::prelude::*;

use super::Tradeoff;
use pellucid_core::color::{decode_srgb, encode_srgb};
use pellucid_io::output;

/// Wider pictures are reduced by a whole factor until they are no wider.
const MAX_WIDTH: u32 = 640;
/// Pixels of all pictures of a page together at most, so that it does not get too large for a browser.
const MAX_PIXELS: u64 = 24 << 20;

/// The pictures of all rows, as data URIs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pictures {
    /// Every different one once.
    pub uris: Vec<String>,
    /// The reference's index in `uris`.
    pub reference: usize,
    /// Indices in `uris` of each row's picture and of its difference picture.
    pub rows: Vec<[usize; 2]>,
    /// Width and height of the pictures as they are embedded.
    pub size: [u32; 2],
    /// Pixels of a file across one embedded pixel.
    pub factor: u32,
}

/// How to reduce a block of pixels to one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reduce {
    /// The mean of linear light, which looks like the picture seen from farther away.
    Mean,
    /// The greatest of each channel: a single wrong pixel stays visible.
    Max,
}

impl Pictures {
    /// Reads the files that the report names.
    pub(super) fn read(folder: &Path, report: &Tradeoff) -> Result<Self, output::Error> {
        let factor = factor(report.size, report.rows.len());
        let mut files = vec![(report.reference.picture.as_str(), Reduce::Mean)];
        for row in &report.rows {
            files.extend([(row.picture.as_str(), Reduce::Mean), (row.difference.as_str(), Reduce::Max)]);
        }
        let read: Vec<_> = files.par_iter().map(|(name, how)| embedded(&folder.join(name), factor, *how)).collect();
        let mut uris = Vec::new();
        let mut known = HashMap::new();
        let mut index = |uri: String| {
            *known.entry(uri).or_insert_with_key(|uri| {
                uris.push(uri.clone());
                uris.len() - 1
            })
        };
        // Collected in order, so that the first of several failures is reported whatever the threads did.
        let read = read.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut indices = read.into_iter().map(&mut index);
        let reference = indices.next().unwrap_or(0);
        let indices: Vec<usize> = indices.collect();
        let rows = indices.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        Ok(Self { uris, reference, rows, size: report.size.map(|side| side.div_ceil(factor)), factor })
    }
}

/// The factor to reduce pictures by. Each row has two of them, and the reference one.
fn factor(size: [u32; 2], rows: usize) -> u32 {
    let pixels = |factor: u32| size.map(|side| u64::from(side.div_ceil(factor))).iter().product::<u64>();
    let all = |factor: u32| pixels(factor).saturating_mul(2 * rows as u64 + 1);
    let narrow = size[0].div_ceil(MAX_WIDTH).max(1);
    // A picture of one pixel can't be reduced.
    (narrow..).find(|factor| all(*factor) <= MAX_PIXELS || pixels(*factor) <= 1).unwrap_or(narrow)
}

fn embedded(path: &Path, factor: u32, how: Reduce) -> Result<String, output::Error> {
    uri(path, &reduced(&read(path)?, factor, how))
}

/// A picture of a file as a data URI.
pub(super) fn uri(path: &Path, picture: &RgbImage) -> Result<String, output::Error> {
    let encoded = encoded(picture)
        .map_err(|error| output::Error::Write { path: path.to_owned(), source: std::io::Error::other(error) })?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(encoded)))
}

/// Reads a PNG of 8 bits, red, green and blue, sRGB-encoded, as the report writes them.
pub(super) fn read(path: &Path) -> Result<RgbImage, output::Error> {
    let unreadable = |source| output::Error::Read { path: path.to_owned(), source };
    let failed = |error| match error {
        ImageError::IoError(source) => unreadable(source),
        other => output::Error::Decode { path: path.to_owned(), reason: other.to_string() },
    };
    let file = File::open(path).map_err(unreadable)?;
    match PngDecoder::new(BufReader::new(file)).and_then(DynamicImage::from_decoder).map_err(failed)? {
        DynamicImage::ImageRgb8(picture) => Ok(picture),
        _ => {
            let reason = "no PNG of 8 bits in red, green and blue, as the report writes them".to_owned();
            Err(output::Error::Decode { path: path.to_owned(), reason })
        }
    }
}

/// Encodes a picture as PNG.
fn encoded(picture: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    picture.write_with_encoder(encoder)?;
    Ok(bytes)
}

/// A square of a picture, cut off where the picture ends.
pub(super) fn cropped(picture: &RgbImage, [x, y]: [u32; 2], side: u32) -> RgbImage {
    imageops::crop_imm(picture, x, y, side, side).to_image()
}

/// One pixel for each block of `factor` × `factor`; blocks at the right and lower end are cut off with the picture.
fn reduced(picture: &RgbImage, factor: u32, how: Reduce) -> RgbImage {
    let linear: Vec<f32> = (0..=255u8).map(|byte| decode_srgb(f32::from(byte) / 255.0)).collect();
    let (width, height) = picture.dimensions();
    RgbImage::from_fn(width.div_ceil(factor), height.div_ceil(factor), |x, y| {
        let columns = x * factor..width.min((x + 1) * factor);
        let rows = y * factor..height.min((y + 1) * factor);
        let block = || rows.clone().flat_map(|y| columns.clone().map(move |x| picture.get_pixel(x, y).0));
        Rgb(std::array::from_fn(|channel| match how {
            Reduce::Max => block().map(|pixel| pixel[channel]).max().unwrap_or(0),
            Reduce::Mean => {
                let sum: f32 = block().map(|pixel| linear[usize::from(pixel[channel])]).sum();
                // Within [0, 255] by construction.
                (255.0 * encode_srgb(sum / (columns.len() * rows.len()) as f32)).round() as u8
            }
        }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_pictures_are_reduced_more() {
        assert_eq!((factor([640, 480], 20), factor([1024, 1024], 40), factor([1, 1], 1)), (1, 2, 1));
        // 247 pictures of 256² are 16.2 million pixels, those of 342² 28.9.
        assert_eq!(factor([1024, 1024], 123), 4);
        assert_eq!(factor([4, 4], usize::MAX / 4), 4);
    }

    #[test]
    fn blocks_become_their_mean_or_their_greatest() {
        // 3 × 2, by 2: a whole block and one of a single column.
        let pixels = [[0, 0, 7], [255, 0, 7], [9, 1, 7], [0, 0, 7], [255, 80, 7], [9, 2, 7]].concat();
        let picture = RgbImage::from_vec(3, 2, pixels).unwrap();
        let greatest = reduced(&picture, 2, Reduce::Max);
        assert_eq!(greatest, RgbImage::from_vec(2, 1, vec![255, 80, 7, 9, 2, 7]).unwrap());
        // Half of the light is 188 in sRGB, not 128.
        let mean = reduced(&picture, 2, Reduce::Mean);
        assert_eq!((mean[(0, 0)][0], mean[(0, 0)][2], mean[(1, 0)][0]), (188, 7, 9));
        assert_eq!(reduced(&picture, 1, Reduce::Mean), picture);
        assert_eq!(reduced(&picture, 1, Reduce::Max), picture);
    }

    #[test]
    fn a_square_is_cut_out() {
        let picture = RgbImage::from_fn(3, 2, |x, y| Rgb([(3 * y + x) as u8, 0, 0]));
        let red = |x, y, side| cropped(&picture, [x, y], side).pixels().map(|pixel| pixel[0]).collect::<Vec<_>>();
        assert_eq!((red(1, 0, 2), red(2, 1, 9), red(0, 0, 1)), (vec![1, 2, 4, 5], vec![5], vec![0]));
    }

    #[test]
    fn embedded_pictures_keep_their_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let picture = RgbImage::from_vec(2, 2, vec![1, 2, 3, 4, 5, 6, 7, 8, 9, 255, 0, 128]).unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, encoded(&picture).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), picture);
        std::fs::write(&path, b"no picture").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("a.png"));
    }
}
