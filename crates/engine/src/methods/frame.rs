//! A frame: camera, size, method and what else decides an image of an uploaded cloud.

use glam::Vec3;

use super::engine::Fragments;
use super::{Error, Outputs, SAMPLES, Stop, engine_of};
use crate::camera::Camera;
use crate::image::MAX_SIDE;
use crate::scene::{ColorSpace, Detail, Kernel, Method, Order, Scene, Shading, Shadows};

/// The settings for rendering an uploaded cloud.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Frame {
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels, each 1 to 16384.
    pub size: [u32; 2],
    /// Shading of points with normals.
    pub shading: Shading,
    /// Shadows of the light, of methods that take some ([`Method::takes_shadows`]) where shading has a light that casts
    /// them.
    pub shadows: Option<Shadows>,
    /// The color space of blending.
    pub color: ColorSpace,
    /// Linear RGB behind the picture. It counts in means of encoded images, which are means of what they show, and in
    /// [`Colors::Bytes`](super::Colors::Bytes).
    pub background: Vec3,
    /// The method.
    pub method: Method,
    /// Selection of the points that are drawn, of clouds whose points come some at a time; dealt ones are all drawn.
    pub detail: Detail,
    /// Limit on device bytes beside cloud and image; `None` allows the device's memory minus a reserve. A dealt cloud
    /// that exceeds the limit is streamed: only the part on the device at a time counts.
    pub memory_budget: Option<u64>,
    /// Parts of the image that come to the host.
    pub outputs: Outputs,
    /// `true` if the image carries the length of each pixel's list, and its number of peeled layers.
    pub fragments: bool,
    /// `true` if the image carries median and mean depths, of methods whose images follow from sorted lists of all
    /// fragments. They take further passes: each of the two as many as such an image by `abuffer` or `linked-list`.
    pub depths: bool,
    /// The allowed omissions, none of them visible.
    pub stop: Stop,
    /// Seed of stochastic methods.
    pub seed: u64,
    /// Standard error of the whole image (root mean square over pixels and R, G, B) at which stochastic methods may do
    /// with fewer samples than their settings say.
    pub max_error: Option<f32>,
    /// `true` if stochastic methods compute their standard error in any case.
    pub spread: bool,
    /// Draws only this many of L ensembles, at least 1, each with the points that dealing to L gives it; `None` draws
    /// all.
    pub ensembles: Option<u32>,
    /// Factors on the uploaded radii and opacities.
    pub factors: Factors,
    /// Samples of a pixel's area, one of [`SAMPLES`]: the picture is the mean of so many images, each moved by a
    /// fraction of a pixel; depths are those of number N/2. 1: the image itself, of which each pixel shows its center.
    pub samples: u32,
    /// The one of these images that is drawn ([`Self::image`]); `None` draws their mean.
    pub only: Option<u32>,
    /// The four of them that a renderer draws at once, by their number among all fours: the size is then twice that of
    /// the picture, of which each pixel has four quarters.
    #[doc(hidden)]
    pub four: Option<u32>,
}

/// Factors on the uploaded values, so that another radius or opacity needs no upload.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Factors {
    /// Factor on all radii, at least 0; on the median radius too, so that the soft methods keep their peak opacity.
    pub radius: f32,
    /// Factor on all opacities, at least 0; the product is at most 1. The soft methods have `softness` instead.
    pub opacity: f32,
}

impl Default for Factors {
    fn default() -> Self {
        Self { radius: 1.0, opacity: 1.0 }
    }
}

impl Frame {
    /// Returns a frame of unshaded points in linear light: everything exact, all available memory, seed 0.
    pub fn new(camera: Camera, size: [u32; 2], method: Method) -> Self {
        Self {
            camera,
            size,
            shading: Shading::NONE,
            shadows: None,
            color: ColorSpace::Linear,
            background: Vec3::ZERO,
            method,
            detail: Detail::default(),
            memory_budget: None,
            outputs: Outputs::default(),
            fragments: false,
            depths: false,
            stop: Stop::Exact,
            seed: 0,
            max_error: None,
            spread: false,
            ensembles: None,
            factors: Factors::default(),
            samples: 1,
            only: None,
            four: None,
        }
    }

    /// Returns a frame of a scene by a camera and a seed, to the last bit, with all available memory. `auto` becomes
    /// the A-buffer; [`crate::plan::choose`] finds the method that suits the points.
    pub fn of_scene(scene: &Scene, camera: Camera, seed: u64) -> Self {
        Self {
            shading: scene.shading,
            shadows: scene.shadows,
            color: scene.image.color_space(),
            background: scene.image.background.color(),
            samples: scene.image.samples.count(),
            detail: scene.detail,
            seed,
            ..Self::new(camera, scene.image.size, scene.method.representative())
        }
    }

    /// Returns `true` if methods that draw random samples compute their standard error.
    pub(super) fn wants_spread(&self) -> bool {
        self.fragments || self.spread || self.max_error.is_some()
    }

    /// Returns `true` if list lengths need passes of their own, because the images of its method don't use them.
    pub fn counts_on_demand(&self) -> bool {
        engine_of(&self.method).channels().fragments == Fragments::Beside
    }

    /// Near and far, as the device compares depths with them.
    pub fn depth_range(&self) -> [f32; 2] {
        [self.camera.near as f32, self.camera.far as f32]
    }

    /// Between which numbers lies what splats are ordered by: their depths, or of Gaussians distances, which may be
    /// farther.
    pub fn key_range(&self) -> [f32; 2] {
        let [near, far] = self.depth_range();
        if self.method.order() == Order::Distance { [near, f32::MAX] } else { [near, far] }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let [width, height] = self.size;
        let allowed = 1..=MAX_SIDE;
        if !(allowed.contains(&width) && allowed.contains(&height)) {
            return Err(Error::ImageSize { width, height });
        }
        if !SAMPLES.contains(&self.samples) || self.only.is_some_and(|index| index >= self.samples) {
            return Err(Error::PixelSamples { samples: self.samples });
        }
        if self.shading.edl.edl && !self.method.takes_edl() {
            return Err(Error::NoSurfaceDepth { method: self.method.name() });
        }
        let takes_ellipsoids = matches!(self.method, Method::ABuffer(_) | Method::LinkedList(_));
        let kernel = self.method.discs().map(|discs| discs.gaussians.kernel);
        if kernel == Some(Kernel::Ellipsoid) && !takes_ellipsoids {
            return Err(Error::NoEllipsoids { method: self.method.name() });
        }
        if matches!(self.method, Method::Sorted(_)) && self.method.order() == Order::Pixel {
            return Err(Error::OneOrder);
        }
        Ok(())
    }
}
