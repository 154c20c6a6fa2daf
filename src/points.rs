//! The points of a whole scene, ready for the device: merged, with every setting applied, in canonical order.

use glam::{DVec3, Vec3};

use crate::cloud::Bounds;

/// All points of a scene in one list. The columns are equally long.
///
/// The order is canonical: it follows from what the points are (position, color, opacity, radius, normal) and not from
/// the order in the files. Every tie between fragments of equal depth is decided by the index in this list, so that
/// shuffled input gives the same bytes, and neighbors in space are neighbors in memory (Morton order).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Points {
    /// World positions, all finite.
    pub positions: Vec<DVec3>,
    /// Linear RGB.
    pub colors: Vec<Vec3>,
    /// Opacity of a point's splat in [0, 1].
    pub opacities: Vec<f32>,
    /// World radii, finite and at least 0. All zero if the method does not ask for radii.
    pub radii: Vec<f32>,
    /// Unit normals, `Vec3::ZERO` where a point has none; absent if no cloud has any.
    pub normals: Option<Vec<Vec3>>,
    /// Where each point stood before it came into canonical order: file after file, point after point. Empty: as here.
    /// Only `unsorted` asks.
    pub file_order: Vec<u32>,
    /// The scalar field F of each point in [0, 1], which tells solid points from soft ones. Empty: 0 for all; only the soft
    /// methods ask.
    pub fields: Vec<f32>,
}

impl Points {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The scene's box; `None` without points.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.positions.iter().copied())
    }
}
