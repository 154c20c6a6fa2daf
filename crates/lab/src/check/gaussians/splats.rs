//! Gaussians of a case, and the view of them.

use glam::{Mat3, Quat};

use crate::check::prelude::*;
use pellucid_core::cloud::gaussians::{Gaussians, REACH, coefficients};
use pellucid_scene::prepare::order;

/// A Gaussian of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Splat {
    /// World position of its center.
    pub position: DVec3,
    /// Standard deviations along its axes.
    pub extents: Vec3,
    /// Turns x, y and z into these axes.
    pub rotation: Quat,
    /// Opacity in the center.
    pub opacity: f32,
    /// Display color without harmonics.
    pub base: Vec3,
    /// Coefficients from degree 1 on: those of a whole degree.
    pub harmonics: Vec<Vec3>,
}

impl Default for Splat {
    fn default() -> Self {
        Self {
            position: DVec3::ZERO,
            extents: Vec3::ONE,
            rotation: Quat::IDENTITY,
            opacity: 1.0,
            base: Vec3::ONE,
            harmonics: Vec::new(),
        }
    }
}

impl Splat {
    /// Axes of the splat as columns, each as long as the standard deviation, in float32.
    pub fn axes(&self) -> Mat3 {
        Mat3::from_quat(self.rotation) * Mat3::from_diagonal(self.extents)
    }

    /// Larger by a factor, and as much farther from the origin.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { position: self.position * factor, extents: self.extents * factor as f32, ..self.clone() }
    }
}

/// Splats as a scene, in the order of their list; all have harmonics of one degree.
pub fn unordered(splats: &[Splat]) -> Points {
    let count = splats.first().map_or(0, |splat| splat.harmonics.len());
    let gaussians = Gaussians {
        extents: splats.iter().map(|splat| splat.extents).collect(),
        rotations: splats.iter().map(|splat| splat.rotation).collect(),
        bases: splats.iter().map(|splat| splat.base).collect(),
        degree: (0..5).find(|degree| coefficients(*degree) == count).unwrap_or(0),
        harmonics: splats.iter().flat_map(|splat| splat.harmonics.clone()).collect(),
        ..Gaussians::default()
    };
    Points {
        positions: splats.iter().map(|splat| splat.position).collect(),
        colors: splats.iter().map(|splat| splat.base).collect(),
        opacities: splats.iter().map(|splat| splat.opacity).collect(),
        radii: splats.iter().map(|splat| REACH * splat.extents.max_element()).collect(),
        gaussians: Some(gaussians),
        ..Points::default()
    }
}

/// Splats as a scene, in canonical order.
pub fn cloud(splats: &[Splat]) -> Points {
    order::canonical(unordered(splats))
}

/// View of splats.
#[derive(Debug, Clone, Copy)]
pub struct SplatView {
    /// The camera.
    pub camera: Camera,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Settings for drawing Gaussians, the order included.
    pub settings: GaussianSettings,
}

impl SplatView {
    /// The order is the method's, unless the settings have one.
    pub fn new(camera: Camera, size: [u32; 2], settings: GaussianSettings, method: &Method) -> Self {
        let order = settings.order.unwrap_or(method.order());
        Self { camera, size, settings: GaussianSettings { order: Some(order), ..settings } }
    }

    /// A frame by a method, with display colors as they are.
    pub fn frame(&self, method: Method) -> Frame {
        let method = method.with_keys(&self.settings.keys());
        debug_assert_eq!(method.discs().map(|discs| discs.gaussians), Some(self.settings), "no setting is refused");
        Frame { color: ColorSpace::Encoded, ..Frame::new(self.camera, self.size, method) }
    }

    /// Returns the pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [width, height] = self.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
    }
}

/// A number in [-1, 1] that a few multiplications make of a splat's.
pub fn part(splat: u32, which: u32) -> f64 {
    let mixed = (splat + 1).wrapping_mul(2_654_435_761).wrapping_add((which + 1).wrapping_mul(2_246_822_519));
    f64::from((mixed ^ (mixed >> 15)).wrapping_mul(3_266_489_917) >> 12) / f64::from(1u32 << 19) - 1.0
}

/// A rotation of a splat's own.
pub fn turned(splat: u32) -> Quat {
    Quat::from_array([20, 21, 22, 23].map(|which| part(splat, which) as f32)).normalize()
}
