//! Stochastic point-based rendering (Tanaka et al., "See-through imaging of laser-scanned 3D cultural heritage objects
//! based on stochastic rendering of large-scale point clouds", 2016; Uchida et al., "Noise-robust transparent
//! visualization of large-scale point clouds acquired by laser scanning", 2020): opaque images of random parts of the
//! points, and their mean.
//!
//! A surface of opacity α is to leave a pixel free with probability 1 − α in each image. Points on it are as good as
//! independent, so that m of them on average over the area of a pixel leave it free with probability e^(−m), and
//! m = −ln(1 − α) (Eq. 1 in the limit of many pixels: [`opacity`]).

mod ranges;

use glam::{DVec2, DVec3};

pub use ranges::{Ranges, Turn, ranges, ranges_of};

use super::fragments::{Fragment, composite};
use super::range::{DEPTH_ERROR, ROUNDING, screen_error};
use super::shading::to_viewer;
use super::{ReferencePicture, View, WithErrors, dealing};
use pellucid_core::camera::Projection;
use pellucid_core::cloud::Bounds;
use pellucid_core::random::{key, threefry2x32};
use pellucid_scene::prepare::ensembles::{CloudSurface, Deal, Dealt};
use pellucid_scene::{Spbr, SpbrSimplified};

/// Separates the random words of this method from those of `stochastic`: "SPBR" on the second word of the key.
const STREAM: u32 = 0x5350_4252;

/// The differences between the two methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// L.
    pub ensembles: u32,
    /// Adjustment: if true, points are left out or copied until their surface has its opacity, and each point is
    /// weighted according to its own opacity; else all of them are dealt, once.
    pub adjust: bool,
    /// `true` if a slanted surface has as many more points over a pixel as its slant brings (Eq. 2).
    pub cos_theta: bool,
}

impl From<Spbr> for Rule {
    fn from(settings: Spbr) -> Self {
        Self { ensembles: settings.ensembles, adjust: true, cos_theta: settings.cos_theta }
    }
}

impl From<SpbrSimplified> for Rule {
    fn from(settings: SpbrSimplified) -> Self {
        Self { ensembles: settings.ensembles, adjust: false, cos_theta: true }
    }
}

/// Returns the opacity of `points` points of one pixel's area, dropped at random, for each pixel: 1 − e^(−m).
pub fn opacity(points: f64) -> f64 {
    -(-points).exp_m1()
}

/// Returns the inverse: −ln(1 − α) points over a pixel for the opacity α, infinite for 1.
pub fn points_per_pixel(alpha: f64) -> f64 {
    -(-alpha).ln_1p()
}

/// Eq. 1 of the paper: the opacity of an area S that holds n points of the cross-section s.
pub fn opacity_of_segment(points: f64, section_by_area: f64) -> f64 {
    1.0 - (1.0 - section_by_area).powf(points)
}

/// Eq. 2 in the limit of many pixels: the opacity of a surface whose normal and the direction to the viewer have this
/// cosine, if it has the opacity `alpha` where they agree.
pub fn slanted(alpha: f64, cos: f64) -> f64 {
    opacity(points_per_pixel(alpha) / cos.abs())
}

/// Alpha blending of two surfaces: color and opacity of `front` before `back`, colors premultiplied.
pub fn over(front: (DVec3, f64), back: (DVec3, f64)) -> (DVec3, f64) {
    (front.0 + (1.0 - front.1) * back.0, front.1 + (1.0 - front.1) * back.1)
}

/// The partition into ensembles of a cloud for a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Depth at which a point is one pixel wide: z of the cloud's center, or, where that is behind the camera or close
    /// to it, half of that of the deepest corner of its box, and not before `near`. Unused in an orthographic view.
    pub depth: f64,
    /// The ratio k = L·(−ln(1 − α)) / (s ρ) of dealt points to existing points, before it is limited to L. 1 for a rule
    /// that doesn't adjust.
    pub ratio: f64,
    /// M = round(k N), of all ensembles together.
    pub slots: u64,
    /// −ln(1 − α) of the opacity α that all these points bring about: the surface's, or less where k is cut to L. A
    /// point of that opacity or a larger one counts as one.
    pub unit: f64,
}

