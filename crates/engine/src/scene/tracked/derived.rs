//! Derived data of a cloud's points, kept as long as the request stays the same.

use crate::progress::Progress;

use crate::cloud::Cloud;
use crate::cloud::field::{self, Field};
use crate::prepare::outliers::Rule;
use crate::prepare::{self, Request};

/// The properties that determine estimated radii: K, and the cap.
pub(super) type RadiusKey = (usize, u32);

/// The properties that determine a field.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FieldKey {
    definition: Field,
    /// For the uncertainty.
    radii: Option<RadiusKey>,
    /// Outliers that are soft.
    soft: Option<Rule>,
}

/// Radii and field of a cloud's points, in its order and units, and the outliers: those that were last asked for. At most 9
/// bytes a point.
#[derive(Debug, Clone, Default)]
pub struct DerivedColumns {
    radii: Option<(RadiusKey, Vec<f32>)>,
    fields: Option<(FieldKey, Vec<f32>)>,
    dropped: Option<(Rule, Vec<bool>)>,
}

/// The radii that a request asks for.
pub(super) fn radius_key(cloud: &Cloud, request: &Request) -> RadiusKey {
    (request.neighbors_of(cloud), request.radius_cap_of(cloud).to_bits())
}

/// The field that a request asks for.
pub(super) fn field_key(cloud: &Cloud, request: &Request) -> FieldKey {
    let definition = request.field_of(cloud);
    let radii = (definition == Field::Uncertainty).then(|| radius_key(cloud, request));
    FieldKey { definition, radii, soft: request.soft_outliers }
}

impl DerivedColumns {
    /// Computes the requested data that is missing, and replaces data of another K, field or rule.
    ///
    /// # Errors
    /// The cloud lacks the property of its field.
    pub(super) fn learn(&mut self, cloud: &Cloud, request: &Request, progress: &Progress) -> Result<(), field::Error> {
        let (radius, field) = (radius_key(cloud, request), field_key(cloud, request));
        let radii = request.radii && self.radii.as_ref().is_none_or(|(computed, _)| *computed != radius);
        let fields = request.fields && self.fields.as_ref().is_none_or(|(computed, _)| *computed != field);
        let unknown = |rule: &Rule| self.dropped.as_ref().is_none_or(|(computed, _)| computed != rule);
        let dropped_outliers = request.dropped_outliers.filter(unknown);
        if !(radii || fields || dropped_outliers.is_some()) {
            return Ok(());
        }
        // Freed first, so that old and new never occupy memory together.
        self.radii.take_if(|_| radii);
        self.fields.take_if(|_| fields);
        self.dropped.take_if(|_| dropped_outliers.is_some());
        progress.reset();
        progress.set_message("finding neighbors");
        let found = prepare::find(cloud, &Request { radii, fields, dropped_outliers, ..request.clone() }, progress)?;
        self.radii = found.radii.map(|radii| (radius, radii)).or(self.radii.take());
        self.fields = found.fields.map(|fields| (field, fields)).or(self.fields.take());
        self.dropped = dropped_outliers.zip(found.dropped).or(self.dropped.take());
        Ok(())
    }

    /// The radii that were last asked for.
    pub(super) fn radii(&self) -> Option<&[f32]> {
        self.radii.as_ref().map(|(_, radii)| radii.as_slice())
    }

    /// Marks on the points that are dropped by this rule, if they were asked for.
    pub(super) fn dropped(&self, rule: Rule) -> Option<&[bool]> {
        self.dropped.as_ref().filter(|(computed, _)| *computed == rule).map(|(_, marks)| marks.as_slice())
    }

    /// F that was last asked for.
    pub(super) fn fields(&self) -> Option<&[f32]> {
        self.fields.as_ref().map(|(_, fields)| fields.as_slice())
    }
}
