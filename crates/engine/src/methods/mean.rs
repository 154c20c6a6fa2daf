//! The picture of several samples per pixel: the mean of ordinary images, each moved by a fraction of a pixel.
//!
//! Sample i of N lies at x = (i + ½)/N, y = v(i) + 1/(2N) of its pixel, v the radical inverse of i in base 2: N points
//! of which each column and each row of N × N cells has one (Hammersley). Image i is that of the same scene with every
//! projected position moved by (½ − x, ½ − y) pixels, so that the centers of its pixels are these samples.

use std::cmp::Ordering;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::Frame;
use crate::color::{ColorSpace, decode_srgb, encode_srgb};
use crate::image::Image;
use crate::passes::bands::Window;

/// The numbers of samples that a frame may have.
pub const SAMPLES: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Returns the pixels by which image `index` of `count` is moved: multiples of 1/128, within half a pixel.
pub(super) fn shift(index: u32, count: u32) -> DVec2 {
    let of = f64::from(count);
    let inverse = f64::from(index.reverse_bits()) / f64::from(1u32 << 31) / 2.0;
    DVec2::new(0.5 - (f64::from(index) + 0.5) / of, 0.5 - (inverse + 0.5 / of))
}

impl Frame {
    /// Returns the frame of one of the images whose mean is this frame's.
    #[must_use]
    pub fn image(&self, index: u32) -> Self {
        let camera = crate::camera::Camera { shift: shift(index, self.samples), ..self.camera };
        Self { camera, only: Some(index), ..*self }
    }

    /// Returns the frames of all images, that whose depths the picture has last: number N/2.
    pub fn images(&self) -> Vec<Self> {
        if self.samples == 1 || self.only.is_some() {
            return vec![*self];
        }
        let middle = self.samples / 2;
        let others = (0..self.samples).filter(|index| *index != middle);
        others.chain([middle]).map(|index| self.image(index)).collect()
    }

    /// Returns the place of the image among those of [`Self::images`]: how many are drawn before.
    pub(super) fn turn(&self) -> u32 {
        let (number, middle) = (self.number(), self.samples / 2);
        match number.cmp(&middle) {
            Ordering::Less => number,
            Ordering::Equal => self.samples - 1,
            Ordering::Greater => number - 1,
        }
    }

    /// Returns the number of the image: each draws random numbers of its own.
    pub(super) fn number(&self) -> u32 {
        self.only.unwrap_or(0)
    }

    /// Returns `true` if the picture is a mean of several images.
    pub fn is_mean(&self) -> bool {
        self.samples > 1 && self.only.is_none()
    }
}

/// Sums over the images of a frame: of colors in linear light, as the picture shows them, of counts, and of squared
/// standard errors. Every pixel sums its images in their order, wherever windows are cut.
pub struct Mean {
    samples: u32,
    /// The encoded background, where colors are blended as encoded values.
    encoded: Option<Vec3>,
    colors: Vec<[f64; 4]>,
    fragments: Vec<u32>,
    layers: Vec<u32>,
    variances: Vec<[f64; 3]>,
}

/// Bytes of a pixel's sums, without counts and errors.
pub(super) const PIXEL_BYTES: u64 = 32;

impl Mean {
    /// Returns the sums of no image.
    pub fn new(frame: &Frame, image: &Image) -> Self {
        let encoded = (frame.color == ColorSpace::Encoded)
            .then(|| Vec3::from_array(frame.background.to_array().map(encode_srgb)));
        Self {
            samples: frame.samples,
            encoded,
            colors: vec![[0.0; 4]; image.depth.len()],
            fragments: vec![0; image.fragments.as_ref().map_or(0, Vec::len)],
            layers: vec![0; image.layers.as_ref().map_or(0, Vec::len)],
            variances: vec![[0.0; 3]; image.stderr.as_ref().map_or(0, Vec::len)],
        }
    }