/// Returns the share of a cloud in the ensembles. For a cloud without density k is infinite: its points are in every
/// ensemble. For an invisible cloud it is 0.
pub fn share(view: View, dealt: &Dealt, surface: &CloudSurface, rule: &Rule) -> Share {
    let points = surface.points.end - surface.points.start;
    let own = &dealt.points.positions[surface.points.start as usize..surface.points.end as usize];
    let corners = Bounds::enclosing(own.iter().copied()).map_or([surface.center; 8], |bounds| bounds.corners());
    let deepest = corners.iter().map(|corner| view.camera.to_view(*corner).z).fold(f64::NEG_INFINITY, f64::max);
    let depth = view.camera.to_view(surface.center).z.max(0.5 * deepest).max(view.camera.near);
    // Points over a pixel, if all are in every ensemble.
    let most = surface.density / view.pixels_per_unit(depth).powi(2);
    let wanted = points_per_pixel(f64::from(surface.opacity));
    let ensembles = f64::from(rule.ensembles);
    let ratio = match (rule.adjust, wanted) {
        (false, _) => 1.0,
        (true, 0.0) => 0.0,
        (true, _) => ensembles * wanted / most,
    };
    let slots = (ratio.min(ensembles) * points as f64).round() as u64;
    Share { depth, ratio, slots, unit: wanted.min(most) }
}

/// A point in its drawn form.
struct Drawn {
    at: DVec2,
    z: f64,
    /// Area in pixels; below 1 it is the probability of being drawn.
    area: f64,
    /// Largest area that roundings of float32 may add or take.
    area_error: f64,
}

/// `None` if it isn't drawn in any ensemble. Near and far are moved apart by this part of a depth.
fn drawn(inputs: &Inputs, share: &Share, index: usize, apart: f64) -> Option<Drawn> {
    let Inputs { view, dealt, rule, .. } = *inputs;
    let position = dealt.points.positions[index];
    let camera = view.camera;
    let (at, z) = camera.project(position, view.size);
    let perspective = matches!(camera.projection, Projection::Perspective { .. });
    let outside = z * (1.0 + apart) < camera.near || z * (1.0 - apart) > camera.far;
    if !position.is_finite() || outside || (perspective && z <= 0.0) {
        return None;
    }
    let nearer = if perspective { share.depth / z } else { 1.0 };
    let own = if rule.adjust { weight(dealt.points.opacities[index].into(), share.unit) } else { 1.0 };
    let (upright, slant) = (nearer * nearer * own, slant(inputs, index));
    Some(Drawn { at, z, area: upright * slant, area_error: area_error(upright, slant) })
}

/// Returns how far float32 may be off the product of an area and of |cos θ|.
///
/// The area itself, in roundings of the result: 7 for the square of a quotient of two rounded depths; 7 for a logarithm
/// (1 of 1 − x, 2 of the function, 2 of Kahan's correction) over a rounded number; 2 for their product and that with
/// |cos θ|. The cosine has 7 more: products, sums and roots of two lengths, a quotient. In its scalar product rounding
/// of the vector, products and two sums stay where the products cancel: 4 of the product of lengths. 1 for what is of
/// second order. The area is then cut to a multiple of 2^-32.
fn area_error(upright: f64, cos: f64) -> f64 {
    ROUNDING * upright * (24.0 * cos + 4.0) + 1.0 / 4_294_967_296.0
}

