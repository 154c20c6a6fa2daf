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

use std::borrow::Borrow;

pub use camera::CameraSettings;
pub use classes::{ClassSettings, Selection};
pub use clip::{Clip, ClipShape};
pub(super) use cloud::FIELD_KEYS;
pub use cloud::{CloudSettings, Primitive};
pub use coloring::{ColorBy, ColorSettings, ColormapName};
pub use detail::Detail;
pub use discs::{
    DiscShape, Discs, Falloff, GaussianSettings, Hybrid, Kernel, LongLists, MAX_K, MAX_LAYERS, MAX_NODES, MAX_RANK,
    MAX_SAMPLES, Mlab, MomentCount, Moments, Order, Peel, Raster, Stochastic, Tail, Wavelet,
};
pub use ensembles::{Brightness, MAX_ENSEMBLES, Spbr, SpbrSimplified};
pub use image::ImageSettings;
pub use pellucid_core::color::ColorSpace;
pub use pellucid_core::light::Light;
pub use shading::{Edl, Formula, MAX_SHADOW_SAMPLES, Shading, ShadingModel, ShadowMethod, Shadows};
pub use soft::{Density, MAX_SHELLS, OneLayer, Shells, Soft, SoftLayout};
pub use splats::{BlendedSplats, Interpolated, ScreenSplats, SplatShape};
pub use strays::{Outliers, Strays};
pub use surfaces::{ImageSpace, MAX_ITERATIONS, MAX_POINT_LAYERS, PeelLayers};

use super::choice::MethodChoice;
use super::gaussians;
use super::methods::{Family, Method};
use crate::prepare::ShadingNormals;
use pellucid_core::cloud::Cloud;

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
    /// `[[clip]]`: points are drawn where all of them keep the center.
    pub clips: Vec<Clip>,
    /// `[method]`.
    pub method: MethodChoice,
    /// `[detail]`.
    pub detail: Detail,
    /// `[shadows]`, if they were asked for and can be: with a light of its own place or direction, shading and an
    /// opaque method.
    pub shadows: Option<Shadows>,
    /// Warnings about keys without effect, one sentence each.
    pub warnings: Vec<String>,
    /// The keys that were given, those of options included, as one JSON object: the image's `pellucid:settings`.
    pub settings: String,
}

impl Scene {
    /// Settles what its clouds decide: scenes of Gaussians alone are blended in display values, in which they are
    /// trained, unless the scene says otherwise. Returns true if they decided it.
    pub fn settle(&mut self, clouds: &[impl Borrow<Cloud>]) -> bool {
        self.settle_for(|cloud| clouds.get(cloud).is_some_and(|cloud| cloud.borrow().gaussians.is_some()))
    }

    /// Returns the same, given which of its clouds are files of Gaussians.
    pub fn settle_for(&mut self, has_gaussians: impl Fn(usize) -> bool) -> bool {
        let drawn = |(i, settings)| has_gaussians(i) && gaussians::would_be_drawn(self, settings);
        let alone = !self.clouds.is_empty() && self.clouds.iter().enumerate().all(drawn);
        let decided = self.image.color.is_none() && alone;
        if decided {
            self.image.color = Some(ColorSpace::Encoded);
        }
        decided
    }

    /// Returns the normals that are estimated where a cloud has none: those that shading or the method needs.
    pub fn shading_normals(&self) -> Option<ShadingNormals> {
        match self.shading.model {
            _ if self.method.scales_by_normals() => Some(ShadingNormals::All),
            ShadingModel::None => None,
            ShadingModel::Lambert | ShadingModel::Phong => Some(ShadingNormals::All),
            ShadingModel::Auto => Some(ShadingNormals::Planar),
        }
    }

    /// Returns `true` if some points may not be drawn.
    pub fn hides_points(&self) -> bool {
        let hides = |entry: &ClassSettings| entry.visible == Some(false);
        !self.clips.is_empty() || self.clouds.iter().flat_map(|cloud| &cloud.class).any(hides)
    }
}

/// The displacement of an opaque splat's fragments toward the viewer, in drawn radii, at the distance ρ from its
/// center, in radii (Schütz and Wimmer 2015).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Relief {
    /// No displacement.
    #[default]
    Flat = 0,
    /// 1 − ρ².
    Paraboloid = 1,
    /// 1 − ρ.
    Cone = 2,
    /// √(1 − ρ²).
    Sphere = 3,
}

/// A method of soft points, with its settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SoftMethod {
    /// `soft-base`
    Base(Soft),
    /// `soft-concentric`
    Concentric(Soft),
    /// `soft-express`
    Express(Soft),
}

impl SoftMethod {
    /// Returns its settings.
    pub fn settings(&self) -> &Soft {
        match self {
            Self::Base(soft) | Self::Concentric(soft) | Self::Express(soft) => soft,
        }
    }

