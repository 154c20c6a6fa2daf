//! What a scene file holds, with every default applied and every range checked.

use std::path::PathBuf;

use glam::{DVec3, Vec3};

use super::view::View;
use crate::cloud::field::Field;
use crate::io::photo::Photo;
use crate::io::{ColumnNames, Hints};
use crate::passes::bin::Order;

/// Layers that depth peeling goes through at most, since each of them visits every splat.
pub const MAX_LAYERS: u32 = 65_536;

/// `[image]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSettings {
    /// Width and height in pixels, each from 1 to [`MAX_SIDE`](crate::image::MAX_SIDE).
    pub size: [u32; 2],
    /// Linear RGB in [0, 1], whatever `color` says.
    pub background: Vec3,
    /// In which space blending runs.
    pub color: ColorSpace,
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self { size: [1024, 1024], background: Vec3::ZERO, color: ColorSpace::Linear }
    }
}

/// `[camera]` as given, and the view asked for on the command line; [`super::camera`] fills in the rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraSettings {
    /// The eye; ignored if `view` asks for a direction.
    pub eye: Option<DVec3>,
    /// What the camera looks at; ignored if `view` asks for a direction.
    pub target: Option<DVec3>,
    /// Direction of the image's top; ignored if `view` asks for a direction.
    pub up: Option<DVec3>,
    /// Full vertical angle in degrees, in (0, 180); 45 unless `height` is given.
    pub fov_y: Option<f64>,
    /// World units over the image's height: orthographic.
    pub height: Option<f64>,
    /// Nearest depth drawn.
    pub near: Option<f64>,
    /// Farthest depth drawn.
    pub far: Option<f64>,
    /// The direction from which the scene is framed.
    pub view: View,
}

/// `[shadows]`: one share of light per point (Dobrev et al. 2010, Section 6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shadows {
    /// `samples` M: lights that stand for an area light, from 1 to [`MAX_SHADOW_SAMPLES`].
    pub samples: u32,
    /// `light_radius`: degrees around a direction, world units around a position; 0: hard shadows.
    pub light_radius: f32,
    /// `resolution`: columns and rows of the light's image, from 1 to [`MAX_SIDE`](crate::image::MAX_SIDE).
    pub resolution: u32,
    /// `min_layer_distance` d̃ in world units; `None`: 1% of the scene's diagonal.
    pub min_layer_distance: Option<f32>,
}

impl Default for Shadows {
    fn default() -> Self {
        Self { samples: 1, light_radius: 0.0, resolution: 1024, min_layer_distance: None }
    }
}

/// Most samples of an area light.
pub const MAX_SHADOW_SAMPLES: u32 = 65_536;

/// `[[cloud]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudSettings {
    /// The file, relative to the working directory; the name of a generated cloud.
    pub path: PathBuf,
    /// Linear RGB in [0, 1] instead of the file's.
    pub color: Option<Vec3>,
    /// In [0, 1]; the file's alpha multiplies it.
    pub opacity: f32,
    /// World units, not scaled; else the file's own, else Eq. 20.
    pub radius: Option<f32>,
    /// Factor on the radii, wherever they come from, at least 0.
    pub radius_factor: f32,
    /// K of Eq. 20 and 21, at least 1; else that of a prepared file, else 24.
    pub neighbors: Option<usize>,
    /// What tells solid points from soft ones, in the scene's coordinates; else what a prepared file holds, else
    /// uncertainty.
    pub field: Option<Field>,
    /// World units, added after `scale`.
    pub translate: DVec3,
    /// Factor on positions and on the file's own radii, above 0.
    pub scale: f64,
    /// Where a picture stands, before `scale` and `translate`; at the origin if it isn't said.
    pub photo: Option<Photo>,
    /// What the columns of a text file are; by its header or its values if it isn't said.
    pub columns: Option<ColumnNames>,
}

impl CloudSettings {
    /// What the settings say of the file.
    pub fn hints(&self) -> Hints<'_> {
        Hints { photo: self.photo.as_ref(), columns: self.columns.as_ref() }
    }
}

