//! The projection settings of a frame's splats.

use super::{Frame, abuffer, shadows};
use crate::passes::project::{CloudPart, DeviceCloud, Drawing, Footprint, Projecting};
use crate::scene::{DiscShape, Discs, Kernel, Order, Raster, ScreenSplats, SplatShape};

/// Radii as they are.
pub(super) const UNCLAMPED: ScreenSplats =
    ScreenSplats { size: 1.0, max_pixel_radius: f32::MAX, pixel_radius: None, raster: Raster::Auto };

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
        part: CloudPart,
    ) -> Projecting {
        // Without normals there are no tilts, and every disc is flat.
        let flat = footprint == Footprint::Oriented && !cloud.has_normals();
        Projecting {
            footprint: if flat { Footprint::Disc } else { footprint },
            radius_factor: settings.size * self.factors.radius,
            max_radius_px: settings.max_pixel_radius,
            pixel_radius: settings.pixel_radius,
            opacity_factor: self.factors.opacity,
            part,
            shading: self.shading,
            color: self.color,
            lit: cloud.casting().is_some() && cloud.casting() == shadows::casting(self, cloud).as_ref(),
            places: self.places(),
            ..Projecting::plain(footprint)
        }
    }

    /// Returns the conversion of all points to pixels of their own.
    pub(super) fn projecting_points(&self, cloud: &DeviceCloud) -> Projecting {
        self.projecting(cloud, Footprint::Point, UNCLAMPED, CloudPart::All)
    }
}

/// Returns the conversion of a cloud's discs and Gaussians to splats.
pub(super) fn discs(frame: &Frame, cloud: &DeviceCloud, discs: &Discs) -> Projecting {
    let of_discs = frame.projecting(cloud, abuffer::footprint(discs.shape), UNCLAMPED, CloudPart::All);
    if !cloud.has_gaussians() {
        return of_discs;
    }
    let (settings, order) = (discs.gaussians, frame.method.order());
    let shape = if of_discs.footprint == Footprint::Oriented { DiscShape::Oriented } else { DiscShape::Flat };
    let flat = shape == DiscShape::Flat && settings.kernel == Kernel::Ewa && order != Order::Pixel;
    let footprint = if flat { Footprint::FlatGaussian } else { Footprint::Gaussian };
    let relative_depth = settings.kernel == Kernel::Ellipsoid;
    Projecting { footprint, relative_depth, gaussians: Drawing { settings, order, discs: shape }, ..of_discs }
}