    /// Adds a window of an image; the `first` one replaces what was there.
    pub fn add(&mut self, image: &Image, window: Window, first: bool) {
        let [x0, y0, x1, y1] = window.map(|v| v as usize);
        let pitch = image.width as usize;
        let (at, encoded) = (|row: usize| row * pitch + x0..row * pitch + x1, self.encoded);
        let rows = |from: usize| from * pitch..y1 * pitch;
        self.colors[rows(y0)].par_chunks_mut(pitch).zip(image.rgba[rows(y0)].par_chunks(pitch)).for_each(
            |(to, from)| {
                for (to, from) in to[x0..x1].iter_mut().zip(&from[x0..x1]) {
                    let from = encoded.map_or(*from, |background| shown(*from, background));
                    *to = std::array::from_fn(|c| if first { 0.0 } else { to[c] } + f64::from(from[c]));
                }
            },
        );
        for row in y0..y1 {
            let counts = [(&mut self.fragments, &image.fragments), (&mut self.layers, &image.layers)];
            for (to, from) in counts.into_iter().filter_map(|(to, from)| Some((to, from.as_ref()?))) {
                let sums = to[at(row)].iter_mut().zip(&from[at(row)]);
                sums.for_each(|(to, from)| *to = if first { 0 } else { *to } + from);
            }
            if let Some(errors) = &image.stderr {
                for (to, error) in self.variances[at(row)].iter_mut().zip(&errors[at(row)]) {
                    *to = std::array::from_fn(|c| if first { 0.0 } else { to[c] } + f64::from(error[c]).powi(2));
                }
            }
        }
    }

    /// Gives an image, the last one that was added, the means. Its depths stay, and of counts it gets the sums.
    pub fn finish(self, image: &mut Image) {
        let (count, encoded) = (f64::from(self.samples), self.encoded);
        image.rgba.par_iter_mut().zip(self.colors).for_each(|(to, sum)| {
            let mean = sum.map(|v| (v / count) as f32);
            *to = encoded.map_or(mean, |background| unshown(mean, background));
        });
        image.samples = self.samples;
        image.fragments.iter_mut().for_each(|to| to.copy_from_slice(&self.fragments));
        image.layers.iter_mut().for_each(|to| to.copy_from_slice(&self.layers));
        for (to, sum) in image.stderr.iter_mut().flatten().zip(self.variances) {
            *to = sum.map(|variance| (variance.sqrt() / count) as f32);
        }
    }
}

/// Returns the linear color that encoded values show over a background, and A.
fn shown(pixel: [f32; 4], background: Vec3) -> [f32; 4] {
    let [r, g, b] = Image::over(pixel, background).map(decode_srgb);
    [r, g, b, pixel[3]]
}

/// Returns the encoded values, premultiplied, that show a linear color over a background.
fn unshown([r, g, b, a]: [f32; 4], background: Vec3) -> [f32; 4] {
    let [r, g, b] = (Vec3::from_array([r, g, b].map(encode_srgb)) - (1.0 - a) * background).to_array();
    [r, g, b, a]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radical inverses of 0 to 3 in base 2: 0, ½, ¼, ¾.
    #[test]
    fn samples_of_a_pixel_are_those_of_hammersley() {
        let of = |count: u32| (0..count).map(|i| (DVec2::splat(0.5) - shift(i, count)).to_array()).collect::<Vec<_>>();
        assert_eq!(of(1), [[0.5, 0.5]]);
        assert_eq!(of(2), [[0.25, 0.25], [0.75, 0.75]]);
        assert_eq!(of(4), [[0.125, 0.125], [0.375, 0.625], [0.625, 0.375], [0.875, 0.875]]);
    }

    #[test]
    fn each_row_and_column_of_cells_has_one_sample() {
        for count in SAMPLES {
            for axis in 0..2 {
                let cells = (0..count).map(|i| ((0.5 - shift(i, count)[axis]) * f64::from(count)) as u32);
                let mut cells: Vec<u32> = cells.collect();
                cells.sort_unstable();
                assert!(cells.iter().copied().eq(0..count), "{count}");
            }
        }
    }
}
