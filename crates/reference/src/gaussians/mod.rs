//! Gaussian splats (Kerbl et al. 2023): which pixels one covers, with which opacity, and at which depth.
//!
//! A Gaussian has a center μ and a covariance Σ = M Mᵀ, whose columns are the axes r_k scaled by the standard
//! deviations s_k. On a pixel it has the opacity α = min(`alpha_max`, o·exp(−ρ²/2)), and none where that is less than
//! `alpha_min`. ρ follows from the kernel: [`ewa`] or [`ray`]; [`ellipsoid`] has its own rules. Nothing else bounds a
//! splat: neither tiles nor a number of standard deviations, and the pixel of its center is not covered for that alone.

pub mod ellipsoid;
pub mod ewa;
pub mod harmonics;
mod ranges;
pub mod ray;

use glam::{DMat3, DVec2, DVec3};

pub use ranges::{Possible, PossibleChord, possible, possible_chords};

use super::View;
use super::coverage::{is_in_depth, pixels_within};
use super::fragments::Fragment;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_scene::{GaussianSettings, Kernel, Order};

/// A Gaussian of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// World position of the center μ.
    pub position: DVec3,
    /// M in world coordinates: in each column an axis, as long as the standard deviation along it.
    pub axes: DMat3,
    /// Opacity o in the center, in [0, 1].
    pub opacity: f64,
}

/// A Gaussian on a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Column, from the left.
    pub x: u32,
    /// Row, from the top.
    pub y: u32,
    /// Opacity, from `alpha_min` to `alpha_max`.
    pub alpha: f64,
    /// Key that fragments are sorted by: a depth along the viewing axis, or the distance from the eye.
    pub key: f64,
    /// The depth along the viewing axis that an image shows.
    pub z: f64,
}

/// Returns the Gaussian that a point is; `None` of a point that is none.
pub fn gaussian(points: &Points, index: usize) -> Option<Gaussian> {
    let all = points.gaussians.as_ref().filter(|all| all.is_one(index))?;
    let turned = DMat3::from_quat(all.rotations[index].as_dquat().normalize());
    Some(Gaussian {
        position: points.positions[index],
        axes: turned * DMat3::from_diagonal(all.extents[index].as_dvec3()),
        opacity: f64::from(points.opacities[index]).min(1.0),
    })
}

/// Returns what methods other than `sorted` order Gaussians by.
pub fn order(settings: &GaussianSettings) -> Order {
    settings.order.unwrap_or(Order::Pixel)
}

/// Returns the share of the light at which lists end: 0, which ends none, where no point is a Gaussian.
pub fn stop(points: &Points, settings: &GaussianSettings) -> f64 {
    if points.gaussians.is_some() { f64::from(settings.stop) } else { 0.0 }
}

/// Returns the pixels that a Gaussian covers, row by row.
pub fn footprint(view: View, gaussian: &Gaussian, settings: &GaussianSettings, order: Order) -> Vec<Hit> {
    let Some(placed) = PlacedGaussian::new(view, gaussian) else { return Vec::new() };
    match settings.kernel {
        Kernel::Ewa => ewa::footprint(&placed, settings, order),
        Kernel::Ray => ray::footprint(&placed, settings, order),
        Kernel::Ellipsoid => ellipsoid::footprint(&placed, settings),
    }
}

/// Returns the fragments of the Gaussian that a point is, each with its pixel (row · width + column); z is the key.
/// `None` of a point that is none.
pub fn fragments(
    view: View,
    points: &Points,
    index: usize,
    settings: &GaussianSettings,
) -> Option<Vec<(usize, Fragment)>> {
    let hits = footprint(view, &gaussian(points, index)?, settings, order(settings));
    let fragment = |hit: &Hit| Fragment { z: hit.key, index: index as u32, alpha: hit.alpha };
    Some(hits.iter().map(|hit| (view.index(hit.x, hit.y), fragment(hit))).collect())
}

