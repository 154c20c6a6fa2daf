//! Multi-layer alpha blending (Salvi and Vaidyanathan 2014) in float64: fragments come in the order of the files, and
//! of each pixel a few layers are kept.

use glam::DVec3;

use super::fragments::{Composite, Fragment, coverage, nearest, place};

/// A fragment, or several that became one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Depth of the nearest of its fragments.
    pub z: f64,
    /// Premultiplied.
    pub color: DVec3,
    /// T = ∏(1−α).
    pub through: f64,
}

/// Two neighbors as one: c₁ + T₁c₂, T₁T₂, z₁.
pub fn merged(front: &Layer, back: &Layer) -> Layer {
    Layer { z: front.z, color: front.color + front.through * back.color, through: front.through * back.through }
}

/// Puts a layer among others, which are in order of depth, before those of its own depth. If that makes more than
/// `nodes`, the last two become one.
pub fn insert(layers: &mut Vec<Layer>, layer: Layer, nodes: u32) {
    let at = layers.partition_point(|other| other.z < layer.z);
    layers.insert(at, layer);
    if layers.len() > nodes as usize
        && let (Some(back), Some(front)) = (layers.pop(), layers.pop())
    {
        layers.push(merged(&front, &back));
    }
}

/// Returns the fragments of a pixel, in the order of `places`, where in the files each point stood. What has no opacity
/// takes no layer. Between two fragments `nodes` layers are kept, so that `nodes` + 1 fragments are composed exactly.
pub fn mlab(list: &[Fragment], colors: &[DVec3], places: &[u32], nodes: u32) -> Composite {
    let mut by_place: Vec<&Fragment> = list.iter().filter(|f| f.alpha > 0.0).collect();
    by_place.sort_by_key(|f| place(f, places));
    let mut layers = Vec::new();
    for f in by_place {
        let layer = Layer { z: f.z, color: f.alpha * colors[f.index as usize], through: 1.0 - f.alpha };
        insert(&mut layers, layer, nodes);
    }
    let whole = layers.into_iter().reduce(|front, back| merged(&front, &back));
    let color = whole.map_or(DVec3::ZERO, |layer| layer.color);
    Composite { color, alpha: coverage(list), depth: nearest(list) }
}
