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
    /// (`methods::Renderer::host_colors`).
    pub rgba: Vec<[f32; 4]>,
    /// z of the first fragment with α > 0, +inf if none has.
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

impl Image {
    /// Returns `true` if the colors came to the host.
    pub fn has_colors(&self) -> bool {
        self.rgba.len() == self.depth.len()
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
