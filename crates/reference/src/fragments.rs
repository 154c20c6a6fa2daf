//! Fragments of discs and Gaussians, and pixels that are blended of them.

use glam::DVec3;

use super::coverage::{Coverage, Shape, Splat, footprint};
use super::{ReferencePicture, View};
use pellucid_core::points::Points;
use pellucid_scene::{DiscShape, Discs, Falloff};

/// A splat's contribution to one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Depth along the viewing axis; of a Gaussian what its order is by ([`super::gaussians::Hit::key`]).
    pub z: f64,
    /// The point's place in the canonical order, which decides between equal depths.
    pub index: u32,
    /// Opacity in [0, 1] after the falloff.
    pub alpha: f64,
}

/// A pixel after blending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composite {
    /// Σ cᵢαᵢ∏ⱼ﹤ᵢ(1−αⱼ), premultiplied.
    pub color: DVec3,
    /// A = 1 − ∏(1−αᵢ).
    pub alpha: f64,
    /// z of the first fragment with α > 0, +inf if none has.
    pub depth: f64,
}

impl Composite {
    /// A pixel without anything.
    pub const NOTHING: Self = Self { color: DVec3::ZERO, alpha: 0.0, depth: f64::INFINITY };

    /// Returns a pixel of a picture.
    pub fn from_picture(picture: &ReferencePicture, pixel: usize) -> Self {
        let [r, g, b, alpha] = picture.rgba[pixel];
        Self { color: DVec3::new(r, g, b), alpha, depth: picture.depth[pixel] }
    }
}

/// Returns the splat that the disc family draws for a point.
pub fn splat(points: &Points, index: usize, shape: DiscShape) -> Splat {
    Splat {
        position: points.positions[index],
        radius: f64::from(points.radii[index]),
        normal: points.own_normal(index).map(|normal| normal.as_dvec3()),
        shape: match shape {
            DiscShape::Flat => Shape::Disc,
            DiscShape::Oriented => Shape::Oriented,
        },
        max_pixel_radius: f64::INFINITY,
    }
}

/// Returns the fragments of a point's disc, each with its pixel: row · width + column.
pub(super) fn of_disc(view: View, points: &Points, index: usize, discs: &Discs) -> Vec<(usize, Fragment)> {
    let opacity = f64::from(points.opacities[index]);
    let covered = footprint(view, &splat(points, index, discs.shape));
    let fragment = |pixel: &Coverage| {
        let alpha = match discs.falloff {
            Falloff::Flat => opacity,
            Falloff::Gaussian => opacity * (-2.0 * pixel.rho * pixel.rho).exp(),
        };
        (view.index(pixel.x, pixel.y), Fragment { z: pixel.z, index: index as u32, alpha })
    };
    covered.iter().map(fragment).collect()
}

/// Returns the fragments of a sorted list that are added where it ends early (Kerbl et al. 2023): those in front of the
/// first that would leave less than `stop` of the light. 0 ends no list.
pub fn before_end(list: &[Fragment], stop: f64) -> &[Fragment] {
    let mut transmittance = 1.0;
    let end = list.iter().position(|fragment| {
        transmittance *= 1.0 - fragment.alpha;
        transmittance < stop
    });
    &list[..end.unwrap_or(list.len())]
}

/// Blends a sorted list front to back. `colors` holds a color for each point.
pub fn composite(list: &[Fragment], colors: &[DVec3]) -> Composite {
    let (color, log_transmittance) = blend(list, colors);
    let depth = list.iter().find(|f| f.alpha > 0.0).map_or(f64::INFINITY, |f| f.z);
    // From zero, so that nothing drawn is 0 and not the −0 that −expm1(0) yields.
    Composite { color, alpha: 0.0 - log_transmittance.exp_m1(), depth }
}

/// Returns the premultiplied color of a sorted list, and the logarithm of what it lets through.
///
/// Transmittance is kept as Σ ln(1−αᵢ): neither 100 000 factors of 1−10⁻⁷ nor a single one of 1−10⁻²⁰ lose digits.
pub(super) fn blend(list: &[Fragment], colors: &[DVec3]) -> (DVec3, f64) {
    list.iter().fold((DVec3::ZERO, 0.0f64), |(color, log_transmittance), fragment| {
        let own = colors[fragment.index as usize] * (fragment.alpha * log_transmittance.exp());
        (color + own, log_transmittance + (-fragment.alpha).ln_1p())
    })
}

/// z of the nearest fragment with α > 0, +inf if none has.
pub(super) fn nearest(list: &[Fragment]) -> f64 {
    list.iter().filter(|f| f.alpha > 0.0).map(|f| f.z).fold(f64::INFINITY, f64::min)
}

/// 1 − ∏(1−αᵢ).
pub(super) fn coverage(list: &[Fragment]) -> f64 {
    0.0 - list.iter().map(|f| (-f.alpha).ln_1p()).sum::<f64>().exp_m1()
}

/// Returns the place of a fragment's point in the files.
pub(super) fn place(f: &Fragment, places: &[u32]) -> u32 {
    places.get(f.index as usize).copied().unwrap_or(f.index)
}
