//! The inside of a sphere: density that falls off, or shells of constant density.

use crate::methods::prelude::*;
use crate::passes::project::ShellCount;
use crate::scene::{MAX_SHELLS, Shells, SoftLayout};

/// A sphere whose density falls off linearly, and shells of constant density: values of `MODEL` in WGSL.
pub(super) const MODEL_BASE: u32 = 0;
const MODEL_CONCENTRIC: u32 = 1;

/// The inside of a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Interior {
    /// Density that falls off linearly: `soft-base`.
    Linear,
    /// Density that falls off linearly, from the record that the paper stores of an event.
    Packed,
    /// Concentric shells of constant density: `soft-concentric`.
    Shells(Shells, f32),
}

impl Interior {
    /// Returns the interior of integrated spheres, by the layout of their events.
    pub fn integrated(layout: SoftLayout) -> Self {
        match layout {
            SoftLayout::Precise => Self::Linear,
            SoftLayout::Paper => Self::Packed,
        }
    }

    /// Shells of a sphere at most.
    pub fn most_shells(self) -> u32 {
        match self {
            Self::Linear | Self::Packed => 1,
            Self::Shells(Shells::Fixed(shells), _) => shells,
            Self::Shells(Shells::Adaptive, _) => MAX_SHELLS,
        }
    }

    /// Returns the number of shells as the view has it.
    pub(in crate::methods::soft) fn shells(self) -> ShellCount {
        let radius_px = match self {
            Self::Shells(Shells::Adaptive, pixels) => pixels,
            _ => 0.0,
        };
        ShellCount { most: self.most_shells(), radius_px }
    }

    /// Returns `true` if the spheres of a pixel must be counted besides its events.
    pub fn counted(self) -> bool {
        self.most_shells() > 1
    }

    /// Bits of an event's index for the shell, as shaders/shared/sphere.wgsl counts them.
    fn shell_bits(self) -> u32 {
        self.most_shells().next_power_of_two().ilog2()
    }

    /// Returns the number of points that events can tell apart.
    pub(super) fn most_points(self) -> u64 {
        1 << (31 - self.shell_bits())
    }

    /// Adds the constants of shaders/shared/sphere.wgsl.
    pub(super) fn sphere(self, variant: Variant) -> Variant {
        let model = if self.is_integrated() { MODEL_BASE } else { MODEL_CONCENTRIC };
        variant.with("MODEL", model).with("PACKED", u32::from(self == Self::Packed))
    }

    /// Returns `true` if events are integrated, and not constant densities summed.
    pub fn is_integrated(self) -> bool {
        !matches!(self, Self::Shells(..))
    }

    /// Adds the constants of shaders/shared/soft_terms.wgsl as well.
    pub(super) fn terms(self, variant: Variant, modulated: bool) -> Variant {
        self.sphere(variant).with("MODULATED", u32::from(modulated))
    }
}

/// Shells in both forms: several of them, which are counted, and one.
impl Choices for Interior {
    fn all() -> Vec<Self> {
        vec![Self::Linear, Self::Packed, Self::Shells(Shells::Adaptive, 4.0), Self::Shells(Shells::Fixed(1), 4.0)]
    }
}

/// The kind of spheres that a kernel is made for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereKind {
    /// The inside of a sphere.
    pub interior: Interior,
    /// `true` if it is so dense that float32 would show (`SoftModel::is_stiff`).
    pub exact: bool,
    /// `true` if some points are modulated.
    pub modulated: bool,
}

impl SphereKind {
    /// Returns the footprint of spheres.
    pub fn footprint(self) -> Footprint {
        if self.exact { Footprint::ExactSphere } else { Footprint::Sphere }
    }
}

choices!(struct SphereKind { interior, exact, modulated });
