//! The rendered image: linear, float32, before and after the background.

use glam::Vec3;

/// The largest number of pixels on a side of an image: the limit of framebuffers and of the packing of splats' pixels.
pub const MAX_SIDE: u32 = 16_384;

/// A method's result: premultiplied linear color without background, coverage and depth, row 0 at the top.
///
/// With `color = "encoded"` the colors are encoded (sRGB) values; the writer of the file decodes or encodes them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Premultiplied R, G, B and A = 1 − T per pixel, row by row; empty if they stayed on the device
    /// (`methods::Frame::outputs`).
    pub rgba: Vec<[f32; 4]>,
    /// R, G, B of an opaque PNG, and the pixel's [`Cover`] as a number, row by row, in place of `rgba`, if they were
    /// asked for: 8-bit sRGB over the frame's background.
    pub bytes: Option<Vec<[u8; 4]>>,
    /// z of the first fragment with α > 0, +inf if none has; empty if they were not asked for.
    pub depth: Vec<f32>,
    /// Depth of the fragment at which T first is a half or less, +inf where A < 1/2, if it was asked for (`--aov`), of
    /// methods whose images follow from sorted lists of all fragments.
    pub depth_median: Option<Vec<f32>>,
    /// Mean depth Σ zαT / A, with T before each fragment, +inf where A = 0; of the same methods, if it was asked for
    /// (`--aov`).
    pub depth_mean: Option<Vec<f32>>,
    /// Images whose mean this is, 0 or 1 for an ordinary one: counts are sums over them.
    pub samples: u32,
    /// Length of each pixel's fragment list, α = 0 included, if it was asked for (`--aov`).
    pub fragments: Option<Vec<u32>>,
    /// Layers that were blended on each pixel, of methods that peel, if they were asked for (`--aov`).
    pub layers: Option<Vec<u32>>,
    /// Standard error of the composed R, G and B of stochastic methods, without the background's share, if it was asked
    /// for (`--aov`).
    pub stderr: Option<Vec<[f32; 3]>>,
}

/// A or T below which a pixel looks empty or opaque.
pub const HARDLY: f32 = 0.01;

/// Share of a pixel that is covered, as far as it can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cover {
    /// A = 0: nothing is there.
    Nothing = 0,
    /// A is below [`HARDLY`].
    Hardly = 1,
    /// A is in between.
    Partly = 2,
    /// T is below [`HARDLY`].
    Fully = 3,
}

impl Cover {
    /// Returns the cover of a pixel by its A; NaN is nothing.
    pub fn of(alpha: f32) -> Self {
        if alpha > 1.0 - HARDLY {
            Self::Fully
        } else if alpha >= HARDLY {
            Self::Partly
        } else if alpha > 0.0 {
            Self::Hardly
        } else {
            Self::Nothing
        }
    }

    /// Returns the cover that a number stands for; numbers above 3 are [`Self::Fully`].
    fn from_number(number: u8) -> Self {
        [Self::Nothing, Self::Hardly, Self::Partly].get(usize::from(number)).copied().unwrap_or(Self::Fully)
    }
}

impl Image {
    /// Returns `true` if the colors came to the host as floats.
    pub fn has_colors(&self) -> bool {
        self.rgba.len() as u64 == u64::from(self.width) * u64::from(self.height)
    }

    /// Returns the bytes of a pixel's color and depth that came to the host.
    pub fn pixel_bytes(&self) -> u64 {
        let each = |there: bool, bytes| if there { bytes } else { 0 };
        each(!self.rgba.is_empty(), 16) + each(self.bytes.is_some(), 4) + each(!self.depth.is_empty(), 4)
    }

    /// Returns the cover of each pixel, whatever form the colors have; nothing if none came to the host.
    pub fn covers(&self) -> impl Iterator<Item = Cover> {
        let bytes = self.bytes.iter().flatten().map(|pixel| Cover::from_number(pixel[3]));
        self.rgba.iter().map(|pixel| Cover::of(pixel[3])).chain(bytes)
    }

    /// Returns `true` if the image shows nothing.
    pub fn is_empty(&self) -> bool {
        self.covers().all(|cover| cover == Cover::Nothing)
    }

    /// Returns counts per image: their means over the images whose mean this is.
    pub fn mean_counts(&self, counts: &[u32]) -> Vec<f32> {
        let samples = f64::from(self.samples.max(1));
        counts.iter().map(|count| (f64::from(*count) / samples) as f32).collect()
    }

    /// Returns the standard error of the whole image, if that of its pixels was found: root mean square over pixels and
    /// R, G, B.
    pub fn standard_error(&self) -> Option<f64> {
        self.stderr.as_deref().map(|errors| mean_square(errors).sqrt())
    }

    /// Returns the image over a background: C + (1 − A)·background.
    pub fn composed(&self, background: Vec3) -> Vec<[f32; 3]> {
        self.rgba.iter().map(|pixel| Self::over(*pixel, background)).collect()
    }

    /// Returns a premultiplied pixel over a background.
    pub fn over([r, g, b, a]: [f32; 4], background: Vec3) -> [f32; 3] {
        (Vec3::new(r, g, b) + (1.0 - a) * background).to_array()
    }
}

/// Linear RGB, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Pixels, an entry each, width × height of them.
    pub pixels: Vec<[f32; 3]>,
}

/// Returns the mean of the squares of all values; 0 if empty.
pub fn mean_square(values: &[[f32; 3]]) -> f64 {
    let squares: f64 = values.iter().flatten().map(|value| f64::from(*value).powi(2)).sum();
    squares / (values.len().max(1) * 3) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cover_tells_nothing_hardly_partly_and_fully_apart() {
        let next = |value: f32| f32::from_bits(value.to_bits() + 1);
        let before = |value: f32| f32::from_bits(value.to_bits() - 1);
        let alphas = [0.0, -0.0, -1.0, f32::NAN, 1e-45, before(HARDLY), HARDLY, 0.5, 0.99, next(0.99), 1.0, 2.0];
        let numbers = alphas.map(|alpha| Cover::of(alpha) as u8);
        assert_eq!(numbers, [0, 0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 3]);
        assert!((0..4).all(|number| Cover::from_number(number) as u8 == number));
    }

    #[test]
    fn covers_are_those_of_floats_or_bytes() {
        let floats = Image { width: 2, height: 1, rgba: vec![[0.0; 4], [0.0, 0.0, 0.0, 0.5]], ..Image::default() };
        let bytes = Image { width: 2, height: 1, bytes: Some(vec![[9, 9, 9, 0], [9, 9, 9, 2]]), ..Image::default() };
        for (image, pixel) in [(floats, 16), (bytes, 4)] {
            assert_eq!(image.covers().collect::<Vec<_>>(), [Cover::Nothing, Cover::Partly]);
            assert!(!image.is_empty());
            assert_eq!((image.pixel_bytes(), image.has_colors()), (pixel, pixel == 16));
        }
        let nothing = Image { width: 1, height: 1, bytes: Some(vec![[9, 9, 9, 0]]), ..Image::default() };
        assert!(nothing.is_empty());
    }
}
