//! What a scene file holds, with every default applied and every range checked.

/// In which space blending runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorSpace {
    /// Linear light.
    #[default]
    Linear,
    /// The stored sRGB values as they are.
    Encoded,
}

/// `[shading] model`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShadingModel {
    /// Colors as they are.
    #[default]
    None,
    /// c·(ambient + diffuse·max(0, n·l)).
    Lambert,
    /// Lambert plus specular·max(0, r·v)^shininess.
    Phong,
}

/// `[shading] light`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Light {
    /// At the eye (perspective) or against the viewing direction (orthographic).
    #[default]
    Headlight,
    /// The direction in which the light travels, world space, not zero.
    Direction(glam::DVec3),
    /// A position in the world.
    Position(glam::DVec3),
}

/// `[shading]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// The formula.
    pub model: ShadingModel,
    /// Ambient factor, at least 0.
    pub ambient: f32,
    /// Diffuse factor, at least 0.
    pub diffuse: f32,
    /// Specular factor, at least 0.
    pub specular: f32,
    /// Phong exponent, at least 0.
    pub shininess: f32,
    /// The light.
    pub light: Light,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            model: ShadingModel::None,
            ambient: 0.2,
            diffuse: 0.8,
            specular: 0.0,
            shininess: 32.0,
            light: Light::Headlight,
        }
    }
}

/// Depth and tilt of a transparent disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiscShape {
    /// Screen-aligned; one depth, that of the centre.
    #[default]
    Flat,
    /// A disc in the tangent plane, with a depth for each pixel; flat where a point has no normal.
    Oriented,
}

/// How opacity falls toward a disc's rim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Falloff {
    /// Constant.
    #[default]
    Flat,
    /// opacity·exp(−2ρ²), ρ = distance / radius, at most 1.
    Gaussian,
}

/// Who walks a splat's pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Raster {
    /// Whichever is expected to be faster on this device for these splats.
    #[default]
    Auto,
    /// Compute shaders.
    Compute,
    /// The rasteriser, with atomics in the fragment shader.
    Hardware,
}

/// Settings of the disc family (`abuffer` and its relatives).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Discs {
    /// `shape`.
    pub shape: DiscShape,
    /// `falloff`.
    pub falloff: Falloff,
    /// `raster`.
    pub raster: Raster,
}

/// Settings of opaque screen-aligned splats (`squares`, `circles`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenSplats {
    /// Factor on the radius, at least 0.
    pub size: f32,
    /// Largest pixel radius.
    pub max_pixel_radius: f32,
}

impl Default for ScreenSplats {
    fn default() -> Self {
        Self { size: 1.0, max_pixel_radius: 25.0 }
    }
}

/// `[method]`: the methods of this version.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Method {
    /// The cheapest exact one for the scene.
    #[default]
    Auto,
    /// 1-pixel opaque points.
    Points,
    /// Opaque screen-aligned squares.
    Squares(ScreenSplats),
    /// Opaque screen-aligned discs.
    Circles(ScreenSplats),
    /// Exact order-independent transparency (MCTB12).
    ABuffer(Discs),
}
