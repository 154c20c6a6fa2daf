//! Files that come out: PNG and EXR with their metadata, written whole or not at all, and read back for comparison.

pub mod deep;
mod exr;
mod file;
mod inputs;
mod matrices;
mod png;
mod read;
pub mod room;
mod tag;

use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use glam::Vec3;

pub use file::{Files, check_folder, check_report_folder, make_folder, write_atomically};
pub use inputs::{Inputs, Output};
pub use png::{raster, to_byte};
pub use read::read_image;
pub use tag::{CAMERA_TAG, Tagged, metadata, tagged};

use crate::has_memory;
use pellucid_core::atomic::remedy;
use pellucid_core::camera::Camera;
use pellucid_core::color;
use pellucid_core::color::ColorSpace;
use pellucid_core::image::MAX_SIDE;
use pellucid_core::image::{Image, LinearImage};

/// Reason why a result could not be written or an image not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// Unknown extension: neither `.png` nor `.exr`.
    #[error("{path}: unknown image format; the name must end in .png (8-bit sRGB) or .exr (32-bit float)", path = .0.display())]
    UnknownExtension(PathBuf),
    /// The folder of an output file is missing.
    #[error("{path}: no folder {folder}; create it first", path = path.display(), folder = folder.display())]
    NoFolder { path: PathBuf, folder: PathBuf },
    /// The output's name is that of a folder.
    #[error("{path}: this is a folder; give a file name", path = .0.display())]
    IsFolder(PathBuf),
    /// A file exists in place of a folder.
    #[error("{path}: {file} is a file and not a folder; name another folder", path = path.display(), file = file.display())]
    NotAFolder { path: PathBuf, file: PathBuf },
    /// The file could not be written; the earlier file remains.
    #[error("{path}: can't be written: {source}{help}", path = path.display(), help = remedy(source))]
    Write { path: PathBuf, source: std::io::Error },
    /// The file system has too little room for a file.
    #[error(
        "{path}: may take {bytes}, but only {free} are free there; free some space, write elsewhere, or reduce it (fewer \
         pixels, fewer points, --deep-type half)",
        path = path.display()
    )]
    NoRoom { path: PathBuf, bytes: ByteSize, free: ByteSize },
    /// Memory can't hold an image, or what its file is made of.
    #[error(
        "{path}: a picture of {width} × {height} pixels needs {bytes} of memory, which are not free; use a smaller --size",
        path = path.display()
    )]
    NoMemory { path: PathBuf, width: u32, height: u32, bytes: ByteSize },
    /// The file could not be opened or read.
    #[error("{path}: can't be read: {source}", path = path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// The file's content contradicts its name.
    #[error("{path}: {reason}", path = path.display())]
    Decode { path: PathBuf, reason: String },
    /// The image has more pixels than images may have here.
    #[error("{path}: {width} × {height} pixels, but no side may have more than {MAX_SIDE}", path = path.display())]
    TooLarge { path: PathBuf, width: u64, height: u64 },
    /// Two images to compare are not equally large.
    #[error("{a} has {a_width} × {a_height} pixels, but {b} has {b_width} × {b_height}; only images of the same size can be \
         compared", a = a.display(), b = b.display())]
    SizesDiffer { a: PathBuf, a_width: u32, a_height: u32, b: PathBuf, b_width: u32, b_height: u32 },
    /// Frames would overwrite other files.
    #[error(
        "{path}: this file is not a frame of this sequence ({count} such files) but of another scene, camera, size or \
         setting; give -o another name, or --overwrite to replace them",
        path = path.display()
    )]
    Foreign { path: PathBuf, count: usize },
    /// The image's colors came as those of an opaque PNG, which this file isn't.
    #[error("{path}: only the colors of an opaque PNG were asked of this picture", path = .0.display())]
    OnlyBytes(PathBuf),
    /// An output would replace an input.
    #[error("{output}: this would replace the input {input}; give the output another name", input = input.display())]
    Input { output: String, input: PathBuf },
    /// Two outputs of one command are the same file.
    #[error("{a} and {b}: both are the same file; give each another name")]
    SameOutput { a: String, b: String },
    /// A part of a report could not be made.
    #[error("the report: {reason}")]
    Report { reason: String },
    /// Standard output can't be written to.
    #[error("standard output: {0}{help}", help = remedy(.0))]
    Stdout(std::io::Error),
}

