//! The content of a scene file, with every default applied and every range checked.

mod camera;
mod classes;
mod clip;
mod cloud;
mod coloring;
mod detail;
mod discs;
mod ensembles;
mod image;
mod shading;
mod soft;
mod splats;
mod strays;
mod surfaces;

pub use camera::{CameraSettings, Frame};
pub use classes::{ClassSettings, Selection};
pub use clip::{Clip, ClipShape};
pub(super) use cloud::FIELD_KEYS;
pub use cloud::{CloudSettings, Primitive};
pub use coloring::{ColorBy, ColorRange, ColorSettings, ColormapName};
pub use detail::Detail;
pub use discs::{
    DiscShape, Discs, Falloff, GaussianSettings, Hybrid, Kernel, LongLists, MAX_K, MAX_LAYERS, MAX_NODES, MAX_RANK,
    MAX_SAMPLES, Mlab, MomentCount, Moments, Order, Peel, Raster, Stochastic, Tail, Wavelet,
};
pub use ensembles::{Brightness, MAX_ENSEMBLES, Spbr, SpbrSimplified};
pub use image::{Background, ImageSettings, Samples};
pub use pellucid_core::color::ColorSpace;
pub use pellucid_core::light::Light;
pub use shading::{Edl, Formula, MAX_SHADOW_SAMPLES, MapResolution, Shading, ShadingModel, ShadowMethod, Shadows};
pub use soft::{Density, MAX_SHELLS, OneLayer, Shells, Soft, SoftLayout};
pub use splats::{BlendedSplats, Interpolated, ScreenSplats, SplatShape};
pub use strays::{Outliers, Strays};
pub use surfaces::{ImageSpace, Iterations, MAX_AUTO_ITERATIONS, MAX_ITERATIONS, MAX_POINT_LAYERS, PeelLayers};
