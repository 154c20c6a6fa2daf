//! Surfaces of points that are closed in the image.

use crate::schema::{Range, Slider, settings};

/// Iterations of an image filter at most.
pub const MAX_ITERATIONS: u32 = 256;

settings! {
    /// Settings of `image-space` (Dobrev et al. 2010, Section 3).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct ImageSpace {
        /// Iterations that fill background pixels between points.
        fill: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// Iterations that replace points seen through holes.
        occlusion: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// Iterations that smooth the picture.
        smooth: u32 = 1, in 0..=MAX_ITERATIONS, unit "iterations", slider Slider::Count(0, 16);
        /// Blend the edges of surfaces with their neighbors.
        antialias: bool = true;
        /// Smallest share of an edge that is blended.
        antialias_threshold: f32 = 0.25, in Range::UNIT;
        /// Smallest distance between surfaces along the view.
        min_layer_distance: Option<f32> = None, in Range::POSITIVE, unit "world units",
            without "1% of the scene's diagonal", start 0.01, slider Slider::Lengths(1e-5, 1.0);
        /// Leave out points that face away, if they have normals.
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
        /// Largest number of nearest layers that are peeled and blended.
        layers: u32 = 4, in 1..=MAX_POINT_LAYERS, slider Slider::Count(1, 32), refines true;
    }
}
