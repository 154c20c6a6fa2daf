//! Shapes of the pixels that a splat covers.

use crate::choices;

/// Shape of the pixels that a splat covers; the values of `SHAPE` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footprint {
    /// Screen-aligned disc.
    Disc = 0,
    /// Disc in the tangent plane.
    Oriented = 1,
    /// Screen-aligned square.
    Square = 2,
    /// One pixel.
    Point = 3,
    /// Sphere; its radius stays in world units.
    Sphere = 4,
    /// Sphere whose place has twice as many digits.
    ExactSphere = 5,
    /// Gaussians and screen-aligned discs, each with one depth.
    FlatGaussian = 6,
    /// Gaussians by other kernels or with a depth for each pixel, and discs of either kind.
    Gaussian = 7,
}

choices!(
    enum Footprint {
        Disc,
        Oriented,
        Square,
        Point,
        Sphere,
        ExactSphere,
        FlatGaussian,
        Gaussian,
    }
);

/// The footprints that are composed.
pub const DISCS: [Footprint; 4] = [Footprint::Disc, Footprint::Oriented, Footprint::FlatGaussian, Footprint::Gaussian];

/// The footprints of splats that go through tiles.
pub const TILED: [Footprint; 3] = [Footprint::Disc, Footprint::Oriented, Footprint::Square];

impl Footprint {
    /// Returns the number of elements of the buffer of tilts for each splat.
    pub fn tilt_stride(self) -> u64 {
        match self {
            Self::Disc | Self::Square | Self::Point | Self::Sphere => 0,
            Self::Oriented | Self::ExactSphere | Self::FlatGaussian => 1,
            Self::Gaussian => 2,
        }
    }

    /// Returns `true` if splats have a depth for each pixel, so that they may cross.
    pub fn may_cross(self) -> bool {
        matches!(self, Self::Oriented | Self::Gaussian)
    }

    /// Returns `true` if splats may be Gaussians.
    pub fn has_gaussians(self) -> bool {
        matches!(self, Self::FlatGaussian | Self::Gaussian)
    }
}
