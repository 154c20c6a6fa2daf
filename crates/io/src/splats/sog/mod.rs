//! SOG 2, by PlayCanvas: lossless WebP pictures whose pixels are splats, and `meta.json` that says what the pixels
//! mean.
//!
//! The files lie in a ZIP archive or in a folder. Positions have 16 bits in two pictures and are logarithmic;
//! quaternions have three bytes and the place of the largest; extents, colors and harmonics are numbers of tables;
//! harmonics also share a palette.

mod files;
mod meta;
mod picture;

use std::f64::consts::SQRT_2;
use std::path::Path;

use glam::{DQuat, DVec3, Vec3};

use super::{Splat, Splats, from_coefficient, quaternion};
use crate::{Error, InputFile};
use files::Files;
use meta::{Codebook, Meta};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use picture::Pixels;

/// First bytes of a ZIP archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// The file that says what the pictures mean.
pub(crate) const META: &str = "meta.json";

/// Entries of a row of the palette of harmonics.
const PALETTE_ROW: usize = 64;

/// Returns `true` for a folder with the file that describes pictures.
pub(crate) fn is_folder(path: &Path) -> bool {
    path.is_dir() && path.join(META).is_file()
}

/// Reads an archive, or the `meta.json` of a folder.
pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let files = Files::open(source)?;
    let meta = Meta::read(&files)?;
    let pictures = Pictures::read(&files, &meta)?;
    let splats = Splats::gather(meta.count as usize, meta.degree(), progress, |at, harmonics| {
        pictures.harmonics(at, harmonics);
        pictures.splat(at)
    });
    let mut cloud = splats.finish(UpAxis::NegativeY);
    cloud.filter = meta.filter();
    Ok(cloud)
}

/// All pixels, with what turns them into numbers.
struct Pictures<'a> {
    meta: &'a Meta,
    /// Low and high bytes of the positions.
    means: [Pixels; 2],
    scales: Pixels,
    quats: Pixels,
    sh0: Pixels,
    palette: Option<Palette<'a>>,
}

/// Harmonics of the splats.
struct Palette<'a> {
    table: &'a Codebook,
    centroids: Pixels,
    labels: Pixels,
    coefficients: usize,
}

impl<'a> Pictures<'a> {
    fn read(files: &Files, meta: &'a Meta) -> Result<Self, Error> {
        let picture = |name: &str| picture::read(files, name, meta.count);
        let [low, high] = &meta.means.files;
        Ok(Self {
            means: [picture(low)?, picture(high)?],
            scales: picture(&meta.scales.files[0])?,
            quats: picture(&meta.quats.files[0])?,
            sh0: picture(&meta.sh0.files[0])?,
            palette: Palette::read(files, meta)?,
            meta,
        })
    }

    fn splat(&self, at: usize) -> Splat {
        let (low, high) = (self.means[0].at(at), self.means[1].at(at));
        let axis = |axis: usize| {
            let (least, most) = (self.meta.means.mins[axis], self.meta.means.maxs[axis]);
            // As the format's own writer has it where all positions are alike.
            let range = if most == least { 1.0 } else { most - least };
            let logarithm = least + range * f64::from(u16::from_le_bytes([low[axis], high[axis]])) / 65535.0;
            logarithm.abs().exp_m1().copysign(logarithm)
        };
        let ([sx, sy, sz, _], [red, green, blue, alpha]) = (self.scales.at(at), self.sh0.at(at));
        let (scale, color) = (&self.meta.scales.codebook, &self.meta.sh0.codebook);
        Splat {
            // The numbers of which these are roundings were float32.
            center: DVec3::new(axis(0), axis(1), axis(2)).as_vec3().as_dvec3(),
            extents: DVec3::new(scale.number(sx).exp(), scale.number(sy).exp(), scale.number(sz).exp()),
            rotation: rotation(self.quats.at(at)),
            base: from_coefficient(DVec3::new(color.number(red), color.number(green), color.number(blue))),
            linear: false,
            alpha: f64::from(alpha) / 255.0,
        }
    }

    fn harmonics(&self, at: usize, harmonics: &mut [Vec3]) {
        if let Some(palette) = &self.palette {
            for (coefficient, color) in harmonics.iter_mut().enumerate() {
                let [red, green, blue, _] = palette.centroids.at(palette.place(at, coefficient));
                *color = Vec3::from([red, green, blue].map(|byte| palette.table.number(byte) as f32));
            }
        }
    }
}

impl<'a> Palette<'a> {
    fn read(files: &Files, meta: &'a Meta) -> Result<Option<Self>, Error> {
        let Some(harmonics) = meta.harmonics.as_ref().filter(|_| meta.degree() > 0) else { return Ok(None) };
        let [centroids, labels] = &harmonics.files;
        let coefficients = meta.coefficients();
        let rows = u64::from(harmonics.count).div_ceil(PALETTE_ROW as u64);
        let [width, height] = [(PALETTE_ROW * coefficients) as u64, rows];
        let palette = Self {
            table: &harmonics.codebook,
            centroids: picture::read_sized(files, centroids, [width, height])?,
            labels: picture::read(files, labels, meta.count)?,
            coefficients,
        };
        let beyond = (0..meta.count as usize).find(|at| palette.label(*at) >= harmonics.count as usize);
        match beyond {
            Some(at) => {
                let cause =
                    format!("splat {at} refers to entry {} of a palette of {}", palette.label(at), harmonics.count);
                Err(files.malformed(labels, cause))
            }
            None => Ok(Some(palette)),
        }
    }

    /// The entry of a splat.
    fn label(&self, at: usize) -> usize {
        let [low, high, ..] = self.labels.at(at);
        u16::from_le_bytes([low, high]).into()
    }

    /// The pixel of a coefficient of a splat.
    fn place(&self, at: usize, coefficient: usize) -> usize {
        let label = self.label(at);
        let (row, column) = (label / PALETTE_ROW, label % PALETTE_ROW);
        (row * PALETTE_ROW + column) * self.coefficients + coefficient
    }
}

/// The quaternion of a pixel: alpha tells which of w, x, y and z is the largest, from 252 on. Other values of alpha
/// mean none.
fn rotation([a, b, c, largest]: [u8; 4]) -> DQuat {
    let parts = [a, b, c].map(|byte| (f64::from(byte) / 255.0 * 2.0 - 1.0) / SQRT_2);
    largest.checked_sub(252).map_or(DQuat::from_array([0.0; 4]), |largest| quaternion(largest.into(), parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternions_of_pixels() {
        let near = |pixel, expected: [f64; 4]| {
            let found = rotation(pixel).to_array();
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 5e-3, "{pixel:?}: {found:?}");
        };
        near([128, 128, 128, 252], [0.0, 0.0, 0.0, 1.0]);
        near([255, 128, 128, 253], [0.707, 0.0, 0.0, 0.707]);
        near([128, 0, 128, 254], [-0.707, 0.707, 0.0, 0.0]);
        near([128, 128, 0, 255], [0.0, -0.707, 0.707, 0.0]);
        assert_eq!(rotation([1, 2, 3, 251]).to_array(), [0.0; 4]);
    }
}