/// Pixels of an image: the one that holds the projected point, or those whose centers lie in a square of its area,
/// including the lower sides.
fn pixels(drawn: &Drawn, size: [u32; 2]) -> impl Iterator<Item = usize> + use<> {
    let Drawn { at, area, .. } = *drawn;
    let [width, height] = size.map(i64::from);
    let range = |at: f64, side: i64| {
        let half = 0.5 * area.sqrt();
        let from = |x: f64| ((x - 0.5).ceil() as i64).clamp(0, side);
        if area < 1.0 {
            (at.floor() as i64).clamp(-1, side)..at.floor() as i64 + 1
        } else {
            from(at - half)..from(at + half)
        }
    };
    let inside = |range: std::ops::Range<i64>, side: i64| range.start.max(0)..range.end.min(side);
    let (columns, rows) = (inside(range(at.x, width), width), inside(range(at.y, height), height));
    rows.flat_map(move |y| columns.clone().map(move |x| (y * width + x) as usize))
}

/// The area, in [0, 1), from which on an ensemble draws a point that covers less than a pixel.
fn least_area(id: u32, ensemble: u32, seed: u64) -> f64 {
    let [low, high] = key(seed);
    let word = threefry2x32([id, ensemble], [low, high ^ STREAM])[0];
    f64::from(word) / 4_294_967_296.0
}

/// The weight of a point for an opacity, if a whole point gives about `unit` ([`Share::unit`]); at most 1.
fn weight(opacity: f64, unit: f64) -> f64 {
    let wanted = points_per_pixel(opacity);
    if wanted == 0.0 { 0.0 } else { (wanted / unit).min(1.0) }
}

/// |cos θ| of a point's normal where the rule wants it, else 1.
fn slant(inputs: &Inputs, index: usize) -> f64 {
    let normal = inputs.dealt.points.normals.as_ref().and_then(|normals| normals[index].as_dvec3().try_normalize());
    let to_viewer = to_viewer(inputs.view.camera, inputs.dealt.points.positions[index]);
    match normal {
        Some(normal) if !inputs.rule.cos_theta => normal.dot(to_viewer).abs(),
        _ => 1.0,
    }
}

/// The inputs of an image.
#[derive(Clone, Copy)]
struct Inputs<'a> {
    view: View<'a>,
    dealt: &'a Dealt,
    /// Ids of its points.
    ids: &'a [u32],
    rule: Rule,
    seed: u64,
}

/// Returns the image, and the standard error of each pixel's color, infinite for a single ensemble. A is the share of
/// ensembles that drew something on a pixel, `counts` the total number of points they drew there, including occluded
/// ones.
///
/// `colors` holds a color for each point, shaded and in the color space of the blending ([`super::shading::shade`]).
pub fn render(view: View, dealt: &Dealt, colors: &[DVec3], rule: &Rule, seed: u64) -> WithErrors {
    render_with(view, dealt, colors, rule, seed, dealing::hands)
}

/// Renders like [`render`], with the points of each ensemble, counted from the cloud's first, from elsewhere.
pub fn render_with(
    view: View,
    dealt: &Dealt,
    colors: &[DVec3],
    rule: &Rule,
    seed: u64,
    hands: impl Fn(&Deal) -> Vec<Vec<u64>>,
) -> WithErrors {
    let ids = &dealt.points.ids(&dealt.points.anchor(), 0..dealt.points.len());
    let inputs = Inputs { view, dealt, ids, rule: *rule, seed };
    let count = view.pixels();
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0u32); count];
    let mut depth = vec![f64::INFINITY; count];
    let mut counts = vec![0u32; count];
    let hands = hands_of(&inputs, 1, hands);
    for ensemble in 0..rule.ensembles {
        let image = draw(&inputs, ensemble, &hands, &mut counts);
        for (pixel, (z, index)) in image.into_iter().enumerate() {
            if let Some(index) = index {
                let (sum, squares, drawn) = &mut sums[pixel];
                let color = colors[index];
                *sum += color;
                *squares += color * color;
                *drawn += 1;
                depth[pixel] = depth[pixel].min(z);
            }
        }
    }
    let ensembles = f64::from(rule.ensembles);
    let mean =
        |&(sum, _, drawn): &(DVec3, DVec3, u32)| (sum / ensembles).extend(f64::from(drawn) / ensembles).to_array();
    let stderr = |&(sum, squares, _): &(DVec3, DVec3, u32)| match rule.ensembles {
        1 => DVec3::INFINITY,
        // The spread of the ensembles around their mean, over L (L − 1).
        _ => ((squares - sum * sum / ensembles).max(DVec3::ZERO) / (ensembles * (ensembles - 1.0))).map(f64::sqrt),
    };
    let rgba = sums.iter().map(mean).collect();
    let stderr = sums.iter().map(stderr).collect();
    (ReferencePicture { width: view.size[0], height: view.size[1], rgba, depth, counts }, stderr)
}

