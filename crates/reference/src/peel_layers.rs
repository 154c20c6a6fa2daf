//! `peel-layers` (Dobrev, Rosenthal, Linsen 2010, Sections 4 and 5): layers of point surfaces at least d̃ apart, each
//! of them filtered as an image of its own, blended front to back.

mod ranges;

use glam::DVec3;

pub use ranges::ranges;

use super::fragments::Composite;
use super::image_space::{self, Layer};
use super::{ReferencePicture, View};
use pellucid_core::points::Points;
use pellucid_scene::PeelLayers;

/// Returns up to `settings.layers` layers after their filters, nearest first, until one is empty; none behind
/// `settings.only`. In each pixel a layer's points lie at least d̃ behind the filtered depth of the layer before it;
/// where that is background, the pixel is empty.
pub fn layers(view: View, points: &Points, colors: &[DVec3], settings: &PeelLayers) -> Vec<Layer> {
    let filters = &settings.filters;
    let distance = image_space::layer_distance(filters.min_layer_distance, points);
    let mut from = vec![f64::NEG_INFINITY; view.pixels()];
    let mut layers = Vec::new();
    while layers.len() < settings.peeled() as usize {
        let found = image_space::nearest(view, points, filters.cull, &from);
        if found.iter().all(Option::is_none) {
            break;
        }
        let layer = image_space::layer(view.size, &found, colors, |index| f64::from(points.opacities[index]));
        let layer = layer.filtered(filters, distance, view.camera.far);
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
    let pixel = |pixel: usize| {
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
        let [r, g, b, alpha] = sum;
        let depth = seen.map_or(f64::INFINITY, |layer| layer.depth[pixel]);
        let count = layers.iter().filter(|layer| layer.depth[pixel].is_finite()).count() as u32;
        (Composite { color: DVec3::new(r, g, b), alpha, depth }, count)
    };
    ReferencePicture::of(size, (0..size[0] as usize * size[1] as usize).map(pixel))
}

/// Returns the layers that are shown: all, or a single one, which may not be there.
fn shown<'a, L>(layers: &'a [L], settings: &PeelLayers) -> &'a [L] {
    let Some(only) = settings.only else { return layers };
    let place = only as usize - 1;
    layers.get(place..=place).unwrap_or_default()
}

/// Returns the whole image; its counts are those of the layers of each pixel that are shown. `colors` holds a color for
/// each point, shaded and in the space that blending runs in ([`super::shading::shade`]).
pub fn render(view: View, points: &Points, colors: &[DVec3], settings: &PeelLayers) -> ReferencePicture {
    blend(view.size, shown(&layers(view, points, colors, settings), settings))
}
