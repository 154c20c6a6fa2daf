//! Text of `info` about Gaussian splats.

use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::Gaussians;
use serde_json::{Value, json};

use super::histogram::short;

/// The least, the median and the largest standard deviation along any axis.
fn extents(splats: &Gaussians) -> [f32; 3] {
    let mut all: Vec<f32> = splats.extents.iter().flat_map(|extents| extents.to_array()).collect();
    all.sort_unstable_by(f32::total_cmp);
    [0, all.len() / 2, all.len().saturating_sub(1)].map(|at| all.get(at).copied().unwrap_or_default())
}

/// Returns the facts of splats as JSON: {count, degree, filter, extents: {min, median, max}}.
pub fn json(splats: &Gaussians, filter: Option<Filter>) -> Value {
    let [min, median, max] = extents(splats);
    json!({
        "count": splats.len(),
        "degree": splats.degree,
        "filter": filter.map(Filter::name),
        "extents": { "min": min, "median": median, "max": max },
    })
}

/// Lines, each after a line break.
pub fn text(splats: &Gaussians, filter: Option<Filter>) -> String {
    let [min, median, max] = extents(splats).map(|extent| short(extent.into()));
    let filter = filter.map(|filter| format!(", trained with filter {}", filter.name())).unwrap_or_default();
    format!(
        "\n  gaussians   {}, harmonics of degree {}{filter}\n  extents     {min} to {max}, median {median}",
        splats.len(),
        splats.degree
    )
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn splats_are_described() {
        let extents = vec![Vec3::new(3.0, 1.0, 2.0), Vec3::new(0.5, 0.0, 8.0)];
        let splats = Gaussians { extents, ..Gaussians::none(2) };
        assert_eq!(super::extents(&splats), [0.0, 2.0, 8.0]);
        assert_eq!(json(&splats, Some(Filter::Mip))["filter"], "mip");
        let text = text(&splats, Some(Filter::Flat));
        assert!(text.contains("gaussians   2, harmonics of degree 0, trained with filter 2dgs"), "{text}");
        assert!(text.contains("extents     0 to 8, median 2"), "{text}");
    }
}
