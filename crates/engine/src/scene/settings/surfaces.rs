//! Surfaces of points that are closed in the image.

use crate::scene::schema::{Range, Slider, settings};

/// Iterations of an image filter at most.
pub const MAX_ITERATIONS: u32 = 256;

settings! {
    /// Settings of `image-space` (Dobrev et al. 2010, Section 3).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct ImageSpace {
        /// How often background pixels between points are filled.
        fill: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// How often points seen through holes are replaced.
        occlusion: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// How often the picture is smoothed.
        smooth: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// Blends the edges of surfaces with their neighbors.
        antialias: bool = true;
        /// Share of an edge from which it is blended.
        antialias_threshold: f32 = 0.25, in Range::UNIT;
        /// Surfaces are at least so far apart along the view.
        min_layer_distance: Option<f32> = None, in Range::POSITIVE, unit "world units",
            without "1% of the scene's diagonal", start 0.01, slider Slider::Lengths(1e-5, 1.0);
        /// Leaves out points that face away, where there are normals.
        cull: bool = true;
    }
}

/// Layers of point surfaces at most, since each of them visits every point.
pub const MAX_POINT_LAYERS: u32 = 1024;

settings! {
    /// Settings of `peel-layers` (Dobrev et al. 2010, Sections 4 and 5).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct PeelLayers {
        /// Filters of each layer. Back faces are parts of surfaces too, so that they are not culled unless asked for.
        filters: ImageSpace = ImageSpace { cull: false, ..ImageSpace::default() };
        /// Layers that are peeled and blended at most, the nearest ones.
        layers: u32 = 4, in 1..=MAX_POINT_LAYERS, slider Slider::Count(1, 32), refines true;
    }
}
