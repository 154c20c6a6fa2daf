//! Derived data of a cloud's points, kept as long as the request stays the same.

use crate::progress::Progress;

use crate::cloud::Cloud;
use crate::cloud::field::{self, Field};
use crate::prepare::{self, Request};

/// The properties that determine a field: the definition of F, and K for the uncertainty.
pub(super) type FieldKey = (Field, Option<usize>);

/// Radii and field of a cloud's points, in its order and units: those of the last K and of the last field that were asked for.
/// At most 8 bytes a point.
#[derive(Debug, Clone, Default)]
pub struct DerivedColumns {
    radii: Option<(usize, Vec<f32>)>,
    fields: Option<(FieldKey, Vec<f32>)>,
}

/// The field that a request asks for.
pub(super) fn field_key(cloud: &Cloud, request: &Request) -> FieldKey {
    let field = request.field_of(cloud);
    let neighbors = (field == Field::Uncertainty).then(|| request.neighbors_of(cloud));
    (field, neighbors)
}

impl DerivedColumns {
    /// Computes the requested data that is missing, and replaces data of another K or field.
    ///
    /// # Errors
    /// The cloud lacks the property of its field.
    pub(super) fn learn(&mut self, cloud: &Cloud, request: &Request, progress: &Progress) -> Result<(), field::Error> {
        let (neighbors, field) = (request.neighbors_of(cloud), field_key(cloud, request));
        let radii = request.radii && self.radii.as_ref().is_none_or(|(computed, _)| *computed != neighbors);
        let fields = request.fields && self.fields.as_ref().is_none_or(|(computed, _)| *computed != field);
        if !(radii || fields) {
            return Ok(());
        }
        // Freed first, so that old and new never occupy memory together.
        self.radii.take_if(|_| radii);
        self.fields.take_if(|_| fields);
        progress.reset();
        progress.set_message("finding neighbors");
        let found = prepare::find(cloud, &Request { radii, fields, ..request.clone() }, progress)?;
        self.radii = found.radii.map(|radii| (neighbors, radii)).or(self.radii.take());
        self.fields = found.fields.map(|fields| (field, fields)).or(self.fields.take());
        Ok(())
    }

    /// The radii that were last asked for.
    pub(super) fn radii(&self) -> Option<&[f32]> {
        self.radii.as_ref().map(|(_, radii)| radii.as_slice())
    }

    /// F that was last asked for.
    pub(super) fn fields(&self) -> Option<&[f32]> {
        self.fields.as_ref().map(|(_, fields)| fields.as_slice())
    }
}
