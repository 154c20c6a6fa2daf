//! Gaussians on the device: what they have beside the columns of all points.

use super::empty;
use crate::cloud::gaussians::{Gaussians, MAX_DEGREE, coefficients};
use crate::gpu::{Buffer, Device, Error, Memory};
use crate::points::{Points, WholeSplats};
use pellucid_core::parallel;

const EXTENTS: &str = "Gaussians, extents";
const ROTATIONS: &str = "Gaussians, rotations";
const HARMONICS: &str = "Gaussians, harmonics";

/// Shapes and colors of Gaussians, an element or more for each point of the cloud.
pub struct GaussianColumns {
    /// Standard deviations in world units, 0 of points that are none; the last number is 1 if colors are linear.
    pub extents: Buffer<[f32; 4]>,
    /// Unit quaternions, x y z w.
    pub rotations: Buffer<[f32; 4]>,
    /// Color without harmonics and coefficients from degree 1 on, [`Self::words`] for each.
    pub harmonics: Buffer<f32>,
    /// Degree of the harmonics.
    pub degree: u32,
    /// Number of points of the scene that are Gaussians.
    pub count: u64,
    /// `true` if every point on the device is one.
    pub are_all: bool,
    /// The largest component that a display color may have, from whatever direction.
    pub brightest: f32,
}

/// Returns how many numbers make up each splat's color of a degree.
pub(super) fn words(degree: u32) -> u64 {
    3 * (coefficients(degree) as u64 + 1)
}

impl GaussianColumns {
    /// Uploads those of a scene's points.
    pub(super) fn new(device: &Device, gaussians: &Gaussians) -> Result<Self, Error> {
        let brightest = gaussians.brightest()[MAX_DEGREE as usize];
        let mut columns =
            Self::empty(device, WholeSplats { count: gaussians.count(), degree: gaussians.degree, brightest })?;
        columns.make(device, gaussians.len() as u64)?;
        columns.are_all = gaussians.are_all();
        columns.upload(gaussians)?;
        Ok(columns)
    }

    /// Columns of a scene's points before any of them is on the device.
    pub(super) fn empty(device: &Device, splats: WholeSplats) -> Result<Self, Error> {
        Ok(Self {
            extents: empty(device, EXTENTS)?,
            rotations: empty(device, ROTATIONS)?,
            harmonics: empty(device, HARMONICS)?,
            degree: splats.degree,
            count: splats.count,
            are_all: false,
            brightest: splats.brightest,
        })
    }

    /// Makes room for so many points, unless there is.
    fn make(&mut self, device: &Device, count: u64) -> Result<(), Error> {
        let count = count.max(1);
        if self.extents.len() < count {
            // Old buffers are freed first: old and new ones may not fit together.
            self.extents = empty(device, EXTENTS)?;
            self.rotations = empty(device, ROTATIONS)?;
            self.harmonics = empty(device, HARMONICS)?;
            self.extents = device.buffer(EXTENTS, count, Memory::Device)?;
            self.rotations = device.buffer(ROTATIONS, count, Memory::Device)?;
            self.harmonics = device.buffer(HARMONICS, count * self.words(), Memory::Device)?;
        }
        Ok(())
    }

    /// Puts the columns of points on the device in place of those that are there. Those of a part of a scene may have a
    /// lower degree, or no Gaussian among them.
    pub(super) fn put(&mut self, device: &Device, points: &Points) -> Result<(), Error> {
        let none = || Gaussians::none(points.len()).with_degree(self.degree);
        let wider = points.gaussians.as_ref().filter(|own| own.degree != self.degree);
        let made = match &points.gaussians {
            None => Some(none()),
            Some(_) => wider.map(|own| own.clone().with_degree(self.degree)),
        };
        let Some(all) = made.as_ref().or(points.gaussians.as_ref()) else { return Ok(()) };
        self.make(device, all.len() as u64)?;
        self.are_all = all.are_all();
        self.upload(all)
    }

    /// Returns the number of device bytes of each point in these columns.
    pub fn bytes_each(&self) -> u64 {
        2 * size_of::<[f32; 4]>() as u64 + 4 * self.words()
    }

    /// Returns how many numbers make up each splat's color.
    pub fn words(&self) -> u64 {
        words(self.degree)
    }

    /// Returns device bytes.
    pub fn bytes(&self) -> u64 {
        self.extents.bytes() + self.rotations.bytes() + self.harmonics.bytes()
    }

    /// Brings the columns of as many Gaussians of the same degree to the device.
    fn upload(&self, gaussians: &Gaussians) -> Result<(), Error> {
        let count = gaussians.len() as u64;
        let linear = |splat: usize| f32::from(u8::from(gaussians.is_linear(splat)));
        self.extents.upload_by(count, |range, to| {
            let (first, from) = (range.start, &gaussians.extents[range]);
            parallel::for_each_mut(to, |i, to| *to = from[i].extend(linear(first + i)).to_array());
        })?;
        self.rotations.upload_by(count, |range, to| {
            let from = &gaussians.rotations[range];
            parallel::for_each_mut(to, |i, to| *to = from[i].to_array());
        })?;
        let words = self.words() as usize;
        self.harmonics.upload_by(count * words as u64, |range, to| {
            parallel::for_each_mut(to, |i, to| {
                let at = range.start + i;
                *to = word(gaussians, at / words, at % words);
            });
        })
    }
}

/// Returns a number of a splat's color: coefficient `at` / 3 of channel `at` % 3.
fn word(gaussians: &Gaussians, splat: usize, at: usize) -> f32 {
    let (coefficient, channel) = (at / 3, at % 3);
    match coefficient.checked_sub(1) {
        None => gaussians.bases[splat][channel],
        Some(k) => gaussians.harmonics_of(splat)[k][channel],
    }
}
