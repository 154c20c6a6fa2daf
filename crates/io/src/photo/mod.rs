//! Pictures as clouds (Tanaka et al. 2016, Section 4.5). Each pixel is a point of a plane, displaced along the plane's
//! normal by a height map, and copied where the surface is so steep that its points would be too far apart.

mod directory;
mod picture;
mod surface;

use std::path::{Path, PathBuf};

use glam::DVec3;
use pellucid_core::progress::Progress;

use super::{Error, InputFile};
use pellucid_core::cloud::{Cloud, UpAxis};
use picture::Picture;
use surface::Surface;

/// Pixels of a picture at most, and points that it may become: 2²⁸.
pub const MAX_PIXELS: u64 = 1 << 28;

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

/// Reads a picture. Colors are sRGB-decoded (float pictures hold linear ones), the alpha channel becomes the points'
/// alpha, and pixels of alpha 0 are left out.
pub(super) fn read(source: InputFile, photo: &Photo, progress: &Progress) -> Result<Cloud, Error> {
    let path = source.path.clone();
    let picture = Picture::read(source)?;
    let size = [picture.width, picture.height];
    let surface = match &photo.heights {
        None => Surface::flat(size, photo),
        Some(heights) => {
            let map = Picture::read(InputFile::open(&heights.path)?)?;
            Surface::new(size, photo, &map.gray(), [map.width, map.height], heights.scale)
        }
    };
    let copies = surface.expected_points();
    if !copies.is_finite() || copies > MAX_PIXELS as f64 {
        let cause = format!(
            "so steep that the picture would become {copies:.1e} points, but {MAX_PIXELS} is the most; \
             a smaller height_scale or a smoother map would help"
        );
        return Err(Error::malformed(&path, "photo.heights", cause));
    }
    points(&path, &picture, &surface, copies, progress)
}

fn points(
    path: &Path,
    picture: &Picture,
    surface: &Surface,
    expected: f64,
    progress: &Progress,
) -> Result<Cloud, Error> {
    // The number of copies is random; its spread is below half of its root, and growing further is no harm.
    let room = expected as usize + expected.sqrt() as usize + 1;
    progress.set_length(u64::from(picture.width) * u64::from(picture.height));
    let columns =
        || Some((column(room)?, column(room)?, column(room)?, column(if picture.has_alpha { room } else { 0 })?));
    let (mut positions, mut normals, mut colors, mut alphas) = columns().ok_or_else(|| {
        let cause = format!("there is not enough memory for its {room} points; scale the picture down");
        Error::malformed(path, "the picture", cause)
    })?;
    for y in 0..picture.height {
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
    Ok(Cloud {
        positions,
        colors: Some(colors),
        alphas: picture.has_alpha.then_some(alphas),
        normals: Some(normals),
        up: UpAxis::Y,
        ..Cloud::default()
    })
}

/// A column with room for so many values; `None` if memory is insufficient.
fn column<T>(values: usize) -> Option<Vec<T>> {
    let mut column = Vec::new();
    column.try_reserve_exact(values).ok().map(|()| column)
}
