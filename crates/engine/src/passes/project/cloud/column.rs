//! The columns of vectors that the device holds of each point.

use glam::{DVec3, Vec3};

use crate::gpu::{Buffer, Error};
use crate::points::Points;
use pellucid_core::parallel;

/// A column of vectors that the device holds, one for each point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// The position relative to the cloud's origin, rounded, and the radius.
    High = 0,
    /// The rest of the position, and the opacity.
    Low = 1,
    /// Color, and as the bits of the fourth where in the files the point stood.
    Color = 2,
    /// The normal, of clouds that have some, and the share of light: 1.
    Normal = 3,
}

/// Bytes that a point has in each column.
pub const COLUMN_BYTES: u64 = size_of::<[f32; 4]>() as u64;

impl Column {
    /// All of them, normals last.
    pub const ALL: [Self; 4] = [Self::High, Self::Low, Self::Color, Self::Normal];

    /// Brings the column of all points to the front of a buffer.
    pub(super) fn upload(self, points: &Points, origin: DVec3, buffer: &Buffer<[f32; 4]>) -> Result<(), Error> {
        buffer.upload_by(points.len() as u64, |range, to| {
            parallel::for_each_mut(to, |i, to| *to = self.value(points, origin, range.start + i));
        })
    }

    /// Returns the column of one point.
    pub(super) fn value(self, points: &Points, origin: DVec3, i: usize) -> [f32; 4] {
        let with = |v: Vec3, w: f32| [v.x, v.y, v.z, w];
        match self {
            // Of a Gaussian a radius below 0 says that it is no disc.
            Self::High => {
                with(split(points.positions[i] - origin).0, points.disc_radius(i).map_or(-1.0, above_subnormal))
            }
            Self::Low => with(split(points.positions[i] - origin).1, points.opacities[i]),
            Self::Color => {
                let place = points.file_order.get(i).copied().unwrap_or(i as u32);
                with(points.colors[i], f32::from_bits(place))
            }
            Self::Normal => with(points.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[i]), 1.0),
        }
    }
}

/// Returns a radius, or a normal number where it is a tiny one: a device may treat subnormal numbers as 0, and without
/// a radius a disc covers nothing, while one of 10⁻⁴⁵ has the pixel of its center. The product with the pixels of a
/// unit stays normal, too.
fn above_subnormal(radius: f32) -> f32 {
    if radius > 0.0 { radius.max(1e-30) } else { radius }
}

/// Splits coordinates into a float and the rest.
pub(in crate::passes::project) fn split(v: DVec3) -> (Vec3, Vec3) {
    let hi = v.as_vec3();
    (hi, (v - hi.as_dvec3()).as_vec3())
}
