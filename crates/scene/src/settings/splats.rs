//! Opaque splats.

use super::discs::Raster;
use crate::schema::{Range, Slider, settings, words};

settings! {
    /// Settings of opaque screen-aligned splats (`squares`, `circles`).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct ScreenSplats {
        /// Factor on the radius of splats.
        size: f32 = 1.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 4.0);
        /// Largest radius of a splat.
        max_pixel_radius: f32 = 25.0, in Range::NOT_NEGATIVE, unit "pixels", slider Slider::Linear(0.0, 100.0);
        /// Radius of every splat on the screen, in place of radii in the world; `size` does not multiply it.
        pixel_radius: Option<f32> = None, in Range::NOT_NEGATIVE, unit "pixels", without "radii in the world",
            start 2.0, slider Slider::Linear(0.0, 16.0), only &["squares", "circles", "paraboloid", "cone", "sphere"];
        /// Rasterization by compute shaders or by the hardware rasterizer; the picture is the same.
        raster: Raster = Raster::Auto, only &["squares", "circles", "paraboloid", "cone", "sphere"];
    }
}

settings! {
    /// Settings of three-pass splats (`hqs`, `splats`).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct BlendedSplats {
        /// Size and clamp.
        splats: ScreenSplats = ScreenSplats::default();
        /// Depth, in radii behind the nearest splat, within which others are blended with it.
        blend_depth: f32 = 1.0, in Range::NOT_NEGATIVE, unit "radii", slider Slider::Linear(0.0, 4.0);
        /// Outline of a splat.
        shape: SplatShape = SplatShape::Circle, only &["hqs"];
    }
}

settings! {
    /// Settings of `paraboloid` and `cone`.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Interpolated {
        /// Size and clamp.
        splats: ScreenSplats = ScreenSplats::default();
        /// Outline of a splat.
        shape: SplatShape = SplatShape::Circle;
    }
}

words! {
    /// Outline of an opaque splat.
    pub enum SplatShape {
        /// A disc.
        Circle = "circle",
        /// A square.
        Square = "square",
    }
}
