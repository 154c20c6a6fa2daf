//! One-layer transparency: the nearest soft points are transparent; everything behind them is opaque.

mod ranges;

use glam::DVec3;

pub use ranges::ranges;

use super::coverage::Shape;
use super::fragments::Composite;
use super::splats::{self, Fragment};
use super::{ReferencePicture, View};
use pellucid_core::points::Points;
use pellucid_scene::{BlendedSplats, OneLayer};

/// The fragments of a pixel, soft and solid ones apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Parts {
    /// Fragments of points with a field above the threshold.
    pub soft: Vec<Fragment>,
    /// Fragments of all other points.
    pub solid: Vec<Fragment>,
}

impl Parts {
    /// Returns `true` if a soft fragment lies behind the layer: farther than the layer's depth by more than the reach
    /// of its blending.
    fn is_behind(f: &Fragment, layer: f64, blend_depth: f64) -> bool {
        f.z > layer + blend_depth * f.radius
    }

    /// The opaque fragments: the solid ones, and the soft ones behind the layer.
    fn others(&self, layer: f64, blend_depth: f64) -> Vec<Fragment> {
        let behind = self.soft.iter().filter(|f| Self::is_behind(f, layer, blend_depth));
        self.solid.iter().chain(behind).copied().collect()
    }

    /// Returns the pixel.
    pub fn blend(&self, colors: &[DVec3], softness: f64, blend_depth: f64) -> Composite {
        let layer = splats::blend(&self.soft, colors, blend_depth);
        let rest = splats::blend(&self.others(layer.depth, blend_depth), colors, blend_depth);
        let solid = self.solid.iter().map(|f| f.z).fold(f64::INFINITY, f64::min);
        if self.soft.is_empty() || solid <= layer.depth {
            return rest;
        }
        Composite {
            color: softness * layer.color + (1.0 - softness) * rest.color,
            alpha: if rest.alpha > 0.0 { 1.0 } else { softness },
            depth: if softness > 0.0 { layer.depth } else { rest.depth },
        }
    }
}

fn shape_of(points: &Points) -> Shape {
    if points.normals.is_some() { Shape::Oriented } else { Shape::Disc }
}

/// Points without a field are solid.
fn is_soft(points: &Points, index: usize, threshold: f32) -> bool {
    points.fields.get(index).is_some_and(|field| *field > threshold)
}

/// Returns the fragments of each pixel, soft and solid ones apart.
pub fn lists(view: View, points: &Points, threshold: f32) -> Vec<Parts> {
    let (shape, settings) = (shape_of(points), BlendedSplats::default().splats);
    let soft = splats::lists(view, points, shape, &settings, |index| is_soft(points, index, threshold));
    let solid = splats::lists(view, points, shape, &settings, |index| !is_soft(points, index, threshold));
    soft.into_iter().zip(solid).map(|(soft, solid)| Parts { soft, solid }).collect()
}

/// Returns the whole image; `colors` as those of [`splats::render`].
pub fn render(view: View, points: &Points, colors: &[DVec3], settings: &OneLayer) -> ReferencePicture {
    let lists = lists(view, points, settings.threshold);
    let (softness, blend_depth) = (f64::from(settings.softness), f64::from(BlendedSplats::default().blend_depth));
    let count = |parts: &Parts| (parts.soft.len() + parts.solid.len()) as u32;
    let pixel = |parts: &Parts| (parts.blend(colors, softness, blend_depth), count(parts));
    ReferencePicture::of(view.size, lists.iter().map(pixel))
}
