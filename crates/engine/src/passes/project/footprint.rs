//! Which pixels a splat covers.

use crate::choices;

/// Which pixels a splat covers; the values of `SHAPE` in WGSL.
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
    /// The same, its place to twice as many digits.
    ExactSphere = 5,
}

choices!(
    enum Footprint {
        Disc,
        Oriented,
        Square,
        Point,
        Sphere,
        ExactSphere,
    }
);

/// The footprints that are composed.
pub const DISCS: [Footprint; 2] = [Footprint::Disc, Footprint::Oriented];

/// The footprints of splats that go through tiles.
pub const TILED: [Footprint; 3] = [Footprint::Disc, Footprint::Oriented, Footprint::Square];

impl Footprint {
    /// True if splats of this shape have tilts.
    pub fn has_tilts(self) -> bool {
        matches!(self, Self::Oriented | Self::ExactSphere)
    }
}