/// The points of each cloud and ensemble, of so many images to which they are dealt together.
fn hands_of(inputs: &Inputs, images: u32, hands: impl Fn(&Deal) -> Vec<Vec<u64>>) -> Vec<Vec<Vec<u64>>> {
    let Inputs { view, dealt, rule, seed, .. } = *inputs;
    let hands_of_cloud = |(surface, place): (&CloudSurface, u32)| {
        let slots = share(view, dealt, surface, &rule).slots * u64::from(images);
        let points = surface.points.end - surface.points.start;
        hands(&Deal { points, slots, ensembles: rule.ensembles * images, place, seed })
    };
    dealt.surfaces.iter().zip(0..).map(hands_of_cloud).collect()
}

/// The nearest point of an ensemble on each pixel, of equal depths the one that comes first in the ensemble, and its
/// depth.
fn draw(inputs: &Inputs, ensemble: u32, hands: &[Vec<Vec<u64>>], counts: &mut [u32]) -> Vec<(f64, Option<usize>)> {
    let mut image = vec![(f64::INFINITY, None); counts.len()];
    for (surface, hands) in inputs.dealt.surfaces.iter().zip(hands) {
        let share = share(inputs.view, inputs.dealt, surface, &inputs.rule);
        for point in &hands[ensemble as usize] {
            let index = (surface.points.start + point) as usize;
            let Some(point) = drawn(inputs, &share, index, 0.0) else { continue };
            if point.area < 1.0 && point.area <= least_area(inputs.ids[index], ensemble, inputs.seed) {
                continue;
            }
            for pixel in pixels(&point, inputs.view.size) {
                counts[pixel] += 1;
                if point.z < image[pixel].0 {
                    image[pixel] = (point.z, Some(index));
                }
            }
        }
    }
    image
}

/// Returns the limit of the mean as the number of ensembles grows. Each point is in a share k/L of them, independently
/// of the others except for one part in their number. So it is the image of points of this opacity, or less where less
/// than a pixel is drawn, blended front to back. `counts` are the points on a pixel.
pub fn limit(view: View, dealt: &Dealt, colors: &[DVec3], rule: &Rule) -> ReferencePicture {
    let inputs = Inputs { view, dealt, ids: &[], rule: *rule, seed: 0 };
    let mut lists: Vec<Vec<Fragment>> = vec![Vec::new(); view.pixels()];
    for surface in &dealt.surfaces {
        let share = share(view, dealt, surface, rule);
        let (first, end) = (surface.points.start as usize, surface.points.end as usize);
        let dealt = share.slots as f64 / (f64::from(rule.ensembles) * (end - first) as f64);
        for index in first..end {
            let Some(point) = drawn(&inputs, &share, index, 0.0) else { continue };
            let alpha = dealt * point.area.min(1.0);
            pixels(&point, view.size).for_each(|p| lists[p].push(Fragment { z: point.z, index: index as u32, alpha }));
        }
    }
    // Stable: of equal depths in the order of the list.
    lists.iter_mut().for_each(|list| list.sort_by(|a, b| a.z.total_cmp(&b.z)));
    ReferencePicture::of_lists(view.size, &lists, |list| composite(list, colors))
}