    /// Returns the same method with other settings.
    #[must_use]
    pub fn changed(mut self, change: impl FnOnce(&mut Soft)) -> Self {
        match &mut self {
            Self::Base(soft) | Self::Concentric(soft) | Self::Express(soft) => change(soft),
        }
        self
    }
}

impl From<SoftMethod> for Method {
    fn from(method: SoftMethod) -> Self {
        match method {
            SoftMethod::Base(soft) => Self::SoftBase(soft),
            SoftMethod::Concentric(soft) => Self::SoftConcentric(soft),
            SoftMethod::Express(soft) => Self::SoftExpress(soft),
        }
    }
}

impl Method {
    /// Returns the methods that blend discs and compute the same image, each with its defaults; `stress` compares them.
    pub fn transparent() -> Vec<Self> {
        Family::Discs.methods().filter(|method| method.is_exact(false)).collect()
    }

    /// Returns the settings of the disc family; `None` for other methods.
    pub fn discs(&self) -> Option<&Discs> {
        self.part()
    }

    /// Returns what it orders Gaussians by: the center, if it orders splats once.
    pub fn order(&self) -> Order {
        let default = if matches!(self, Self::Sorted(_)) { Order::Center } else { Order::Pixel };
        match self.discs().map(|discs| discs.gaussians) {
            // Ellipsoids are entered and left: what they are ordered by is each pixel's.
            Some(gaussians) if gaussians.kernel == Kernel::Ellipsoid => Order::Pixel,
            Some(gaussians) => gaussians.order.unwrap_or(default),
            None => default,
        }
    }

    /// Returns the displacement of its fragments toward the viewer.
    pub fn relief(&self) -> Relief {
        match self {
            Self::Paraboloid(_) => Relief::Paraboloid,
            Self::Cone(_) => Relief::Cone,
            Self::Sphere(_) => Relief::Sphere,
            _ => Relief::Flat,
        }
    }

    /// Returns the settings of soft transparency; `None` for other methods.
    pub fn soft(&self) -> Option<&Soft> {
        self.part()
    }

    /// Returns the same as one of the methods of soft points; `None` for others.
    pub fn as_soft(&self) -> Option<SoftMethod> {
        match *self {
            Self::SoftBase(soft) => Some(SoftMethod::Base(soft)),
            Self::SoftConcentric(soft) => Some(SoftMethod::Concentric(soft)),
            Self::SoftExpress(soft) => Some(SoftMethod::Express(soft)),
            _ => None,
        }
    }

    /// Returns the field above which points are soft, if the method distinguishes them from solid ones.
    pub fn threshold(&self) -> Option<f32> {
        let one_layer = self.part().map(|settings: &OneLayer| settings.threshold);
        one_layer.or(self.soft().map(|soft| soft.threshold))
    }

    /// Returns `true` if the image depends on the points' scalar field.
    pub fn needs_field(&self) -> bool {
        self.threshold().is_some()
    }

    /// Returns `true` if the share of points that is drawn depends on their normals.
    pub fn scales_by_normals(&self) -> bool {
        matches!(self, Self::Spbr(Spbr { cos_theta: false, .. }))
    }

    /// Returns `true` if the image depends on the points' radii, so that missing ones must be estimated.
    pub fn needs_radii(&self) -> bool {
        match self.family() {
            Family::Opaque => !matches!(self, Self::Points),
            Family::Discs | Family::Soft | Family::OneLayer => true,
            Family::Surfaces | Family::Ensembles => false,
        }
    }

    /// Returns the filters of the image, of methods that have some.
    pub fn filters(&self) -> Option<&ImageSpace> {
        self.part()
    }

    /// Returns `true` if `[shadows]` applies to it.
    pub fn takes_shadows(&self) -> bool {
        match self.family() {
            Family::Opaque | Family::Surfaces => true,
            Family::Discs | Family::Soft | Family::OneLayer | Family::Ensembles => false,
        }
    }

    /// Returns `true` if `edl` of `[shading]` applies to it: if the depth of a pixel is that of one surface, or the one
    /// at which half of the light is left can be found.
    pub fn takes_edl(&self) -> bool {
        match self.family() {
            Family::Opaque => true,
            Family::Surfaces => matches!(self, Self::ImageSpace(_)),
            Family::Discs => matches!(self, Self::ABuffer(_) | Self::LinkedList(_)),
            Family::Soft | Family::OneLayer | Family::Ensembles => false,
        }
    }

    /// Returns `true` if it needs points in random order, cloud after cloud
    /// ([`Dealt`](crate::prepare::ensembles::Dealt)).
    pub fn is_dealt(&self) -> bool {
        self.ensembles().is_some()
    }

    /// L of the methods that deal points to ensembles; `None` for other methods.
    pub fn ensembles(&self) -> Option<u32> {
        let spbr = self.part().map(|settings: &Spbr| settings.ensembles);
        spbr.or(self.part().map(|settings: &SpbrSimplified| settings.ensembles))
    }
}
