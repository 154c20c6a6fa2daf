//! The canonical order of points: by their values, not by their places in a file.

use std::cmp::Ordering;
use std::sync::Arc;

use glam::DVec3;

use super::keyed::{self, Keyed};
use super::morton::{self, Cells};
use pellucid_core::cloud::Bounds;
use pellucid_core::parallel;
use pellucid_core::points::Points;

/// Sorts the points that are drawn along the Morton curve of the scene's bounds, equal cells by the bits of position,
/// color, opacity, radius, field and normal. Points that tie in all of these are identical, so shuffled input gives the
/// same list; they stay in the order in which they came.
pub fn canonical(mut points: Points) -> Points {
    let Some(bounds) = points.bounds() else { return points };
    // Points are counted in 32 bits from here on: more of them don't fit any device.
    let at = |i: u32| (&points, i as usize);
    let cells = Cells::of(&bounds);
    let by_content_at = |a: u32, b: u32| by_content(at(a), at(b));
    if keyed::are_sorted(points.len() as u32, |i| cells.code(points.positions[i as usize]), &by_content_at) {
        if points.file_order.is_empty() {
            points.file_order = (0..points.len() as u32).collect();
        }
        return points;
    }
    let order = indices(morton::sorted(&points.positions, &bounds, by_content_at));
    let before = std::mem::take(&mut points.file_order);
    let mut points = points.in_order(|place| order[place] as usize);
    points.file_order = match before.is_empty() {
        true => order,
        false => parallel::map_each(&order, |&i| before.get(i as usize).copied().unwrap_or(i)),
    };
    points
}

/// Returns the order in which the positions of a cloud come in canonical order, as far as they alone decide it; `None`
/// if that is the order in which they are.
pub(crate) fn along_curve(positions: &[DVec3]) -> Option<Vec<u32>> {
    let (bounds, count) = (Bounds::of(positions)?, u32::try_from(positions.len()).ok()?);
    let cells = Cells::of(&bounds);
    // Both zeros are one place in a scene.
    let key = |i: u32| (positions[i as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let by_position = |a: u32, b: u32| key(a).cmp(&key(b));
    let are_sorted = keyed::are_sorted(count, |i| cells.code(positions[i as usize]), &by_position);
    (!are_sorted).then(|| indices(morton::sorted(positions, &bounds, by_position)))
}

/// Returns the points of parts of a scene with these bounds, in the order that the whole scene has: for each the part
/// and the place there.
#[doc(hidden)]
pub fn merged(parts: &[Arc<Points>], bounds: &Bounds) -> Vec<[u32; 2]> {
    let cells = Cells::of(bounds);
    let of_part = |part: usize| (0..parts[part].len() as u32).map(|at| [part as u32, at]).collect::<Vec<_>>();
    let all = parallel::gather(parts.len(), of_part).concat();
    let at = |i: u32| {
        let [part, at] = all[i as usize];
        (&*parts[part as usize], at as usize)
    };
    let code = |i: u32| {
        let (points, at) = at(i);
        cells.code(points.positions[at])
    };
    let order = keyed::sorted(all.len() as u32, code, &|a, b| by_content(at(a), at(b)));
    parallel::map_each(&order, |keyed| all[keyed.index as usize])
}

/// The indices alone. They take the memory of what they stood in, of which the rest is given back.
fn indices(keyed: Vec<Keyed>) -> Vec<u32> {
    let mut indices: Vec<u32> = keyed.into_iter().map(|keyed| keyed.index).collect();
    indices.shrink_to_fit();
    indices
}

/// Any fixed total order of the bits; only identical points are equal.
pub(super) fn by_content(a: (&Points, usize), b: (&Points, usize)) -> Ordering {
    let position = |(points, at): (&Points, usize)| points.positions[at].to_array().map(f64::to_bits);
    position(a).cmp(&position(b)).then_with(|| by_look(a, b))
}

/// Returns the part of it that decides between points of equal position.
pub(super) fn by_look(a: (&Points, usize), b: (&Points, usize)) -> Ordering {
    let color = |(points, at): (&Points, usize)| points.colors[at].to_array().map(f32::to_bits);
    let others = |(points, at): (&Points, usize)| {
        let field = points.fields.get(at).map(|field| field.to_bits());
        let normal = points.normals.as_ref().map(|normals| normals[at].to_array().map(f32::to_bits));
        (points.opacities[at].to_bits(), points.radii[at].to_bits(), field, normal)
    };
    color(a).cmp(&color(b)).then_with(|| others(a).cmp(&others(b))).then_with(|| by_gaussian(a, b))
}

/// Compares points by shape and color of Gaussians. A list without any may be part of a scene that has some: its points
/// are none.
fn by_gaussian(a: (&Points, usize), b: (&Points, usize)) -> Ordering {
    match (&a.0.gaussians, &b.0.gaussians) {
        (Some(first), Some(second)) => first.bits(a.1).cmp(second.bits(b.1)),
        (Some(first), None) if first.is_one(a.1) => Ordering::Greater,
        (None, Some(second)) if second.is_one(b.1) => Ordering::Less,
        _ => Ordering::Equal,
    }
}
