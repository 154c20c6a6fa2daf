//! Transparency of discs in the order of their centres: each pixel composes the discs that cover it by the depth of
//! their centres, regardless of their depth in that pixel.

use glam::DVec3;

use super::Picture;
use super::abuffer::{Composite, Fragment, composite, splat};
use super::coverage::footprint;
use crate::camera::Camera;
use crate::points::Points;
use crate::scene::{Discs, Falloff};

/// The points by the depth of their centres along the viewing axis; equal depths by their place in the canonical order.
pub fn order(camera: &Camera, points: &Points) -> Vec<usize> {
    let depths: Vec<f64> = points.positions.iter().map(|p| camera.to_view(*p).z).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| depths[a].total_cmp(&depths[b]).then(a.cmp(&b)));
    order
}

/// Fragments of each pixel in the order of their centres; z is the fragment's own depth in the pixel.
pub fn lists(camera: &Camera, size: [u32; 2], points: &Points, discs: &Discs) -> Vec<Vec<Fragment>> {
    let mut pixels = vec![Vec::new(); size[0] as usize * size[1] as usize];
    for index in order(camera, points) {
        for covered in footprint(camera, size, &splat(points, index, discs.shape)) {
            let falloff = match discs.falloff {
                Falloff::Flat => 1.0,
                Falloff::Gaussian => (-2.0 * covered.rho.powi(2)).exp(),
            };
            let alpha = falloff * f64::from(points.opacities[index]);
            let list: &mut Vec<Fragment> = &mut pixels[covered.y as usize * size[0] as usize + covered.x as usize];
            list.push(Fragment { z: covered.z, index: index as u32, alpha });
        }
    }
    pixels
}

/// The whole image. `colors` holds a color for each point, shaded and in the space that blending runs in
/// ([`super::shading::shade`]).
pub fn render(camera: &Camera, size: [u32; 2], points: &Points, colors: &[DVec3], discs: &Discs) -> Picture {
    let lists = lists(camera, size, points, discs);
    let pixels: Vec<Composite> = lists.iter().map(|list| composite(list, colors)).collect();
    Picture {
        width: size[0],
        height: size[1],
        rgba: pixels.iter().map(|p| p.color.extend(p.alpha).to_array()).collect(),
        depth: pixels.iter().map(|p| p.depth).collect(),
        counts: lists.iter().map(|list| list.len() as u32).collect(),
    }
}