impl Error {
    /// 2 for an unknown extension and for an output that is an input or another output, else 1.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::UnknownExtension { .. } | Self::Input { .. } | Self::SameOutput { .. } => 2,
            _ => 1,
        }
    }
}

/// Options for writing an [`Image`].
#[derive(Debug, Clone, PartialEq)]
pub struct WriteOptions {
    /// Linear RGB behind the image, as in the scene; it is encoded here if `color` requires it.
    pub background: Vec3,
    /// The color space of the image's values. A PNG stores encoded values unchanged; an EXR stores them decoded.
    pub color: ColorSpace,
    /// PNG only: RGBA with straight alpha and no background instead of RGB over the background.
    pub transparent: bool,
    /// Names and values, in the order in which a PNG lists them (EXR: by name).
    pub metadata: Vec<(String, String)>,
    /// EXR only: the camera of OpenEXR's standard attributes `worldToCamera` and `worldToNDC`, if there was one.
    pub camera: Option<Camera>,
    /// Files that the image was made of, which it must not replace.
    pub inputs: Inputs,
}

/// Returns the metadata of an image: the inputs as named by the user, the method used, the scene's keys as JSON
/// (`Scene::settings`), the device's name and the seed.
pub fn tags(name: &str, method: &str, settings: &str, device: &str, seed: u64) -> Vec<(String, String)> {
    let entry = |key: &str, value: &str| (format!("pellucid:{key}"), value.to_owned());
    vec![
        entry("scene", name),
        entry("method", method),
        entry("settings", settings),
        entry("device", device),
        entry("version", env!("CARGO_PKG_VERSION")),
        entry("seed", &seed.to_string()),
    ]
}

/// An image format by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

impl Format {
    fn from_extension(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::UnknownExtension(path.to_owned())),
        }
    }

    /// Bytes of memory for each pixel that writing takes beside the image, with so many channels.
    fn pixel_bytes(self, channels: u64) -> u64 {
        // The composed color.
        let composed = 3 * 4;
        match self {
            // 8-bit values in a vector that grows, and the compressed file.
            Self::Png => composed + 2 * 4 + 4,
            // Each channel by itself, and the compressed file.
            Self::Exr => composed + 2 * 4 * channels,
        }
    }
}

/// Refuses an image file that could not be written in the end: call it before rendering.
///
/// # Errors
/// An extension other than `.png` and `.exr`, a missing folder, a folder of that name.
pub fn check_target(path: &Path) -> Result<(), Error> {
    Format::from_extension(path)?;
    check_folder(path)
}

/// Refuses an image that memory could not hold, or not be written from: call it before rendering.
///
/// # Errors
/// [`Error::NoMemory`], and an extension other than `.png` and `.exr`.
pub fn check_memory(path: &Path, size: [u32; 2]) -> Result<(), Error> {
    // Color, A and Z.
    const IMAGE_BYTES: u64 = 5 * 4;
    let format = Format::from_extension(path)?;
    check_bytes(path, size, IMAGE_BYTES + format.pixel_bytes(5))
}

fn check_bytes(path: &Path, size: [u32; 2], each: u64) -> Result<(), Error> {
    let [width, height] = size;
    let bytes = each * u64::from(width) * u64::from(height);
    match has_memory(bytes) {
        true => Ok(()),
        false => Err(Error::NoMemory { path: path.to_owned(), width, height, bytes: ByteSize(bytes) }),
    }
}

