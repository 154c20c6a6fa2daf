//! Exact transparency of discs (MCTB12) and Gaussians: the combined result of count, scan, store, sort and blend.

use glam::DVec3;

use super::coverage::{Coverage, Shape, Splat, footprint};
use super::{Picture, gaussians};
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_scene::{DiscShape, Discs, Falloff};

/// A splat's contribution to one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Depth along the viewing axis; of a Gaussian what its order is by ([`gaussians::Hit::key`]).
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

/// Returns fragments of each pixel, near to far; equal depths by the point's index, so that order of arrival can't
/// show.
pub fn lists(camera: &Camera, size: [u32; 2], points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let all: Vec<usize> = (0..size[0] as usize * size[1] as usize).collect();
    lists_at(camera, size, points, discs, &all)
}

/// Makes the lists like [`lists`], for these pixels alone: row · width + column, ascending.
pub fn lists_at(
    camera: &Camera,
    size: [u32; 2],
    points: &Points,
    discs: &Discs,
    wanted: &[usize],
) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); wanted.len()];
    for index in 0..points.len() {
        let of_gaussian = gaussians::fragments(camera, size, points, index, &discs.gaussians);
        for (pixel, fragment) in of_gaussian.unwrap_or_else(|| of_disc(camera, size, points, index, discs)) {
            if let Ok(at) = wanted.binary_search(&pixel) {
                pixels[at].push(fragment);
            }
        }
    }
    for list in &mut pixels {
        list.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.index.cmp(&b.index)));
    }
    pixels
}

/// Returns the fragments of a point's disc, each with its pixel: row · width + column.
pub(super) fn of_disc(
    camera: &Camera,
    size: [u32; 2],
    points: &Points,
    index: usize,
    discs: &Discs,
) -> Vec<(usize, Fragment)> {
    let opacity = f64::from(points.opacities[index]);
    let covered = footprint(camera, size, &splat(points, index, discs.shape));
    let fragment = |pixel: &Coverage| {
        let alpha = match discs.falloff {
            Falloff::Flat => opacity,
            Falloff::Gaussian => opacity * (-2.0 * pixel.rho * pixel.rho).exp(),
        };
        let at = pixel.y as usize * size[0] as usize + pixel.x as usize;
        (at, Fragment { z: pixel.z, index: index as u32, alpha })
    };
    covered.iter().map(fragment).collect()
}

/// Returns the smallest distance between successive depths of a list, over the depth; equal depths don't count, since
/// the index orders them at any precision. Below the rounding of a float32 depth the order of two fragments is a matter
/// of chance.
pub fn depth_margin(lists: &[Vec<Fragment>]) -> f64 {
    let gaps = lists.iter().flat_map(|list| list.windows(2)).map(|pair| (pair[1].z - pair[0].z) / pair[1].z.abs());
    gaps.filter(|&gap| gap != 0.0).fold(f64::INFINITY, f64::min)
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
///
/// Transmittance is kept as Σ ln(1−αᵢ): neither 100 000 factors of 1−10⁻⁷ nor a single one of 1−10⁻²⁰ lose digits.
pub fn composite(list: &[Fragment], colors: &[DVec3]) -> Composite {
    let mut log_transmittance = 0.0f64;
    let mut color = DVec3::ZERO;
    for fragment in list {
        color += colors[fragment.index as usize] * (fragment.alpha * log_transmittance.exp());
        log_transmittance += (-fragment.alpha).ln_1p();
    }
    let depth = list.iter().find(|f| f.alpha > 0.0).map_or(f64::INFINITY, |f| f.z);
    // From zero, so that nothing drawn is 0 and not the −0 that −expm1(0) yields.
    Composite { color, alpha: 0.0 - log_transmittance.exp_m1(), depth }
}

/// Returns the depth at which a sorted list first lets through `share` of the light or less; +inf if it never does. Of
/// 1/2 it is the median depth; roundings make of it one between those of shares around 1/2.
pub fn median(list: &[Fragment], share: f64) -> f64 {
    let mut log_transmittance = 0.0f64;
    let reached = list.iter().find(|fragment| {
        log_transmittance += (-fragment.alpha).ln_1p();
        log_transmittance.exp_m1() <= share - 1.0
    });
    reached.map_or(f64::INFINITY, |fragment| fragment.z)
}

/// Returns the mean depth of a sorted list, Σ zᵢαᵢTᵢ / A with the transmittance Tᵢ before each fragment; +inf where A
/// is 0.
pub fn mean_depth(list: &[Fragment]) -> f64 {
    let mut log_transmittance = 0.0f64;
    let mut sum = 0.0;
    for fragment in list {
        sum += fragment.z * fragment.alpha * log_transmittance.exp();
        log_transmittance += (-fragment.alpha).ln_1p();
    }
    let alpha = -log_transmittance.exp_m1();
    if alpha > 0.0 { sum / alpha } else { f64::INFINITY }
}

/// Returns the whole image. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(camera: &Camera, size: [u32; 2], points: &Points, colors: &[DVec3], discs: &Discs) -> Picture {
    if gaussians::ellipsoid::are_drawn(points, discs) {
        return gaussians::ellipsoid::render(camera, size, points, colors, discs);
    }
    let lists = lists(camera, size, points, discs);
    let stop = gaussians::stop(points, &discs.gaussians);
    let pixel = |list: &Vec<Fragment>| {
        composite(before_end(&gaussians::with_depths(camera, points, &discs.gaussians, list), stop), colors)
    };
    let pixels: Vec<Composite> = lists.iter().map(pixel).collect();
    Picture {
        width: size[0],
        height: size[1],
        rgba: pixels.iter().map(|p| p.color.extend(p.alpha).to_array()).collect(),
        depth: pixels.iter().map(|p| p.depth).collect(),
        counts: lists.iter().map(|list| list.len() as u32).collect(),
    }
}