/// A scene: everything a frame is made of but the points themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// `[image]`.
    pub image: ImageSettings,
    /// `[camera]`.
    pub camera: CameraSettings,
    /// `[shading]`.
    pub shading: Shading,
    /// `[[cloud]]`, at least one.
    pub clouds: Vec<CloudSettings>,
    /// `[method]`.
    pub method: MethodChoice,
    /// `[shadows]`, if they were asked for and can be: with a light of its own place or direction, shading and an opaque method.
    pub shadows: Option<Shadows>,
    /// What was given but has no effect, one sentence each.
    pub warnings: Vec<String>,
    /// The keys that were given, those of options included, as one JSON object: the image's `pellucid:settings`.
    pub settings: String,
}

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
    Direction(DVec3),
    /// A position in the world.
    Position(DVec3),
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

/// How lists that are too long for one invocation's registers are sorted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LongLists {
    /// In runs, by many invocations, merged between two buffers.
    #[default]
    Merge,
    /// By one invocation for each list, in the fragment buffer itself.
    InPlace,
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
    /// `long_lists`; of `abuffer` and `linked-list`, which sort lists.
    pub long_lists: LongLists,
}

/// Settings of depth peeling.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Peel {
    /// What is peeled.
    pub discs: Discs,
    /// `layers`: how many are blended, the nearest ones, at most [`MAX_LAYERS`]; 0: all.
    pub layers: u32,
}

/// Samples of a pixel that stochastic transparency takes at most.
pub const MAX_SAMPLES: u32 = 4096;

/// Fragments that `hybrid` composes exactly at most.
pub const MAX_K: u32 = 64;

/// Settings of multi-sample stochastic transparency.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stochastic {
    /// What is sampled.
    pub discs: Discs,
    /// `samples` of each pixel, from 1 to [`MAX_SAMPLES`].
    pub samples: u32,
    /// `alpha_correction`: color scaled by exact over sampled alpha, and exact alpha.
    pub alpha_correction: bool,
}

impl Default for Stochastic {
    fn default() -> Self {
        Self { discs: Discs::default(), samples: 64, alpha_correction: true }
    }
}

/// Settings of hybrid transparency.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hybrid {
    /// What is blended.
    pub discs: Discs,
    /// `k`: fragments that are composed exactly, the nearest ones, from 1 to [`MAX_K`].
    pub k: u32,
}

impl Default for Hybrid {
    fn default() -> Self {
        Self { discs: Discs::default(), k: 8 }
    }
}

/// Settings of opaque screen-aligned splats (`squares`, `circles`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenSplats {
    /// Factor on the radius, at least 0.
    pub size: f32,
    /// Largest pixel radius.
    pub max_pixel_radius: f32,
    /// `raster`, of splats of which the nearest wins; those that are blended go through tiles in compute shaders.
    pub raster: Raster,
}

impl Default for ScreenSplats {
    fn default() -> Self {
        Self { size: 1.0, max_pixel_radius: 25.0, raster: Raster::default() }
    }
}

/// Settings of three-pass splats (`hqs`, `splats`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendedSplats {
    /// Size and clamp.
    pub splats: ScreenSplats,
    /// `blend_depth`: what lies up to so many radii behind the nearest is blended with it, at least 0.
    pub blend_depth: f32,
    /// `shape`, of `hqs`.
    pub shape: SplatShape,
}

impl Default for BlendedSplats {
    fn default() -> Self {
        Self { splats: ScreenSplats::default(), blend_depth: 1.0, shape: SplatShape::default() }
    }
}

/// How dense the spheres of the soft methods are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Density {
    /// `softness`: the opacity of a whole chord through the centre of a sphere of median radius, in [0, 1].
    Softness(f32),
    /// `lambda`: the factor itself, at least 0.
    Lambda(f32),
}

/// `shells`: concentric spheres that stand for one of `soft-concentric`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shells {
    /// As many as its radius in pixels over `pixels_per_shell`, from 1 to [`MAX_SHELLS`].
    #[default]
    Adaptive,
    /// So many, from 1 to [`MAX_SHELLS`].
    Fixed(u32),
}

/// Shells of a sphere at most.
pub const MAX_SHELLS: u32 = 64;