/// Returns a sorted list with the depths that an image shows in place of the keys that it is sorted by. They differ for
/// Gaussians that are sorted by distance, which show the depth of their centers.
pub fn with_depths(camera: &Camera, points: &Points, settings: &GaussianSettings, list: &[Fragment]) -> Vec<Fragment> {
    let shown = |fragment: &Fragment| {
        let index = fragment.index as usize;
        let by_distance = order(settings) == Order::Distance && gaussian(points, index).is_some();
        let z = if by_distance { camera.to_view(points.positions[index]).z } else { fragment.z };
        Fragment { z, ..*fragment }
    };
    list.iter().map(shown).collect()
}

/// Returns the depth that an image shows for the first visible fragment with a key; +inf for a key of +inf.
pub fn depth_of_key(camera: &Camera, points: &Points, settings: &GaussianSettings, list: &[Fragment], key: f64) -> f64 {
    let first = list.iter().find(|fragment| fragment.z == key && fragment.alpha > 0.0);
    first.map_or(key, |fragment| with_depths(camera, points, settings, &[*fragment])[0].z)
}

/// A Gaussian before a camera.
pub struct PlacedGaussian<'a> {
    view: View<'a>,
    /// μ in camera coordinates (right, up, z).
    center: DVec3,
    /// M in camera coordinates.
    axes: DMat3,
    opacity: f64,
    distance: f64,
}

impl<'a> PlacedGaussian<'a> {
    /// `None` of a center that is outside the range of depths, or nowhere.
    pub fn new(view: View<'a>, gaussian: &Gaussian) -> Option<Self> {
        let center = view.camera.to_view(gaussian.position);
        if !gaussian.position.is_finite() || !is_in_depth(view.camera, center.z) {
            return None;
        }
        let to_view = DMat3::from_cols(view.camera.right, view.camera.up, view.camera.forward).transpose();
        Some(Self {
            view,
            center,
            axes: to_view * gaussian.axes,
            opacity: gaussian.opacity,
            distance: if is_orthographic(view.camera) { center.z } else { center.length() },
        })
    }

    /// The lengths of the axes.
    fn lengths(&self) -> DVec3 {
        DVec3::from([0, 1, 2].map(|k| self.axes.col(k).length()))
    }

    /// The key of a fragment whose Gaussian is densest at a depth of the pixel's ray.
    fn key(&self, order: Order, densest: f64) -> f64 {
        match order {
            Order::Center => self.center.z,
            Order::Distance => self.distance,
            Order::Pixel => densest,
        }
    }

    /// The depth that goes with this key.
    fn shown(&self, order: Order, densest: f64) -> f64 {
        if order == Order::Pixel { densest } else { self.center.z }
    }

    /// The place of a pixel's center on the plane at depth 1 (orthographic: at any depth).
    fn on_plane(&self, [x, y]: [u32; 2]) -> DVec2 {
        self.view.on_plane(DVec2::new(f64::from(x), f64::from(y)) + 0.5)
    }

    /// The pixels whose centers are within a box on the screen, and at least one more on each side.
    fn window(&self, ends: [DVec2; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
        pixels_within(self.view.size, ends, 0..self.view.size[1])
    }
}

/// α by ρ² and the opacity in the center; `None` below `alpha_min`, and where ρ is none.
fn alpha(opacity: f64, rho2: f64, settings: &GaussianSettings) -> Option<f64> {
    let alpha = (opacity * (-0.5 * rho2).exp()).min(f64::from(settings.alpha_max));
    (rho2.is_finite() && alpha >= f64::from(settings.alpha_min)).then_some(alpha)
}

/// The largest ρ² of a Gaussian of this opacity: 2 ln(o / `alpha_min`). Negative if it has no fragment anywhere.
fn largest_rho2(opacity: f64, settings: &GaussianSettings) -> f64 {
    2.0 * (opacity / f64::from(settings.alpha_min)).ln()
}

fn is_orthographic(camera: &Camera) -> bool {
    matches!(camera.projection, Projection::Orthographic { .. })
}
