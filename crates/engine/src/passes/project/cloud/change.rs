//! Points on the device that change where they are: only columns that are others go there again, into the same buffers.

use super::{Column, DeviceCloud, List, fields_and_radii, largest_component, largest_opacity};
use crate::gpu::{Device, Error};
use crate::points::{Changes, Points};
use crate::prepare::Arranged;

impl DeviceCloud {
    /// Lets go of the list of a cloud that was dealt, so that it can be changed in place, until [`Self::follow`] brings
    /// it back.
    pub fn let_go(&mut self) {
        self.host = None;
    }

    /// Updates the cloud to its points' current values: the same number in the same places as were uploaded. Data that
    /// depend on a changed column are recomputed; shadows stay, unless points with normals traded places. After an
    /// error nothing can be rendered until the same changes are applied again.
    ///
    /// # Errors
    /// No memory for a new field, or the device failed.
    pub fn follow(&mut self, device: &Device, arranged: &Arranged, changes: Changes) -> Result<(), Error> {
        let points = arranged.points();
        if let Arranged::Dealt(dealt) = arranged {
            self.host = Some(List::Held(dealt.points.clone()));
            for (placed, surface) in
                self.surfaces.iter_mut().flatten().zip(&dealt.surfaces).filter(|_| changes.opacities)
            {
                placed.renew_opacities(points, surface);
            }
        }
        self.measure(points, changes);
        if changes.fields {
            self.renew_positions(points);
        }
        // Dealt points may not be uploaded yet.
        if self.points_hi.len() == self.len {
            self.upload_changes(device, points, changes)?;
        }
        Ok(())
    }

    /// Recomputes the properties of all points, except those of their positions.
    fn measure(&mut self, points: &Points, changes: Changes) {
        if changes.opacities {
            self.max_opacity = largest_opacity(points);
        }
        if changes.colors {
            self.max_color = largest_component(points);
        }
        if changes.radii || changes.unseen {
            self.max_radius = points.largest_radius() as f32;
        }
        if changes.radii || changes.fields || changes.order {
            self.fields_and_radii = fields_and_radii(points);
            self.parts = None;
        }
    }

    /// Only points with a field are put into order along the axes. Orders are of places, whose positions stay.
    fn renew_positions(&mut self, points: &Points) {
        self.has_fields = !points.fields.is_empty();
        if !self.has_fields {
            (self.positions, self.orders) = (Vec::new(), [None, None, None]);
        } else if self.positions.is_empty() {
            self.positions.clone_from(&points.positions);
        }
    }

    fn upload_changes(&mut self, device: &Device, points: &Points, changes: Changes) -> Result<(), Error> {
        let upload = |column: Column, buffer| column.upload(points, self.origin, buffer);
        if changes.radii || changes.order {
            upload(Column::High, &self.points_hi)?;
        }
        if changes.opacities || changes.order {
            upload(Column::Low, &self.points_lo)?;
        }
        if changes.colors || changes.order {
            upload(Column::Color, &self.point_colors)?;
        }
        // Shares of light depend on position and normal: without normals those of traded places are the same.
        if changes.order && self.has_normals {
            upload(Column::Normal, &self.normals)?;
            self.casting = None;
        }
        if changes.fields || (changes.order && self.has_fields) {
            self.upload_fields(device, points)?;
        }
        Ok(())
    }

    fn upload_fields(&mut self, device: &Device, points: &Points) -> Result<(), Error> {
        if self.fields.len() == points.fields.len() as u64 {
            self.fields.upload(&points.fields)
        } else {
            self.fields = device.upload("fields", &points.fields)?;
            Ok(())
        }
    }
}
