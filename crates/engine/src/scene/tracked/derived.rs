//! Derived data of a cloud's points, kept as long as the request stays the same.

use crate::progress::Progress;

use super::super::coloring::{ColorKey, Coloring, Colors};
use super::super::error::Error;
use crate::cloud::Cloud;
use crate::cloud::field::{self, Field};
use crate::prepare::{self, Request};

/// The properties that determine a field: the definition of F, and K for the uncertainty.
pub(super) type FieldKey = (Field, Option<usize>);

/// Radii and field of a cloud's points, in its order and units: those of the last K and of the last field that were asked for.
/// Also the colors of points that have other ones than the file's. At most 20 bytes a point.
#[derive(Debug, Clone, Default)]
pub struct DerivedColumns {
    colors: Option<(ColorKey, Colors)>,
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

    /// Finds the colors of another key, once [`DerivedColumns::learn`] has found the field.
    ///
    /// # Errors
    /// The cloud lacks what its colors are to show.
    pub(super) fn learn_colors(&mut self, coloring: &Coloring<'_>, key: &ColorKey) -> Result<(), Error> {
        if self.colors.as_ref().is_some_and(|(known, _)| known == key) {
            return Ok(());
        }
        // Freed first, as above.
        self.colors = None;
        self.colors = Some((key.clone(), coloring.colors(self.fields())?));
        Ok(())
    }

    /// The colors that were last asked for.
    pub(super) fn colors(&self) -> &Colors {
        self.colors.as_ref().map_or(&Colors::Own, |(_, colors)| colors)
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
