//! Opaque points: the reference for their images, and findings about them.

mod clouds;
pub(super) mod figures;
pub(super) mod findings;
pub(super) mod shadows;
mod truth;

pub(super) use clouds::Clouds;
pub(super) use truth::Silhouette;
pub(in crate::report) use truth::supersampled;
