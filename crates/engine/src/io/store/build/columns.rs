//! The columns that several clouds have as one.

use glam::Vec3;

use super::super::Store;
use crate::cloud::Cloud;

/// What stands for a scalar that a cloud doesn't have.
const NO_VALUE: f32 = f32::NAN;

/// A cloud without points that has the columns of all stores, and notes on what can't be kept, one sentence each.
///
/// A cloud without colors or alphas is white and opaque, one without classes or intensity has 0, without a scalar what isn't a
/// number. Radii are kept if all have them. What was prepared for one cloud says nothing of several.
pub(super) fn union(inputs: &[Box<dyn Store>]) -> (Cloud, Vec<String>) {
    let likes = || inputs.iter().map(|input| &input.summary().like);
    let mut notes = Vec::new();
    let mut like = likes().next().cloned().unwrap_or_default();
    for other in likes().skip(1) {
        like.colors = like.colors.or_else(|| other.colors.clone());
        like.alphas = like.alphas.or_else(|| other.alphas.clone());
        like.normals = like.normals.or_else(|| other.normals.clone());
        like.classification = like.classification.or_else(|| other.classification.clone());
        like.intensity = like.intensity.or_else(|| other.intensity.clone());
        for (name, _) in &other.scalars {
            if like.scalars.iter().all(|(known, _)| known != name) {
                like.scalars.push((name.clone(), Vec::new()));
            }
        }
        like.non_finite = like.non_finite.saturating_add(other.non_finite);
        like.warnings.extend(other.warnings.iter().cloned());
    }
    if inputs.len() > 1 {
        let has_own = |like: &Cloud| like.own_radii().is_some();
        if likes().any(has_own) && !likes().all(has_own) {
            notes.push("some inputs have no radii: those of the others are left out".to_owned());
        }
        like.radii = likes().all(has_own).then(Vec::new);
        if likes().any(|like| like.prepared.is_some()) {
            notes.push("what was prepared for one of several clouds is left out".to_owned());
        }
        like.prepared = None;
    }
    (like, notes)
}

/// A cloud with the columns of another one.
pub(super) fn conform(cloud: Cloud, like: &Cloud) -> Cloud {
    fn fill<T: Copy>(own: Option<Vec<T>>, like: Option<&Vec<T>>, count: usize, value: T) -> Option<Vec<T>> {
        like.map(|_| own.unwrap_or_else(|| vec![value; count]))
    }
    let count = cloud.len();
    let mut own = cloud.scalars;
    let mut scalar = |name: &str| {
        let at = own.iter().position(|(known, _)| known == name);
        at.map_or_else(|| vec![NO_VALUE; count], |at| own.swap_remove(at).1)
    };
    Cloud {
        colors: fill(cloud.colors, like.colors.as_ref(), count, Vec3::ONE),
        alphas: fill(cloud.alphas, like.alphas.as_ref(), count, 1.0),
        normals: fill(cloud.normals, like.normals.as_ref(), count, Vec3::ZERO),
        radii: fill(cloud.radii, like.radii.as_ref(), count, 0.0),
        classification: fill(cloud.classification, like.classification.as_ref(), count, 0),
        intensity: fill(cloud.intensity, like.intensity.as_ref(), count, 0.0),
        scalars: like.scalars.iter().map(|(name, _)| (name.clone(), scalar(name))).collect(),
        prepared: cloud.prepared.filter(|_| like.prepared.is_some()),
        positions: cloud.positions,
        ..like.subset(&[])
    }
}
