//! The columns that several clouds have as one.

use super::super::Store;
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;

/// Returns a cloud without points that has the columns of all stores, and notes on what can't be kept, one sentence
/// each.
///
/// Radii are kept if all have them. What was prepared for one cloud says nothing of several.
pub(super) fn union(inputs: &[Box<dyn Store>]) -> (Cloud, Vec<String>) {
    let likes = || inputs.iter().map(|input| &input.summary().like);
    let mut notes = Vec::new();
    let mut like = likes().next().cloned().unwrap_or_default();
    like.filter = like.filter.filter(|_| likes().all(|other| other.filter == like.filter));
    for other in likes().skip(1) {
        // All of them have splats, or none.
        like.gaussians = Gaussians::joined((like.gaussians, 0), (other.gaussians.clone(), 0));
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
            notes.push("some inputs have no radii, so those of the others are left out".to_owned());
        }
        like.radii = likes().all(has_own).then(Vec::new);
        if likes().any(|like| like.prepared.is_some()) {
            notes.push("what was prepared for one of several clouds is left out".to_owned());
        }
        like.prepared = None;
    }
    (like, notes)
}