/// `layout`: what is stored of an event of a sphere and a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SoftLayout {
    /// Depth and sphere; all else follows from the sphere.
    #[default]
    Precise,
    /// The paper's 16 bytes: color and distance from the centre in 8 bits each, signed depth, radius, middle.
    Paper,
}

/// Settings of soft transparency (Seemann et al. 2018).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Soft {
    /// `threshold` t: points with a field above it are soft.
    pub threshold: f32,
    /// `softness` or `lambda`.
    pub density: Density,
    /// `modulation` l_m, above t: fields between the two modulate the transparency (Eq. 22).
    pub modulation: Option<f32>,
    /// `shells`, of `soft-concentric`.
    pub shells: Shells,
    /// `pixels_per_shell`, of adaptive shells, above 0.
    pub pixels_per_shell: f32,
    /// `layout`, of `soft-base`.
    pub layout: SoftLayout,
}

impl Default for Soft {
    fn default() -> Self {
        Self {
            threshold: 0.5,
            density: Density::Softness(0.5),
            modulation: None,
            shells: Shells::default(),
            pixels_per_shell: 4.0,
            layout: SoftLayout::default(),
        }
    }
}

/// Settings of `one-layer`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneLayer {
    /// `threshold` t: points with a field above it make the transparent layer.
    pub threshold: f32,
    /// `softness`: the layer's opacity, in [0, 1].
    pub softness: f32,
}

impl Default for OneLayer {
    fn default() -> Self {
        Self { threshold: 0.5, softness: 0.5 }
    }
}

/// Settings of `paraboloid` and `cone`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Interpolated {
    /// Size and clamp.
    pub splats: ScreenSplats,
    /// `shape`.
    pub shape: SplatShape,
}

/// Outline of an opaque splat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SplatShape {
    /// `"circle"`
    #[default]
    Circle,
    /// `"square"`
    Square,
}

/// How far the fragments of an opaque splat move toward the viewer, in drawn radii, at the distance ρ from its centre, in
/// radii (Schütz and Wimmer 2015).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Relief {
    /// Not at all.
    #[default]
    Flat = 0,
    /// 1 − ρ².
    Paraboloid = 1,
    /// 1 − ρ.
    Cone = 2,
    /// √(1 − ρ²).
    Sphere = 3,
}

/// Settings of `image-space` (Dobrev et al. 2010, Section 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSpace {
    /// `fill`: iterations of the filter that fills background pixels, at most [`MAX_ITERATIONS`].
    pub fill: u32,
    /// `occlusion`: iterations of the filter that replaces what is seen through holes, at most [`MAX_ITERATIONS`].
    pub occlusion: u32,
    /// `smooth`: iterations of the low-pass filter, at most [`MAX_ITERATIONS`].
    pub smooth: u32,
    /// `antialias`: whether edges of depth are blended with their neighbors.
    pub antialias: bool,
    /// `antialias_threshold`: the share of an edge from which they are, in [0, 1].
    pub antialias_threshold: f32,
    /// `min_layer_distance` d̃ in world units along z; `None`: 1% of the scene's diagonal.
    pub min_layer_distance: Option<f32>,
    /// `cull`: whether points that face away from the viewer are left out, where there are normals.
    pub cull: bool,
}

impl Default for ImageSpace {
    fn default() -> Self {
        Self {
            fill: 1,
            occlusion: 1,
            smooth: 1,
            antialias: true,
            antialias_threshold: 0.25,
            min_layer_distance: None,
            cull: true,
        }
    }
}

/// Iterations of an image filter at most.
pub const MAX_ITERATIONS: u32 = 256;

/// Settings of `peel-layers` (Dobrev et al. 2010, Sections 4 and 5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeelLayers {
    /// What each layer goes through. Back faces are parts of surfaces too, so that they are not culled unless asked for.
    pub filters: ImageSpace,
    /// `layers`: how many are blended at most, the nearest ones, from 1 to [`MAX_POINT_LAYERS`].
    pub layers: u32,
}

impl Default for PeelLayers {
    fn default() -> Self {
        Self { filters: ImageSpace { cull: false, ..ImageSpace::default() }, layers: 4 }
    }
}

