//! Gaussians on the device: what they have beside the columns of all points.

use rayon::prelude::*;

use crate::cloud::gaussians::{Gaussians, coefficients};
use crate::gpu::{Buffer, Device, Error, Memory};

/// Shapes and colors of Gaussians, an element or more for each point of the cloud.
pub struct GaussianColumns {
    /// Standard deviations in world units, 0 of points that are none.
    pub extents: Buffer<[f32; 4]>,
    /// Unit quaternions, x y z w.
    pub rotations: Buffer<[f32; 4]>,
    /// Color without harmonics and coefficients from degree 1 on, [`Self::words`] for each.
    pub harmonics: Buffer<f32>,
    /// Degree of the harmonics.
    pub degree: u32,
    /// How many points are Gaussians.
    pub count: u64,
    /// True if every point is one.
    pub are_all: bool,
    /// The largest component that a display color may have, from whatever direction.
    pub brightest: f32,
}

/// Numbers of each splat's color of a degree.
pub(super) fn words(degree: u32) -> u64 {
    3 * (coefficients(degree) as u64 + 1)
}

impl GaussianColumns {
    /// Uploads those of a scene's points.
    pub(super) fn new(device: &Device, gaussians: &Gaussians) -> Result<Self, Error> {
        let count = gaussians.len() as u64;
        let columns = Self {
            extents: device.buffer("Gaussians, extents", count.max(1), Memory::Device)?,
            rotations: device.buffer("Gaussians, rotations", count.max(1), Memory::Device)?,
            harmonics: device.buffer(
                "Gaussians, harmonics",
                (count * words(gaussians.degree)).max(1),
                Memory::Device,
            )?,
            degree: gaussians.degree,
            count: (0..gaussians.len()).into_par_iter().filter(|i| gaussians.is_one(*i)).count() as u64,
            are_all: gaussians.are_all(),
            brightest: brightest(gaussians),
        };
        columns.upload(gaussians)?;
        Ok(columns)
    }

    /// Numbers of each splat's color.
    pub fn words(&self) -> u64 {
        words(self.degree)
    }

    /// Device bytes.
    pub fn bytes(&self) -> u64 {
        self.extents.bytes() + self.rotations.bytes() + self.harmonics.bytes()
    }

    /// Brings the columns of as many Gaussians of the same degree to the device.
    fn upload(&self, gaussians: &Gaussians) -> Result<(), Error> {
        let count = gaussians.len() as u64;
        self.extents.upload_by(count, |range, to| {
            let each = gaussians.extents[range].par_iter().zip(to);
            each.for_each(|(from, to)| *to = from.extend(0.0).to_array());
        })?;
        self.rotations.upload_by(count, |range, to| {
            gaussians.rotations[range].par_iter().zip(to).for_each(|(from, to)| *to = from.to_array());
        })?;
        let words = self.words() as usize;
        self.harmonics.upload_by(count * words as u64, |range, to| {
            let each = range.into_par_iter().with_min_len(1 << 12).zip(to);
            each.for_each(|(at, to)| *to = word(gaussians, at / words, at % words));
        })
    }
}

/// One of the numbers of a splat's color.
fn word(gaussians: &Gaussians, splat: usize, at: usize) -> f32 {
    let (coefficient, channel) = (at / 3, at % 3);
    match coefficient.checked_sub(1) {
        None => gaussians.bases[splat][channel],
        Some(k) => gaussians.harmonics_of(splat)[k][channel],
    }
}

/// A bound on each harmonic is its norm, √((2l + 1) / 4π) (addition theorem).
fn brightest(gaussians: &Gaussians) -> f32 {
    let norm = |k: usize| {
        let degree = ((k + 1) as f32).sqrt().floor();
        ((2.0 * degree + 1.0) / (4.0 * std::f32::consts::PI)).sqrt()
    };
    let norms: Vec<f32> = (0..gaussians.coefficients()).map(norm).collect();
    let most = |i: usize| {
        let all = gaussians.harmonics_of(i).iter().zip(&norms);
        all.fold(gaussians.bases[i], |sum, (color, norm)| sum + *norm * color.abs()).max_element()
    };
    (0..gaussians.len()).into_par_iter().map(most).reduce(|| 0.0, f32::max)
}
