//! Properties of methods that follow from their families and settings.

use super::{Family, Method};
use crate::settings::{Discs, ImageSpace, Kernel, OneLayer, Order, ScreenSplats, Soft, Spbr, SpbrSimplified};

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
            Family::Opaque => !matches!(self, Self::Points) && self.pixel_radius().is_none(),
            Family::Discs | Family::Soft | Family::OneLayer => true,
            Family::Surfaces | Family::Ensembles => false,
        }
    }

    /// Returns the radius in pixels that all splats have, if they have one.
    pub fn pixel_radius(&self) -> Option<f32> {
        self.part().and_then(|splats: &ScreenSplats| splats.pixel_radius)
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
