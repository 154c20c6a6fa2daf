//! Derived data of a cloud's points, kept as long as the request stays the same.

use glam::Vec3;
use pellucid_core::progress::Progress;

use super::super::clip::Clips;
use super::super::coloring::{ColorKey, Coloring, Colors};
use super::super::error::Error;
use super::super::settings::Outliers;
use crate::prepare::outliers::Rule;
use crate::prepare::{self, FieldKey, RadiusKey, Request, ShadingNormals};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::field;

/// Radii and field of a cloud's points, in its order and units, and the outliers: those that were last asked for. Also
/// the colors of points that have other ones than the file's. At most 37 bytes a point.
#[derive(Debug, Clone, Default)]
pub struct DerivedColumns {
    colors: Option<(ColorKey, Colors)>,
    radii: Option<(RadiusKey, Vec<f32>)>,
    /// Radii of Eq. 20 without a cap, with their K.
    uncapped: Option<(usize, Vec<f32>)>,
    fields: Option<(FieldKey, Vec<f32>)>,
    dropped: Option<(Rule, Vec<bool>)>,
    /// Normals for shading, with K.
    normals: Option<((ShadingNormals, usize), Vec<Vec3>)>,
}

impl DerivedColumns {
    /// Computes the requested data that is missing, and replaces data of another K, field or rule.
    ///
    /// # Errors
    /// The cloud lacks the property of its field.
    pub(super) fn learn(&mut self, cloud: &Cloud, request: &Request, progress: &Progress) -> Result<(), field::Error> {
        let (radius, field) = (request.radius_key(cloud), request.field_key(cloud));
        let radii = request.radii && self.radii.as_ref().is_none_or(|(computed, _)| *computed != radius);
        let fields = request.fields && self.fields.as_ref().is_none_or(|(computed, _)| *computed != field);
        let unknown = |rule: &Rule| self.dropped.as_ref().is_none_or(|(computed, _)| computed != rule);
        let dropped_outliers = request.dropped_outliers.filter(unknown);
        let neighbors = request.neighbors_of(cloud);
        let normals = request.shading.map(|which| (which, neighbors));
        let shading = request.shading.filter(|_| {
            request.lacks_normals(cloud) && self.normals.as_ref().map(|(computed, _)| *computed) != normals
        });
        let uncapped = request.uncapped && self.uncapped.as_ref().is_none_or(|(computed, _)| *computed != neighbors);
        if !(radii || fields || uncapped || dropped_outliers.is_some() || shading.is_some()) {
            return Ok(());
        }
        // Freed first, so that old and new never occupy memory together.
        self.radii.take_if(|_| radii);
        self.fields.take_if(|_| fields);
        self.uncapped.take_if(|_| uncapped);
        self.dropped.take_if(|_| dropped_outliers.is_some());
        self.normals.take_if(|_| shading.is_some());
        progress.reset();
        progress.set_message("finding neighbors");
        let request = Request { radii, uncapped, fields, dropped_outliers, shading, ..request.clone() };
        let found = prepare::find(cloud, &request, progress)?;
        self.radii = found.radii.map(|radii| (radius, radii)).or(self.radii.take());
        self.uncapped = found.uncapped.map(|radii| (neighbors, radii)).or(self.uncapped.take());
        self.fields = found.fields.map(|fields| (field, fields)).or(self.fields.take());
        self.dropped = dropped_outliers.zip(found.dropped).or(self.dropped.take());
        self.normals = normals.zip(found.shading).or(self.normals.take());
        Ok(())
    }

    /// Finds the colors of another key, once [`DerivedColumns::learn`] has found the field.
    ///
    /// # Errors
    /// The cloud lacks what its colors are to show.
    pub(super) fn learn_colors(
        &mut self,
        mut coloring: Coloring<'_>,
        key: &ColorKey,
        clips: &Clips,
    ) -> Result<(), Error> {
        if self.colors.as_ref().is_some_and(|(known, _)| known == key) {
            return Ok(());
        }
        // Freed first, as above.
        self.colors = None;
        let rule = coloring.settings.strays.rule(Outliers::Drop);
        coloring.count_drawn(clips, rule.and_then(|rule| self.dropped(rule)))?;
        self.colors = Some((key.clone(), coloring.colors(self.fields())?));
        Ok(())
    }

    /// Returns the colors that were last asked for.
    pub(super) fn colors(&self) -> &Colors {
        self.colors.as_ref().map_or(&Colors::Own, |(_, colors)| colors)
    }

    /// Returns the radii that were last asked for.
    pub(super) fn radii(&self) -> Option<&[f32]> {
        self.radii.as_ref().map(|(_, radii)| radii.as_slice())
    }

    /// Marks on the points that are dropped by this rule, if they were asked for.
    pub(super) fn dropped(&self, rule: Rule) -> Option<&[bool]> {
        self.dropped.as_ref().filter(|(computed, _)| *computed == rule).map(|(_, marks)| marks.as_slice())
    }

    /// Returns the normals for shading that were last asked for, if they are these.
    pub(super) fn normals(&self, which: ShadingNormals) -> Option<&[Vec3]> {
        self.normals.as_ref().filter(|((computed, _), _)| *computed == which).map(|(_, normals)| normals.as_slice())
    }

    /// Returns the radii of Eq. 20 without its cap that were last asked for.
    pub(super) fn uncapped(&self) -> Option<&[f32]> {
        self.uncapped.as_ref().map(|(_, radii)| radii.as_slice())
    }

    /// F that was last asked for.
    pub(super) fn fields(&self) -> Option<&[f32]> {
        self.fields.as_ref().map(|(_, fields)| fields.as_slice())
    }
}
