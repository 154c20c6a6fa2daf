//! `peel-layers` (Dobrev, Rosenthal, Linsen 2010, Sections 4 and 5): layers of point surfaces at least d̃ apart, each
//! of them filtered as an image of its own, blended front to back.

mod ranges;

use glam::DVec3;

pub use ranges::ranges;

use super::ReferencePicture;
use super::image_space::{self, Layer};
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_scene::PeelLayers;

/// Returns up to `settings.layers` layers after their filters, nearest first, until one is empty. In each pixel a
/// layer's points lie at least d̃ behind the filtered depth of the layer before it; where that is background, the pixel
/// is empty.
pub fn layers(camera: &Camera, size: [u32; 2], points: &Points, colors: &[DVec3], settings: &PeelLayers) -> Vec<Layer> {
    let filters = &settings.filters;
    let distance = image_space::layer_distance(filters.min_layer_distance, points);
    let mut from = vec![f64::NEG_INFINITY; size[0] as usize * size[1] as usize];
    let mut layers = Vec::new();
    while layers.len() < settings.layers as usize {
        let found = image_space::nearest(camera, size, points, filters.cull, &from);
        if found.iter().all(Option::is_none) {
            break;
        }
        let layer = image_space::layer(size, &found, colors, |index| f64::from(points.opacities[index]));
        let layer = layer.filtered(filters, distance, camera.far);
        // However small the distance is, a layer is not its own next one.
        from = layer.depth.iter().map(|depth| (depth + distance).max(depth.next_up())).collect();
        layers.push(layer);
    }
    layers
}

/// Front to back: C = Σ Tᵢ·Cᵢ with premultiplied Cᵢ and Tᵢ = Π (1 − αⱼ) of the layers before. The depth is that of the
/// first layer with α > 0, which is +∞ on the softened rim of one; the count is the number of layers that are not
/// background there.
pub fn blend(size: [u32; 2], layers: &[Layer]) -> ReferencePicture {
    let pixels = size[0] as usize * size[1] as usize;
    let (mut rgba, mut depth, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    for pixel in 0..pixels {
        let mut sum = [0.0; 4];
        let mut transmittance = 1.0;
        for layer in layers {
            let front = layer.rgba[pixel];
            for (sum, front) in sum.iter_mut().zip(front) {
                *sum += transmittance * front;
            }
            transmittance *= 1.0 - front[3];
        }
        let seen = layers.iter().find(|layer| layer.rgba[pixel][3] > 0.0);
        rgba.push(sum);
        depth.push(seen.map_or(f64::INFINITY, |layer| layer.depth[pixel]));
        counts.push(layers.iter().filter(|layer| layer.depth[pixel].is_finite()).count() as u32);
    }
    ReferencePicture { width: size[0], height: size[1], rgba, depth, counts }
}

/// Returns the whole image; its counts are those of the layers of each pixel. `colors` holds a color for each point,
/// shaded and in the space that blending runs in ([`super::shading::shade`]).
pub fn render(
    camera: &Camera,
    size: [u32; 2],
    points: &Points,
    colors: &[DVec3],
    settings: &PeelLayers,
) -> ReferencePicture {
    blend(size, &layers(camera, size, points, colors, settings))
}
