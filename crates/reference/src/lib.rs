//! The methods in float64 over slices, written from the equations; no device is involved.
//!
//! Nothing here is fast, nothing is shared with a shader: a method and its reference agree only if both are right.
//! Hand-worked cases in `tests/host/` check the references, the references check the device.

pub mod abuffer;
pub mod approximate;
pub mod coverage;
pub mod dealing;
pub mod edl;
pub mod field;
pub mod fragments;
pub mod gaussians;
pub mod image_space;
pub mod mlab;
pub mod moments;
pub mod one_layer;
pub mod opaque;
pub mod peel;
pub mod peel_layers;
pub mod range;
pub mod samples;
pub mod scan;
pub mod shading;
pub mod shadows;
pub mod soft;
pub mod sorted;
pub mod spbr;
pub mod splats;
pub mod stochastic;
pub mod wavelet;

use glam::{DVec2, DVec3};

use fragments::Composite;
use pellucid_core::camera::Camera;

/// A camera and the image that it makes.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Columns and rows of the image.
    pub size: [u32; 2],
}

impl<'a> View<'a> {
    /// Makes a view.
    pub fn new(camera: &'a Camera, size: [u32; 2]) -> Self {
        Self { camera, size }
    }

    /// Number of pixels.
    fn pixels(self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Returns a pixel's place in the image: row · width + column.
    fn index(self, x: u32, y: u32) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    /// Returns column and row of the pixel at this place.
    fn place(self, index: usize) -> [u32; 2] {
        let width = self.size[0] as usize;
        [(index % width) as u32, (index / width) as u32]
    }

    /// Returns where the viewing axis meets the image, in pixels from its upper left corner.
    fn middle(self) -> DVec2 {
        self.camera.middle(self.size)
    }

    /// Returns a position of the image, in pixels, on the plane at depth 1 (orthographic: at any depth), y up.
    fn on_plane(self, at_px: DVec2) -> DVec2 {
        (at_px - self.middle()) * DVec2::new(1.0, -1.0) / self.camera.focal_px(self.size[1])
    }

    /// Returns the pixels that a world unit takes at a depth.
    fn pixels_per_unit(self, z: f64) -> f64 {
        self.camera.pixels_per_unit(z, self.size[1])
    }
}

/// A picture, and the standard error of each pixel's color.
pub type WithErrors = (ReferencePicture, Vec<DVec3>);

/// A method's result in float64; the counterpart of [`pellucid_core::image::Image`].
#[derive(Debug, Clone, PartialEq)]
pub struct ReferencePicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Premultiplied R, G, B and A = 1 − T per pixel, row by row from the top.
    pub rgba: Vec<[f64; 4]>,
    /// z of the first fragment with α > 0, +inf if none has.
    pub depth: Vec<f64>,
    /// Fragments on each pixel, those with α = 0 included.
    pub counts: Vec<u32>,
}

impl ReferencePicture {
    /// Makes a picture of pixels, row by row from the top, each with its count.
    fn of(size: [u32; 2], pixels: impl IntoIterator<Item = (Composite, u32)>) -> Self {
        let [width, height] = size;
        let mut picture = Self { width, height, rgba: Vec::new(), depth: Vec::new(), counts: Vec::new() };
        for (pixel, count) in pixels {
            picture.rgba.push(pixel.color.extend(pixel.alpha).to_array());
            picture.depth.push(pixel.depth);
            picture.counts.push(count);
        }
        picture
    }

    /// Makes a picture of a list for each pixel.
    fn of_lists<T>(size: [u32; 2], lists: &[Vec<T>], pixel: impl Fn(&[T]) -> Composite) -> Self {
        Self::of(size, lists.iter().map(|list| (pixel(list), list.len() as u32)))
    }

    /// Returns the image over a background: C + (1 − A)·background.
    pub fn composed(&self, background: DVec3) -> Vec<DVec3> {
        self.rgba.iter().map(|&[r, g, b, a]| DVec3::new(r, g, b) + (1.0 - a) * background).collect()
    }
}
