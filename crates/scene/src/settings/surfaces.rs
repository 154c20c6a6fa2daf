//! Surfaces of points that are closed in the image.

use crate::schema::{Range, Slider, ValueKind, settings, value};
use crate::setting::Setting;
use crate::tree;

/// Iterations of an image filter at most.
pub const MAX_ITERATIONS: u32 = 256;
/// Iterations of [`Iterations::Auto`] at most.
pub const MAX_AUTO_ITERATIONS: u32 = 64;

/// Iterations of a filter that closes holes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Iterations {
    /// Until an iteration changes no pixel (Dobrev et al. 2010, Section 3.2), at most [`MAX_AUTO_ITERATIONS`].
    Auto,
    /// Fixed number, up to [`MAX_ITERATIONS`].
    Count(u32),
}

impl Iterations {
    /// Returns the largest number of iterations that may change something.
    pub fn most(self) -> u32 {
        match self {
            Self::Auto => MAX_AUTO_ITERATIONS,
            Self::Count(count) => count,
        }
    }
}

value! {
    Iterations => ValueKind::WordOr("auto", &ValueKind::Integer(0, MAX_ITERATIONS));
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(_)) => table.choice(key, &[("auto", Iterations::Auto)]),
        _ => Ok(table.integer(key, 0, MAX_ITERATIONS)?.map(Iterations::Count)),
    };
    |iterations| Some(match *iterations {
        Iterations::Auto => Setting::from("auto"),
        Iterations::Count(count) => Setting::Integer(count),
    });
}

settings! {
    /// Settings of `image-space` (Dobrev et al. 2010, Section 3).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct ImageSpace {
        /// Iterations that fill background pixels between points; auto: until nothing changes, at most 64.
        fill: Iterations = Iterations::Count(1), unit "iterations", start 4.0, slider Slider::Count(0, 16);
        /// Iterations that replace points seen through holes; auto: until nothing changes, at most 64.
        occlusion: Iterations = Iterations::Count(1), unit "iterations", start 4.0, slider Slider::Count(0, 16);
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
        /// Number of the one layer that is shown, counted from the nearest; `layers` then has no effect.
        only: Option<u32> = None, in 1..=MAX_POINT_LAYERS, without "all layers", start 1.0, slider Slider::Count(1, 32);
    }
}

impl PeelLayers {
    /// Returns the number of layers that have to be peeled: those behind the one that is shown are not needed.
    pub fn peeled(&self) -> u32 {
        self.only.unwrap_or(self.layers)
    }
}
