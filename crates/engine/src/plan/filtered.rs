//! The passes of methods that filter the image of 1-pixel points.

use super::{POINTS, Plan};
use crate::gpu::Device;
use crate::methods::image_space::Filter;
use crate::methods::{Facts, Frame};
use crate::scene::ImageSpace;

/// The passes of filtered images.
pub(super) const PASSES: [&str; 10] = [
    "image-space/clear",
    "image-space/measure",
    "image-space/resolve",
    "image-space/list",
    "image-space/fill",
    "image-space/occlusion",
    "image-space/smooth",
    "image-space/antialias",
    "image-space/summary",
    "image-space/deliver",
];
/// The passes that layers of them have besides.
pub(super) const LAYERS: [&str; 4] =
    ["peel-layers/clear", "peel-layers/next", "peel-layers/blend", "peel-layers/summary"];

/// The pass of a filter, how often it was asked for, and what for.
fn asked(filter: Filter, filters: &ImageSpace) -> (&'static str, u32, &'static str) {
    match filter {
        Filter::Fill => ("image-space/fill", filters.fill, "background beside points"),
        Filter::Occlusion => ("image-space/occlusion", filters.occlusion, "points that others lie d~ before"),
        Filter::Smooth => ("image-space/smooth", filters.smooth, "points"),
        Filter::Antialias => ("image-space/antialias", u32::from(filters.antialias), "edges of depth"),
    }
}

impl Plan {
    /// What finds the nearest points.
    pub(super) fn filtered_points(
        &mut self,
        device: &Device,
        frame: &Frame,
        facts: &Facts,
        wide: bool,
        filters: &ImageSpace,
        why: &str,
    ) {
        let layered = crate::methods::image_space::layers(&frame.method).is_some();
        self.add("image-space/clear", true, "nearest points and work lists start empty");
        if layered {
            self.add("peel-layers/clear", true, "no layer is counted yet");
            self.add("image/clear", true, "pixels without layers stay empty");
        }
        let culled = if filters.cull { "points that face away are left out" } else { "points that face away stay" };
        let any = facts.points > 0;
        let reason = if any { format!("{why}; {culled}") } else { "there are no points".to_owned() };
        self.nearest(device, POINTS, any, wide, reason);
    }

    /// What makes an image of them, filters it, and puts layer behind layer.
    pub(super) fn filters(
        &mut self,
        frame: &Frame,
        facts: &Facts,
        filters: &ImageSpace,
        layers: Option<u32>,
        shading: &str,
    ) {
        let tiles = facts.image_tiles;
        self.add("image-space/measure", true, format!("what each of {tiles} tiles holds"));
        if let Some(most) = layers {
            let reason = format!("{} layers of at most {most} have points; one without empties the rest", facts.layers);
            self.add("peel-layers/next", true, reason);
        }
        self.add("image-space/list", true, "each pass gets the tiles it may change");
        self.add("image-space/resolve", true, format!("index of the nearest point to color; {shading}"));
        for (filter, listed) in Filter::ALL.into_iter().zip(facts.filtered_tiles) {
            let (name, iterations, what) = asked(filter, filters);
            let reason = match iterations {
                0 => "switched off".to_owned(),
                _ => format!("{iterations} iteration(s) over tiles with {what}: {listed} of {tiles} tiles"),
            };
            // Its dispatches are there, if empty: what an image holds the host does not know.
            self.add(name, iterations > 0, reason);
        }
        self.add("image-space/summary", true, "how many tiles each filter had");
        if layers.is_some() {
            self.add("peel-layers/blend", true, "each layer lies behind those before");
            self.add("peel-layers/summary", true, "between batches of layers the host looks whether there are more");
        } else {
            let [width, height] = frame.size;
            self.add("image/clear", true, "tiles of background alone are not delivered");
            self.add("image-space/deliver", true, format!("from tiles to {width} × {height} pixels"));
        }
        self.rest(&PASSES, "layers are blended, not delivered by themselves");
    }
}
