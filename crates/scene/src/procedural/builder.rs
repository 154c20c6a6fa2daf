//! Collects points into a [`Cloud`] on the grids that a PLY file keeps.

use glam::{DVec3, Vec3};

use super::Error;
use pellucid_core::cloud::Cloud;
use pellucid_core::color::{decode_srgb, encode_srgb_f64};

/// An 8-bit sRGB color.
pub(super) type Rgb = [u8; 3];

/// Bytes of one point with normal and class: float64 position, float32 color and normal.
const POINT_BYTES: usize = 24 + 12 + 12 + 1;

/// The linear value of every sRGB byte, as readers decode it.
pub(super) struct SrgbTable([f32; 256]);

impl SrgbTable {
    pub(super) fn new() -> Self {
        Self(std::array::from_fn(|byte| decode_srgb(byte as f32 / 255.0)))
    }

    pub(super) fn decode(&self, rgb: Rgb) -> Vec3 {
        Vec3::from_array(rgb.map(|byte| self.0[usize::from(byte)]))
    }
}

/// Returns the nearest sRGB bytes of a linear color, which is clamped to [0, 1].
pub(super) fn encode(linear: DVec3) -> Rgb {
    linear.clamp(DVec3::ZERO, DVec3::ONE).to_array().map(|v| (255.0 * encode_srgb_f64(v)).round() as u8)
}

/// A cloud in the making. Give every point the same columns.
pub(super) struct CloudBuilder {
    cloud: Cloud,
    capacity: usize,
    table: SrgbTable,
}

impl CloudBuilder {
    /// Checks that `points` points can be allocated before anything else does.
    pub(super) fn with_capacity(points: usize) -> Result<Self, Error> {
        let too_large = |_| Error::TooLarge { points, bytes: points.saturating_mul(POINT_BYTES) };
        // The whole at once, for a moment, so that the columns that come later have their room too.
        Vec::<u8>::new().try_reserve_exact(points.saturating_mul(POINT_BYTES)).map_err(too_large)?;
        let (positions, colors) = (Vec::with_capacity(points), Some(Vec::with_capacity(points)));
        Ok(Self { cloud: Cloud { positions, colors, ..Cloud::default() }, capacity: points, table: SrgbTable::new() })
    }

    /// Adds a point; its position is rounded to float32.
    pub(super) fn point(&mut self, position: DVec3, color: Rgb) {
        self.cloud.positions.push(position.as_vec3().as_dvec3());
        self.cloud.colors.get_or_insert_default().push(self.table.decode(color));
    }

    /// The normal of the point just added, of unit length up to rounding.
    pub(super) fn normal(&mut self, normal: DVec3) {
        self.cloud.normals.get_or_insert_with(|| Vec::with_capacity(self.capacity)).push(normal.as_vec3());
    }

    /// The class of the point just added.
    pub(super) fn class(&mut self, class: u8) {
        self.cloud.classification.get_or_insert_with(|| Vec::with_capacity(self.capacity)).push(class);
    }

    /// The radius of the point just added.
    pub(super) fn radius(&mut self, radius: f64) {
        self.cloud.radii.get_or_insert_with(|| Vec::with_capacity(self.capacity)).push(radius as f32);
    }

    pub(super) fn finish(self) -> Cloud {
        self.cloud
    }
}