/// Layers of point surfaces at most, since each of them visits every point.
pub const MAX_POINT_LAYERS: u32 = 1024;

/// Settings of `spbr`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spbr {
    /// `ensembles` L, 1 to [`MAX_ENSEMBLES`].
    pub ensembles: u32,
    /// `cos_theta`: whether slanted surfaces are more opaque (Tanaka et al. 2016, Eq. 2), as they are if nothing is done
    /// about it.
    pub cos_theta: bool,
    /// `brighten`: whether the image is brightened as that of `spbr-simplified`.
    pub brighten: bool,
}

impl Default for Spbr {
    fn default() -> Self {
        Self { ensembles: 100, cos_theta: true, brighten: false }
    }
}

/// Settings of `spbr-simplified`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpbrSimplified {
    /// `ensembles` L, 1 to [`MAX_ENSEMBLES`].
    pub ensembles: u32,
    /// `brightness`.
    pub brightness: Brightness,
}

impl Default for SpbrSimplified {
    fn default() -> Self {
        Self { ensembles: 100, brightness: Brightness::Auto }
    }
}

/// The factor p on the colors of an image (Uchida et al. 2020, Section 3.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Brightness {
    /// Such that the image is about as bright as that of a single ensemble.
    Auto,
    /// This, above 0.
    Factor(f32),
}

/// Most ensembles.
pub const MAX_ENSEMBLES: u32 = 65_536;

/// `[method]`: what a scene asks for. [`crate::plan::choose`] makes a [`Method`] of it once points and device are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MethodChoice {
    /// The cheapest method that is exact for the points, for these discs.
    Auto(Discs),
    /// This method.
    Fixed(Method),
}

impl Default for MethodChoice {
    fn default() -> Self {
        Self::Auto(Discs::default())
    }
}

impl From<Method> for MethodChoice {
    fn from(method: Method) -> Self {
        Self::Fixed(method)
    }
}

impl MethodChoice {
    /// The name a scene file gives it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Auto(_) => "auto",
            Self::Fixed(method) => method.name(),
        }
    }

    /// The method that was asked for; `None` for `auto`.
    pub fn fixed(&self) -> Option<&Method> {
        match self {
            Self::Auto(_) => None,
            Self::Fixed(method) => Some(method),
        }
    }

    /// A method that shows the image asked for, whatever the points and the device: of `auto` the A-buffer.
    pub fn representative(&self) -> Method {
        match *self {
            Self::Auto(discs) => Method::ABuffer(discs),
            Self::Fixed(method) => method,
        }
    }

    /// As [`Method::needs_radii`].
    pub fn needs_radii(&self) -> bool {
        self.representative().needs_radii()
    }

    /// As [`Method::needs_field`].
    pub fn needs_field(&self) -> bool {
        self.representative().needs_field()
    }

    /// As [`Method::is_dealt`].
    pub fn is_dealt(&self) -> bool {
        self.representative().is_dealt()
    }

    /// Whether `[shadows]` may apply: to `auto` it does if every point turns out to be opaque.
    pub fn may_take_shadows(&self) -> bool {
        self.fixed().is_none_or(Method::takes_shadows)
    }
}

