//! Pictures as clouds (Tanaka et al. 2016, Section 4.5). Each pixel is a point of a plane, displaced along the plane's
//! normal by a height map, and copied where the surface is so steep that its points would be too far apart.

mod directory;
mod picture;
mod surface;

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use bytesize::ByteSize;
use glam::{DVec3, Vec3};
use pellucid_core::progress::Progress;

use super::{Error, InputFile, has_memory};
use pellucid_core::cloud::{Cloud, UpAxis};
use picture::Picture;
pub(crate) use picture::pixels;
use surface::Surface;

/// Pixels of a picture at most: 2³².
pub const MAX_PIXELS: u64 = 1 << 32;

/// Points that it may become.
const MAX_POINTS: f64 = 2.0 * MAX_PIXELS as f64;

/// A picture's placement in the world, and its displacement: `photo` of a `[[cloud]]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Photo {
    /// The picture's lower left corner; without it the picture's middle is at (0, 0, 0).
    pub origin: Option<DVec3>,
    /// Vectors from its left to its right and from its lower to its upper edge, world units, neither parallel nor zero.
    /// Without them the width is 1 along x and the height follows along y for square pixels.
    pub edges: Option<[DVec3; 2]>,
    /// The height map.
    pub heights: Option<Heights>,
}

/// A gray picture of heights over a [`Photo`]. One that isn't as large as the photo is interpolated bilinearly.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    /// The file of the height map. Values are read as plain numbers in any color space; colored pictures are converted
    /// to gray.
    pub path: PathBuf,
    /// Height of white over black, world units, along `right` × `up`; below 0: white is deepest.
    pub scale: f64,
}

/// Reads a picture as a whole.
pub(super) fn read(source: InputFile, photo: &Photo, progress: &Progress) -> Result<Cloud, Error> {
    let path = source.path.clone();
    let placed = PlacedPicture::open(source, photo)?;
    let expected = placed.expected_points();
    // Their number is random where a picture is steep; its spread is below half of its root.
    let room = (expected + expected.sqrt() + 1.0) as u64;
    let bytes = room.saturating_mul(placed.point_bytes());
    if !has_memory(bytes) {
        let cause = format!(
            "it would become {expected:.1e} points, which need {} of memory; scale the picture down, or read it in parts \
             with --host-memory",
            ByteSize(bytes)
        );
        return Err(Error::malformed(&path, "the picture", cause));
    }
    progress.set_length(placed.size().iter().map(|side| u64::from(*side)).product());
    Ok(placed.points(0..placed.size()[1], room as usize, progress))
}

/// A picture on the surface where its pixels are.
pub(crate) struct PlacedPicture {
    picture: Picture,
    surface: Surface,
}

impl fmt::Debug for PlacedPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PlacedPicture").field("size", &self.size()).finish_non_exhaustive()
    }
}

impl PlacedPicture {
    /// Decodes a picture and its height map.
    pub fn open(source: InputFile, photo: &Photo) -> Result<Self, Error> {
        let path = source.path.clone();
        let picture = Picture::read(source)?;
        let size = [picture.width, picture.height];
        let surface = match &photo.heights {
            None => Surface::flat(size, photo),
            Some(heights) => {
                let map = Picture::read(InputFile::open(&heights.path)?)?;
                Surface::new(size, photo, map.gray(), [map.width, map.height], heights.scale)
            }
        };
        let placed = Self { picture, surface };
        let expected = placed.expected_points();
        if !expected.is_finite() || expected > MAX_POINTS {
            let cause = format!(
                "so steep that the picture would become {expected:.1e} points, but {MAX_POINTS:.1e} is the most; a \
                 smaller height_scale or a smoother map would help"
            );
            return Err(Error::malformed(&path, "photo.heights", cause));
        }
        Ok(placed)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.picture.width, self.picture.height]
    }

    /// Returns the mean number of points over all fractions that are left to chance, if no pixel is transparent.
    pub fn expected_points(&self) -> f64 {
        self.surface.expected_points()
    }

    /// Bytes of a point in memory.
    fn point_bytes(&self) -> u64 {
        let alpha = if self.picture.has_alpha { size_of::<f32>() } else { 0 };
        (size_of::<DVec3>() + 2 * size_of::<Vec3>() + alpha) as u64
    }

    /// Returns the points of some rows, from the top. Colors are sRGB-decoded (float pictures hold linear ones), the
    /// alpha channel becomes the points' alpha, and pixels of alpha 0 are left out.
    pub fn points(&self, rows: Range<u32>, expected: usize, progress: &Progress) -> Cloud {
        let Self { picture, surface } = self;
        let mut positions = Vec::with_capacity(expected);
        let mut normals = Vec::with_capacity(expected);
        let mut colors = Vec::with_capacity(expected);
        let mut alphas = Vec::with_capacity(if picture.has_alpha { expected } else { 0 });
        for y in rows {
            for x in 0..picture.width {
                let (color, alpha) = picture.pixel(x, y);
                if alpha > 0.0 {
                    let copies = surface.copies(x, y) as usize;
                    positions.extend(std::iter::repeat_n(surface.position(x, y), copies));
                    normals.extend(std::iter::repeat_n(surface.normal(x, y), copies));
                    colors.extend(std::iter::repeat_n(color, copies));
                    alphas.extend(std::iter::repeat_n(alpha, if picture.has_alpha { copies } else { 0 }));
                }
            }
            progress.inc(u64::from(picture.width));
        }
        Cloud {
            positions,
            colors: Some(colors),
            alphas: picture.has_alpha.then_some(alphas),
            normals: Some(normals),
            up: UpAxis::Y,
            ..Cloud::default()
        }
    }
}
