//! The projection settings of a frame's splats.

use super::{Frame, shadows};
use crate::passes::project::{DeviceCloud, Drawing, Footprint, Part, Projecting};
use crate::scene::{Raster, ScreenSplats, SplatShape};

/// Radii as they are.
pub(super) const UNCLAMPED: ScreenSplats = ScreenSplats { size: 1.0, max_pixel_radius: f32::MAX, raster: Raster::Auto };

/// Returns the footprint of an opaque splat of this outline.
pub(super) fn outlined(shape: SplatShape) -> Footprint {
    match shape {
        SplatShape::Circle => Footprint::Disc,
        SplatShape::Square => Footprint::Square,
    }
}

impl Frame {
    /// Returns the conversion of a part of a cloud's points to splats.
    pub(super) fn projecting(
        &self,
        cloud: &DeviceCloud,
        footprint: Footprint,
        settings: ScreenSplats,
        part: Part,
    ) -> Projecting {
        // Without normals there are no tilts, and every disc is flat.
        let flat = footprint == Footprint::Oriented && !cloud.has_normals();
        Projecting {
            footprint: if flat { Footprint::Disc } else { footprint },
            radius_factor: settings.size * self.factors.radius,
            max_radius_px: settings.max_pixel_radius,
            opacity_factor: self.factors.opacity,
            part,
            relative_depth: false,
            shading: self.shading,
            color: self.color,
            gaussians: Drawing::default(),
            lit: cloud.casting().is_some() && cloud.casting() == shadows::casting(self, cloud).as_ref(),
        }
    }

    /// Returns the conversion of all points to pixels of their own.
    pub(super) fn projecting_points(&self, cloud: &DeviceCloud) -> Projecting {
        self.projecting(cloud, Footprint::Point, UNCLAMPED, Part::All)
    }
}