/// The methods of this version.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// 1-pixel opaque points.
    Points,
    /// Opaque screen-aligned squares.
    Squares(ScreenSplats),
    /// Opaque screen-aligned discs.
    Circles(ScreenSplats),
    /// Opaque splats whose fragments move toward the viewer by a paraboloid, so that splats meet half-way (Schütz and Wimmer
    /// 2015).
    Paraboloid(Interpolated),
    /// The same by a cone.
    Cone(Interpolated),
    /// The same by a sphere.
    Sphere(ScreenSplats),
    /// Exact order-independent transparency (MCTB12).
    ABuffer(Discs),
    /// The same image through linked lists (YHGT10).
    LinkedList(Discs),
    /// Splats sorted once by depth, blended tile by tile; exact for flat discs.
    Sorted(Discs),
    /// The same as the A-buffer by depth peeling.
    Peel(Peel),
    /// Multi-sample stochastic transparency (Enderton et al. 2011).
    Stochastic(Stochastic),
    /// The nearest fragments exactly, an average behind them (MCTB13).
    Hybrid(Hybrid),
    /// Weighted blended transparency (McGuire, Bavoil 2013).
    Weighted(Discs),
    /// Mean color of all fragments, opaque.
    Average(Discs),
    /// Blended in the order of the files.
    Unsorted(Discs),
    /// Opaque screen-aligned splats in three passes.
    Hqs(BlendedSplats),
    /// Opaque splats in their tangent planes in three passes (Botsch et al. 2004).
    Splats(BlendedSplats),
    /// Soft spheres by exact integration (Seemann et al. 2018, Section 3.1).
    SoftBase(Soft),
    /// Soft spheres as concentric ones of constant density (Section 3.2).
    SoftConcentric(Soft),
    /// Soft discs in a presorted order (Section 3.3).
    SoftExpress(Soft),
    /// The first layer transparent, the rest opaque.
    OneLayer(OneLayer),
    /// 1-pixel points whose holes are filled by filters of the image (Dobrev et al. 2010).
    ImageSpace(ImageSpace),
    /// Layers of such points, blended front to back.
    PeelLayers(PeelLayers),
    /// The mean of opaque images of random parts of the points (Tanaka et al. 2016), with a surface's opacity given.
    Spbr(Spbr),
    /// The same with all points, each in one part (Uchida et al. 2020, Section 3.4).
    SpbrSimplified(SpbrSimplified),
}

impl Method {
    /// The methods that blend discs and compute the same image, each with its defaults: what `stress` compares.
    pub fn transparent() -> Vec<Self> {
        vec![
            Self::ABuffer(Discs::default()),
            Self::LinkedList(Discs::default()),
            Self::Sorted(Discs::default()),
            Self::Peel(Peel::default()),
        ]
    }

