//! The columns that several clouds have as one.

use super::super::Store;
use super::super::tiles::{differing_crs, like};
use pellucid_core::cloud::Cloud;

/// Returns a cloud without points that has the columns of all stores, and notes on what can't be kept, one sentence
/// each.
///
/// Radii are kept if all have them. What was prepared for one cloud says nothing of several.
pub(super) fn union(inputs: &[Box<dyn Store>]) -> (Cloud, Vec<String>) {
    if let [only] = inputs {
        return (only.summary().like.clone(), Vec::new());
    }
    let summaries: Vec<_> = inputs.iter().map(|input| input.summary()).collect();
    let likes = || summaries.iter().map(|summary| &summary.like);
    let mut notes: Vec<String> = differing_crs(&summaries).into_iter().collect();
    let warnings = likes().flat_map(|like| &like.warnings).cloned().collect();
    let mut like = Cloud { warnings, ..like(&summaries) };
    let has_own = |like: &Cloud| like.own_radii().is_some();
    if likes().any(has_own) && !likes().all(has_own) {
        notes.push("some inputs have no radii, so those of the others are left out".to_owned());
    }
    like.radii = likes().all(has_own).then(Vec::new);
    if likes().any(|like| like.prepared.is_some()) {
        notes.push("what was prepared for one of several clouds is left out".to_owned());
    }
    like.prepared = None;
    (like, notes)
}
