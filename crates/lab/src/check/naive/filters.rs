//! Filters of an image without their precautions: background at an infinite depth, sums by the weights of the inner
//! pixels.

use pellucid_core::image::Image;

/// An image to filter; pixels outside count as background.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Premultiplied colors, row by row.
    pub rgba: Vec<[f32; 4]>,
    /// Depths, infinite for background.
    pub depth: Vec<f32>,
}

const BACKGROUND: ([f32; 4], f32) = ([0.0; 4], f32::INFINITY);

impl Filtered {
    /// Takes an image to which no filter was applied.
    pub fn new(image: &Image) -> Self {
        Self { size: [image.width, image.height], rgba: image.rgba.clone(), depth: image.depth.clone() }
    }

    fn at(&self, pixel: usize, right: i64, down: i64) -> ([f32; 4], f32) {
        let [width, height] = self.size.map(i64::from);
        let (x, y) = (pixel as i64 % width + right, pixel as i64 / width + down);
        let is_inside = x >= 0 && y >= 0 && x < width && y < height;
        if is_inside { (self.rgba[(y * width + x) as usize], self.depth[(y * width + x) as usize]) } else { BACKGROUND }
    }

    fn sum(&self, pixel: usize, weights: &[(i64, i64, f32)]) -> [f32; 4] {
        std::array::from_fn(|c| weights.iter().map(|(right, down, w)| w * self.at(pixel, *right, *down).0[c]).sum())
    }

    /// The weights 16, 2 and 1 of the smoothing filter over their sum, at the borders of the image as well.
    #[must_use]
    pub fn smoothed(&self) -> Self {
        let around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (right, down)));
        let weight =
            |(right, down): (i64, i64)| (right, down, [16.0, 2.0, 1.0][(right.abs() + down.abs()) as usize] / 28.0);
        let weights: Vec<_> = around.map(weight).collect();
        Self { rgba: (0..self.rgba.len()).map(|pixel| self.sum(pixel, &weights)).collect(), ..self.clone() }
    }

    /// The filter against aliasing with an infinity for the depth of background.
    #[must_use]
    pub fn antialiased(&self, distance: f32, threshold: f32) -> Self {
        let edges = [(0, -1, 0.25), (1, 0, 0.25), (0, 1, 0.25), (-1, 0, 0.25)];
        let soften = |pixel: usize| {
            let (own, z) = self.at(pixel, 0, 0);
            let around: f32 = edges.iter().map(|(right, down, _)| self.at(pixel, *right, *down).1).sum();
            let t = (4.0 * z - around).abs() / (4.0 * distance);
            if t < threshold {
                return own;
            }
            let t = if t > 1.0 { 1.0 } else { t };
            let mean = self.sum(pixel, &edges);
            std::array::from_fn(|c| (1.0 - 0.5 * t) * own[c] + 0.5 * t * mean[c])
        };
        Self { rgba: (0..self.rgba.len()).map(soften).collect(), ..self.clone() }
    }
}
