//! The part of a window drawn by egui, on top of the picture.

use std::collections::{BTreeSet, HashMap};

use ash::vk;
use egui::epaint::ImageDelta;
use egui::{ClippedPrimitive, ColorImage, ImageData, TextureId, TextureOptions, TexturesDelta};
use egui_ash_renderer::{DynamicRendering, Options, Renderer, RendererError};

use pellucid_gpu::{Context, Error};

/// The drawing to show, from [`egui::FullOutput`].
pub struct Drawing {
    /// Triangles, clipped.
    pub primitives: Vec<ClippedPrimitive>,
    /// Textures that are new, changed or no longer needed.
    pub textures: TexturesDelta,
    /// Physical pixels of a point.
    pub pixels_per_point: f32,
}

/// The complete content of egui's textures; egui itself reports each change once.
#[derive(Default)]
pub struct Textures(HashMap<TextureId, (ColorImage, TextureOptions)>);

/// Draws with egui's own textures.
pub struct Painter {
    renderer: Renderer,
    /// The textures as they are. The renderer would let go of what surrounds a part that changes; it gets all of it
    /// instead.
    pub textures: Textures,
    /// Textures whose current content is not on the device yet.
    stale: BTreeSet<TextureId>,
}

fn failed(error: RendererError) -> Error {
    match error {
        RendererError::Vulkan(vk::Result::ERROR_DEVICE_LOST) => Error::Lost { during: "drawing the panel".into() },
        RendererError::Vulkan(result) => Error::Vulkan { call: "drawing the panel", result },
        error => Error::NoSurface(format!("the panel can't be drawn ({error})")),
    }
}

impl Painter {
    /// Starts with the textures of an earlier screen, if it had any.
    pub fn new(context: &Context, format: vk::Format, textures: Textures) -> Result<Self, Error> {
        let target = DynamicRendering { color_attachment_format: format, depth_attachment_format: None };
        let (raw, device) = (&context.instance.raw, context.device.clone());
        let renderer = Renderer::with_default_allocator(raw, context.physical, device, target, Options::default());
        let stale = textures.0.keys().copied().collect();
        Ok(Self { renderer: renderer.map_err(failed)?, textures, stale })
    }

    /// Takes in textures that are new or have changed.
    pub fn take_in(&mut self, set: &[(TextureId, ImageDelta)]) {
        for (id, delta) in set {
            let ImageData::Color(part) = &delta.image;
            match (delta.pos, self.textures.0.get_mut(id)) {
                (Some(at), Some((texture, _))) => insert(texture, part, at),
                _ => {
                    self.textures.0.insert(*id, (ColorImage::clone(part), delta.options));
                }
            }
            self.stale.insert(*id);
        }
    }

    /// Returns `true` if [`Self::bring_textures`] has something to do.
    pub fn is_stale(&self) -> bool {
        !self.stale.is_empty()
    }

    /// Uploads textures; no drawing that uses them may be in flight. The caller holds the queue. Failed uploads are
    /// retried the next time.
    pub fn bring_textures(&mut self, context: &Context, pool: vk::CommandPool) -> Result<(), Error> {
        let whole = |id: &TextureId| {
            self.textures.0.get(id).map(|(texture, options)| (*id, ImageDelta::full(texture.clone(), *options)))
        };
        let whole: Vec<_> = self.stale.iter().filter_map(whole).collect();
        self.renderer.set_textures(context.queue, pool, &whole).map_err(failed)?;
        self.stale.clear();
        Ok(())
    }

    /// Frees textures; nothing that was drawn with them is still under way.
    pub fn free_textures(&mut self, ids: &[TextureId]) -> Result<(), Error> {
        for id in ids {
            self.textures.0.remove(id);
            self.stale.remove(id);
        }
        self.renderer.free_textures(ids).map_err(failed)
    }

    /// Records the draws, inside of rendering to an image of this extent.
    pub fn record(&mut self, commands: vk::CommandBuffer, extent: vk::Extent2D, what: &Drawing) -> Result<(), Error> {
        self.renderer.cmd_draw(commands, extent, what.pixels_per_point, &what.primitives).map_err(failed)
    }
}

/// Copies a part of a texture to its position; anything outside is dropped.
fn insert(texture: &mut ColorImage, part: &ColorImage, [x, y]: [usize; 2]) {
    let [width, height] = texture.size;
    for row in 0..part.height().min(height.saturating_sub(y)) {
        let columns = part.width().min(width.saturating_sub(x));
        let (from, to) = (row * part.width(), (y + row) * width + x);
        texture.pixels[to..to + columns].copy_from_slice(&part.pixels[from..from + columns]);
    }
}

#[cfg(test)]
mod tests {
    use egui::Color32;

    use super::*;

    #[test]
    fn a_part_of_a_texture_goes_to_its_place() {
        let mut texture = ColorImage::filled([3, 2], Color32::BLACK);
        insert(&mut texture, &ColorImage::filled([2, 5], Color32::WHITE), [1, 1]);
        let white: Vec<bool> = texture.pixels.iter().map(|pixel| *pixel == Color32::WHITE).collect();
        assert_eq!(white, [false, false, false, false, true, true]);
    }
}
