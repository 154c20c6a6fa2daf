//! The canonical order of points: by their values, not by their places in a file.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::keyed::Keyed;
use super::morton;
use crate::points::Points;

/// Sorts the points that are drawn along the Morton curve of their bounds, equal cells by the bits of position, color,
/// opacity, radius, field and normal. Points that tie in all of these are identical, so shuffled input gives the same list; they stay
/// in the order in which they came.
pub fn canonical(mut points: Points) -> Points {
    let Some(bounds) = points.drawn_bounds() else { return points };
    // Points are counted in 32 bits from here on: more of them don't fit any device.
    let keyed = morton::sorted(&points.positions, &bounds, |a, b| by_content(&points, a as usize, b as usize));
    let order = indices(keyed);
    let before = std::mem::take(&mut points.file_order);
    let mut points = points.in_order(|place| order[place] as usize);
    points.file_order = match before.is_empty() {
        true => order,
        false => order.par_iter().map(|&i| before.get(i as usize).copied().unwrap_or(i)).collect(),
    };
    points
}

/// The indices alone. They take the memory of what they stood in, of which the rest is given back.
fn indices(keyed: Vec<Keyed>) -> Vec<u32> {
    let mut indices: Vec<u32> = keyed.into_iter().map(|keyed| keyed.index).collect();
    indices.shrink_to_fit();
    indices
}

/// Any fixed total order of the bits; only identical points are equal.
fn by_content(points: &Points, a: usize, b: usize) -> Ordering {
    let double = |v: DVec3| v.to_array().map(f64::to_bits);
    double(points.positions[a]).cmp(&double(points.positions[b])).then_with(|| by_look(points, a, b))
}

/// The part of it that decides between points of equal position.
pub(super) fn by_look(points: &Points, a: usize, b: usize) -> Ordering {
    let single = |v: Vec3| v.to_array().map(f32::to_bits);
    single(points.colors[a])
        .cmp(&single(points.colors[b]))
        .then_with(|| points.opacities[a].to_bits().cmp(&points.opacities[b].to_bits()))
        .then_with(|| points.radii[a].to_bits().cmp(&points.radii[b].to_bits()))
        .then_with(|| points.fields.get(a).map(|f| f.to_bits()).cmp(&points.fields.get(b).map(|f| f.to_bits())))
        .then_with(|| match &points.normals {
            Some(normals) => single(normals[a]).cmp(&single(normals[b])),
            None => Ordering::Equal,
        })
}
