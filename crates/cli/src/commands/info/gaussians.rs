//! Text of `info` about Gaussian splats.

use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians};
use pellucid_core::cloud::{Cloud, UpAxis};
use serde_json::{Value, json};

use super::histogram::short;

/// The least, the median and the largest standard deviation along any axis.
fn extents(splats: &Gaussians) -> [f32; 3] {
    let mut all: Vec<f32> = splats.extents.iter().flat_map(|extents| extents.to_array()).collect();
    all.sort_unstable_by(f32::total_cmp);
    [0, all.len() / 2, all.len().saturating_sub(1)].map(|at| all.get(at).copied().unwrap_or_default())
}

/// The word for the colors of splats.
fn color(splats: &Gaussians) -> &'static str {
    match splats.coding {
        ColorCoding::Display => "encoded",
        ColorCoding::Linear => "linear",
        ColorCoding::Each(_) => "both",
    }
}

/// Returns the facts of a cloud's splats as JSON: {count, degree, filter, up, color, extents: {min, median, max}}.
pub fn json(splats: &Gaussians, cloud: &Cloud) -> Value {
    let [min, median, max] = extents(splats);
    json!({
        "count": splats.len(),
        "degree": splats.degree,
        "filter": cloud.filter.map(Filter::name),
        "up": cloud.up,
        "color": color(splats),
        "extents": { "min": min, "median": median, "max": max },
    })
}

/// Lines, each after a line break.
pub fn text(splats: &Gaussians, cloud: &Cloud) -> String {
    let [min, median, max] = extents(splats).map(|extent| short(extent.into()));
    let filter = cloud.filter.map(|filter| format!(", trained with filter {}", filter.name())).unwrap_or_default();
    let color = match splats.coding {
        ColorCoding::Display => "",
        ColorCoding::Linear => ", colors linear",
        ColorCoding::Each(_) => ", some colors linear",
    };
    let up = match cloud.up {
        UpAxis::X => "x",
        UpAxis::Y => "y",
        UpAxis::Z => "z",
        UpAxis::NegativeY => "-y",
    };
    format!(
        "\n  gaussians   {}, harmonics of degree {}{filter}{color}\n  up          {up}\n  extents     {min} to {max}, median \
         {median}",
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
        let of = |filter, up| Cloud { filter: Some(filter), up, ..Cloud::default() };
        let value = json(&splats, &of(Filter::Mip, UpAxis::NegativeY));
        assert_eq!((&value["filter"], &value["up"], &value["color"]), (&json!("mip"), &json!("-y"), &json!("encoded")));
        let linear = Gaussians { coding: ColorCoding::Linear, ..splats.clone() };
        assert!(text(&linear, &of(Filter::Flat, UpAxis::Z)).contains("filter 2dgs, colors linear\n  up          z\n"));
        let text = text(&splats, &of(Filter::Flat, UpAxis::Y));
        assert!(text.contains("gaussians   2, harmonics of degree 0, trained with filter 2dgs"), "{text}");
        assert!(text.contains("extents     0 to 8, median 2"), "{text}");
    }
}
