//! Number of soft points, and a warning where a method that is made for them finds none.

use pellucid_core::points::Points;
use pellucid_engine::passes::project::Parts;
use pellucid_scene::Method;

/// Says how many points a threshold makes soft, and between which ends their field lies.
pub(crate) fn count(parts: &Parts, threshold: f32) -> String {
    let Parts { solid, soft, .. } = parts;
    format!("{soft} of {} points are soft (F above {threshold}; {})", solid + soft, ends(parts))
}

/// Says so where no point is soft: how many points there are, the threshold, the ends of F, and what would change it.
pub(crate) fn none(parts: &Parts, threshold: f32) -> Option<String> {
    if parts.soft > 0 {
        return None;
    }
    let advice = match parts.ends {
        Some([low, high]) if low < high => format!("a threshold below {high} makes some soft"),
        Some([_, high]) if high > 0.0 => {
            format!("a threshold below {high} makes all soft, and cloud.field names another field")
        }
        _ => "cloud.field names another field".to_owned(),
    };
    Some(format!(
        "0 of {} points are soft, so that all are drawn solid: none has a field F above method.threshold = {threshold}; {}; \
         {advice}",
        parts.solid,
        ends(parts)
    ))
}

/// Says so where no point of a scene is soft; `None` for methods without soft points as well.
pub fn without_soft_points(points: &Points, method: &Method) -> Option<String> {
    let threshold = method.threshold()?;
    none(&Parts::count(points, threshold), threshold)
}

fn ends(parts: &Parts) -> String {
    match parts.ends {
        Some([low, high]) if low == high => format!("F is {low} everywhere"),
        Some([low, high]) => format!("F goes from {low} to {high}"),
        None => "there is no F".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::Soft;

    fn said(fields: &[f32], threshold: f32) -> Option<String> {
        let count = fields.len();
        let points = Points {
            positions: vec![glam::DVec3::ZERO; count],
            fields: fields.to_vec(),
            radii: vec![1.0; count],
            ..Points::default()
        };
        without_soft_points(&points, &Method::SoftBase(Soft { threshold, ..Soft::default() }))
    }

    #[test]
    fn no_soft_point_is_told_with_count_threshold_and_ends() {
        let told = said(&[0.25, 0.125, 0.375], 0.5).unwrap();
        let parts = ["0 of 3 points are soft", "method.threshold = 0.5", "F goes from 0.125 to 0.375", "below 0.375"];
        assert!(parts.iter().all(|part| told.contains(part)), "{told}");
        assert_eq!(said(&[0.25, 0.125, 0.375], 0.25), None);
        // F at the threshold is not above it.
        assert!(said(&[0.5, 0.5], 0.5).unwrap().contains("F is 0.5 everywhere; a threshold below 0.5 makes all soft"));
        assert!(said(&[0.0, 0.0], 0.0).unwrap().ends_with("F is 0 everywhere; cloud.field names another field"));
        assert_eq!(without_soft_points(&Points::default(), &Method::Points), None);
    }

    #[test]
    fn soft_points_are_counted_with_the_ends_of_their_field() {
        let parts = Parts { solid: 3, soft: 4, median_radius: 1.0, ends: Some([0.0, 0.75]) };
        assert_eq!(count(&parts, 0.5), "4 of 7 points are soft (F above 0.5; F goes from 0 to 0.75)");
    }
}
