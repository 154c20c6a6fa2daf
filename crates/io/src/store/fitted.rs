//! Clouds with the columns that several have together.

use glam::Vec3;

use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;

/// Returns the points of a cloud with the columns of another one. Where it lacks one, they are white, opaque, without
/// normal, of class 0, and have no number (NaN) as intensity and scalars. There is no such value for radii and what was
/// prepared.
pub(super) fn fitted(cloud: Cloud, like: &Cloud) -> Cloud {
    fn column<T: Clone>(own: Option<Vec<T>>, like: &Option<Vec<T>>, missing: T, len: usize) -> Option<Vec<T>> {
        like.as_ref().map(|_| own.unwrap_or_else(|| vec![missing; len]))
    }
    let len = cloud.len();
    let mut own = cloud.scalars;
    let scalar = |(name, _): &(String, Vec<f32>)| {
        let found = own.iter().position(|(known, _)| known == name).map(|at| own.swap_remove(at).1);
        (name.clone(), found.unwrap_or_else(|| vec![f32::NAN; len]))
    };
    Cloud {
        positions: cloud.positions,
        colors: column(cloud.colors, &like.colors, Vec3::ONE, len),
        alphas: column(cloud.alphas, &like.alphas, 1.0, len),
        normals: column(cloud.normals, &like.normals, Vec3::ZERO, len),
        gaussians: gaussians(cloud.gaussians, like.gaussians.as_ref(), len),
        filter: like.filter,
        radii: like.radii.as_ref().and(cloud.radii),
        classification: column(cloud.classification, &like.classification, 0, len),
        intensity: column(cloud.intensity, &like.intensity, f32::NAN, len),
        scalars: like.scalars.iter().map(scalar).collect(),
        prepared: like.prepared.as_ref().and(cloud.prepared),
        up: like.up,
        up_reason: like.up_reason,
        crs: like.crs.clone(),
        up_is_convention: like.up_is_convention,
        ..Cloud::default()
    }
}

/// Gaussians of the degree that all have; points that are none where there were none.
fn gaussians(own: Option<Gaussians>, like: Option<&Gaussians>, len: usize) -> Option<Gaussians> {
    like.map(|like| own.unwrap_or_else(|| Gaussians::none(len)).with_degree(like.degree))
}