/// Writes an image as PNG or EXR, by the extension; the same image and options give the same bytes.
///
/// PNG: 8-bit sRGB, round to nearest, values outside [0, 1] clamped, NaN as 0. EXR: float32 channels R, G, B (composed
/// over the background), A, Z and, if the image has them, `depth.median`, `depth.mean`, `fragments.Y`, `layers.Y` and
/// `stderr.R`, `stderr.G`, `stderr.B`; ZIP, which is lossless.
///
/// # Errors
/// Returns the errors of [`check_target`], an error for a path that is one of the image's inputs, and errors of the
/// system while writing; the earlier file then remains. [`Error::OnlyBytes`] for an image that is good for an opaque
/// PNG alone.
pub fn write_image(path: &Path, image: &Image, options: &WriteOptions) -> Result<(), Error> {
    let format = check_image(path, image, options)?;
    write_atomically(path, |file| match format {
        Format::Png => png::encode(file, &raster(image, options), &options.metadata),
        Format::Exr => exr::encode(file, image, options),
    })
}

/// Refuses an image that can't be written, or for which memory lacks room meanwhile: call it before [`raster`].
///
/// # Errors
/// Returns [`Error::NoMemory`] and [`Error::OnlyBytes`], and an error for a path that is one of the image's inputs or
/// has another extension than `.png` and `.exr`.
pub fn check_writing(path: &Path, image: &Image, options: &WriteOptions) -> Result<(), Error> {
    check_image(path, image, options).map(drop)
}

fn check_image(path: &Path, image: &Image, options: &WriteOptions) -> Result<Format, Error> {
    let format = Format::from_extension(path)?;
    options.inputs.refuse(path)?;
    if image.bytes.is_some() && (format == Format::Exr || options.transparent) {
        return Err(Error::OnlyBytes(path.to_owned()));
    }
    let of = |is_there: bool, channels| if is_there { channels } else { 0 };
    let more = of(image.depth_median.is_some(), 1)
        + of(image.depth_mean.is_some(), 1)
        + of(image.fragments.is_some(), 1)
        + of(image.layers.is_some(), 1)
        + of(image.stderr.is_some(), 3);
    check_bytes(path, [image.width, image.height], format.pixel_bytes(5 + more))?;
    Ok(format)
}

/// The pixels of a PNG.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Columns and rows.
    pub size: [u32; 2],
    /// `true` for R, G, B, A with straight alpha, `false` for R, G, B.
    pub alpha: bool,
    /// 8-bit sRGB, row by row from the top.
    pub bytes: Vec<u8>,
}

/// Returns the bytes of the PNG that [`write_image`] writes.
///
/// # Errors
/// A size that PNG can't have.
pub fn png_bytes(image: &Image, options: &WriteOptions) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    png::encode(&mut bytes, &raster(image, options), &options.metadata)?;
    Ok(bytes)
}

/// Writes pixels as a PNG, whatever the extension.
///
/// # Errors
/// A missing folder, a number of bytes that doesn't match the size, and errors of the system while writing; the earlier
/// file then remains.
pub fn write_raster(path: &Path, raster: &Raster, metadata: &[(String, String)]) -> Result<(), Error> {
    write_atomically(path, |file| png::encode(file, raster, metadata))
}

/// Writes linear RGB values as an opaque 8-bit PNG, sRGB-encoded, whatever the extension; `pixels` are row by row.
///
/// # Errors
/// A missing folder, a number of `pixels` that doesn't match `size`, and errors of the system while writing.
pub fn write_rgb_png(path: &Path, size: [u32; 2], pixels: &[[f32; 3]]) -> Result<(), Error> {
    let bytes = pixels.iter().flatten().map(|linear| to_byte(color::encode_srgb(*linear))).collect();
    write_raster(path, &Raster { size, alpha: false, bytes }, &[])
}

/// Returns an image over a background (linear RGB) in linear light: the values of R, G and B in an EXR.
pub fn linear(image: &Image, background: Vec3, color: ColorSpace) -> LinearImage {
    let mut pixels = image.composed(self::background(background, color));
    if color == ColorSpace::Encoded {
        pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(color::decode_srgb));
    }
    LinearImage { width: image.width, height: image.height, pixels }
}

/// Returns a linear background in the space of an image's values.
pub fn background(linear: Vec3, color: ColorSpace) -> Vec3 {
    match color {
        ColorSpace::Linear => linear,
        ColorSpace::Encoded => Vec3::from_array(linear.to_array().map(color::encode_srgb)),
    }
}
