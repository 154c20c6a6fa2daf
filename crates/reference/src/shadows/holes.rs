//! How much of a light's image some points cover, and the holes that the filters leave there.

use glam::{DVec2, DVec3};

use super::{Map, filtered, unfiltered};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;
use pellucid_core::points::Points;

/// Returns how many of a light's images its points' box covers: of a cube of images all six, of a single one the share
/// of its pixels, from the areas of those sides of the box that face the light.
pub fn covered(light: &[Camera], bounds: &Bounds) -> f64 {
    let [camera] = light else { return light.len() as f64 };
    let corners = bounds.corners();
    let place = |corner: usize| camera.project(corners[corner], [1, 1]).0;
    // Bit k of a corner's number says if it has the larger coordinate along axis k.
    let side = |axis: usize, high: usize| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let first = high << axis;
        let ring = [first, first | u, first | u | v, first | v];
        let normal = DVec3::AXES[axis] * (2.0 * high as f64 - 1.0);
        let middle = (corners[ring[0]] + corners[ring[2]]) / 2.0;
        let ray = match camera.projection {
            Projection::Orthographic { .. } => camera.forward,
            Projection::Perspective { .. } => middle - camera.eye,
        };
        if normal.dot(ray) < 0.0 { area(ring.map(place)) } else { 0.0 }
    };
    (0..3).map(|axis| side(axis, 0) + side(axis, 1)).sum()
}

/// Area of a polygon.
fn area(ring: [DVec2; 4]) -> f64 {
    let next = |i: usize| ring[(i + 1) % ring.len()];
    0.5 * (0..ring.len()).map(|i| ring[i].perp_dot(next(i))).sum::<f64>().abs()
}

/// Returns the pixels of a light's image that lie in a surface, those of them that are holes, those that show points,
/// and the holes that do. Blocks have `block` columns and rows, from the upper left corner on; a block lies in a
/// surface if it and the eight around it have points, which is as far as the farthest of their nearest points. A pixel
/// there is a hole if after the filters it shows nothing, or what is more than d̃ behind.
pub fn holes(camera: &Camera, map: Map, points: &Points, block: u32) -> [u64; 4] {
    let nearest = unfiltered(camera, map.resolution, points);
    let pixel = |x: u32, y: u32| (y * map.resolution + x) as usize;
    // The nearest of a block that may lie outside of the image.
    let least = |column: i64, row: i64| {
        let of = |at: i64| (at * i64::from(block)..(at + 1) * i64::from(block)).filter_map(|at| u32::try_from(at).ok());
        let inside = |at: &u32| *at < map.resolution;
        let all = of(row).filter(inside).flat_map(|y| of(column).filter(inside).map(move |x| pixel(x, y)));
        all.map(|at| nearest.depth[at]).fold(f64::INFINITY, f64::min)
    };
    let surface = |column: i64, row: i64| {
        let around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (column + right, row + down)));
        around.map(|(column, row)| least(column, row)).fold(f64::NEG_INFINITY, f64::max)
    };
    let after = filtered(nearest.clone(), map);
    let mut found = [0; 4];
    let side = map.resolution.div_ceil(block);
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        let surface = surface(column.into(), row.into());
        if surface.is_infinite() {
            continue;
        }
        let end = |at: u32| ((at + 1) * block).min(map.resolution);
        for (x, y) in (row * block..end(row)).flat_map(|y| (column * block..end(column)).map(move |x| (x, y))) {
            let depth = after.depth[pixel(x, y)];
            let (is_hole, is_shown) = (depth > surface + map.distance, depth.is_finite());
            for (count, is) in found.iter_mut().zip([true, is_hole, is_shown, is_hole && is_shown]) {
                *count += u64::from(is);
            }
        }
    }
    found
}