    /// The name a scene file gives it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Squares(_) => "squares",
            Self::Circles(_) => "circles",
            Self::Paraboloid(_) => "paraboloid",
            Self::Cone(_) => "cone",
            Self::Sphere(_) => "sphere",
            Self::ABuffer(_) => "abuffer",
            Self::LinkedList(_) => "linked-list",
            Self::Sorted(_) => "sorted",
            Self::Peel(_) => "peel",
            Self::Stochastic(_) => "stochastic",
            Self::Hybrid(_) => "hybrid",
            Self::Weighted(_) => "weighted",
            Self::Average(_) => "average",
            Self::Unsorted(_) => "unsorted",
            Self::Hqs(_) => "hqs",
            Self::Splats(_) => "splats",
            Self::SoftBase(_) => "soft-base",
            Self::SoftConcentric(_) => "soft-concentric",
            Self::SoftExpress(_) => "soft-express",
            Self::OneLayer(_) => "one-layer",
            Self::ImageSpace(_) => "image-space",
            Self::PeelLayers(_) => "peel-layers",
            Self::Spbr(_) => "spbr",
            Self::SpbrSimplified(_) => "spbr-simplified",
        }
    }

    /// The settings of the disc family; `None` for other methods.
    pub fn discs(&self) -> Option<&Discs> {
        match self {
            Self::ABuffer(discs)
            | Self::LinkedList(discs)
            | Self::Sorted(discs)
            | Self::Peel(Peel { discs, .. })
            | Self::Stochastic(Stochastic { discs, .. })
            | Self::Hybrid(Hybrid { discs, .. })
            | Self::Weighted(discs)
            | Self::Average(discs)
            | Self::Unsorted(discs) => Some(discs),
            Self::Points
            | Self::Squares(_)
            | Self::Circles(_)
            | Self::Paraboloid(_)
            | Self::Cone(_)
            | Self::Sphere(_)
            | Self::Hqs(_)
            | Self::Splats(_)
            | Self::SoftBase(_)
            | Self::SoftConcentric(_)
            | Self::SoftExpress(_)
            | Self::OneLayer(_)
            | Self::ImageSpace(_)
            | Self::PeelLayers(_)
            | Self::Spbr(_)
            | Self::SpbrSimplified(_) => None,
        }
    }

    /// The settings of a method that collects each pixel's fragments in a list.
    pub fn lists(&self) -> Option<&Discs> {
        match self {
            Self::ABuffer(discs) | Self::LinkedList(discs) => Some(discs),
            _ => None,
        }
    }

    /// The splats of which the nearest one wins on each pixel; `None` for other methods.
    pub fn nearest_splats(&self) -> Option<&ScreenSplats> {
        match self {
            Self::Squares(splats)
            | Self::Circles(splats)
            | Self::Sphere(splats)
            | Self::Paraboloid(Interpolated { splats, .. })
            | Self::Cone(Interpolated { splats, .. }) => Some(splats),
            _ => None,
        }
    }

    /// Who shall visit the pixels of its splats.
    pub fn raster(&self) -> Raster {
        let nearest = self.nearest_splats().map(|splats| splats.raster);
        nearest.or(self.discs().map(|discs| discs.raster)).unwrap_or_default()
    }

    /// How far its fragments move toward the viewer.
    pub fn relief(&self) -> Relief {
        match self {
            Self::Paraboloid(_) => Relief::Paraboloid,
            Self::Cone(_) => Relief::Cone,
            Self::Sphere(_) => Relief::Sphere,
            _ => Relief::Flat,
        }
    }

    /// Whether it goes through tiles of splats, and needs no lists of fragments.
    pub fn is_tiled(&self) -> bool {
        self.discs().is_some() && self.lists().is_none() && !matches!(self, Self::Peel(_))
    }

    /// The order in which it wants splats.
    pub fn order(&self) -> Order {
        match self {
            Self::Stochastic(_) | Self::Weighted(_) | Self::Average(_) => Order::Index,
            Self::Hqs(_) | Self::Splats(_) | Self::OneLayer(_) => Order::Index,
            Self::Unsorted(_) => Order::File,
            _ => Order::Depth,
        }
    }

    /// The settings of soft transparency; `None` for other methods.
    pub fn soft(&self) -> Option<&Soft> {
        match self {
            Self::SoftBase(soft) | Self::SoftConcentric(soft) | Self::SoftExpress(soft) => Some(soft),
            _ => None,
        }
    }

    /// The field above which points are soft, if the method tells them from solid ones.
    pub fn threshold(&self) -> Option<f32> {
        match self {
            Self::OneLayer(settings) => Some(settings.threshold),
            _ => self.soft().map(|soft| soft.threshold),
        }
    }

    /// Whether the image depends on the points' scalar field.
    pub fn needs_field(&self) -> bool {
        self.threshold().is_some()
    }

    /// Whether the image depends on the points' radii, so that missing ones must be estimated.
    pub fn needs_radii(&self) -> bool {
        !matches!(self, Self::Points | Self::ImageSpace(_) | Self::PeelLayers(_)) && !self.is_dealt()
    }

    /// The filters of the image, of methods that have some.
    pub fn filters(&self) -> Option<&ImageSpace> {
        match self {
            Self::ImageSpace(filters) | Self::PeelLayers(PeelLayers { filters, .. }) => Some(filters),
            _ => None,
        }
    }

    /// Whether `[shadows]` applies to it.
    pub fn takes_shadows(&self) -> bool {
        matches!(
            self,
            Self::Points
                | Self::Squares(_)
                | Self::Circles(_)
                | Self::Paraboloid(_)
                | Self::Cone(_)
                | Self::Sphere(_)
                | Self::Hqs(_)
                | Self::Splats(_)
                | Self::ImageSpace(_)
                | Self::PeelLayers(_)
        )
    }

    /// Whether it wants points in random order, cloud after cloud ([`Dealt`](crate::prepare::ensembles::Dealt)).
    pub fn is_dealt(&self) -> bool {
        self.ensembles().is_some()
    }

    /// L of the methods that deal points to ensembles; `None` for other methods.
    pub fn ensembles(&self) -> Option<u32> {
        match self {
            Self::Spbr(Spbr { ensembles, .. }) | Self::SpbrSimplified(SpbrSimplified { ensembles, .. }) => {
                Some(*ensembles)
            }
            _ => None,
        }
    }
}
