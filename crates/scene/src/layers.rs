//! Notes on the distance of layers.

use super::scene::Scene;
use crate::prepare::layer_distance;
use pellucid_core::points::Points;

/// Says if the default of `method.min_layer_distance`, where that is in force, differs from what the points' spacing
/// suggests ([`layer_distance::suggest`]) by a factor of more than 3.
pub fn note_of_layers(scene: &Scene, points: &Points) -> Option<String> {
    scene.method.fixed()?.filters().filter(|filters| filters.min_layer_distance.is_none())?;
    let default = 0.01 * points.bounds()?.diagonal();
    let suggested = layer_distance::suggest(points)?;
    let is_near = (suggested / 3.0..=suggested * 3.0).contains(&default);
    let (default, suggested) = (two_digits(default), two_digits(suggested));
    let says = "method.min_layer_distance is 1% of the scene's diagonal";
    (!is_near).then(|| format!("{says}, {default}; the spacing of the points suggests {suggested}"))
}

/// A positive number to two significant digits.
fn two_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    if (1e-4..1e6).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pellucid_core::progress::Progress;

    use super::*;
    use crate::{Overrides, assemble, procedural, take_generated};

    /// The note for three tori of this many points.
    fn note(points: u32, settings: &[&str]) -> Option<String> {
        let generated = procedural::build("tori", &[("points".into(), f64::from(points))], 0).unwrap();
        let mut overrides = Overrides::default();
        settings.iter().for_each(|pair| overrides.set_pair(pair).unwrap());
        let scene = Scene::from_toml_with(&generated.scene_toml, Path::new("tori"), &overrides).unwrap();
        let clouds = take_generated(&scene, &generated).unwrap();
        note_of_layers(&scene, &assemble(&scene, clouds, false, &Progress::hidden()).unwrap())
    }

    #[test]
    fn a_default_far_from_the_spacing_is_noted_where_it_counts() {
        // The diagonal is 4.2. Of 10000 points the spacing is 0.06, of 1000000 it is 0.006; 4.9 times that is
        // suggested.
        let sparse = note(10_000, &["method.name=image-space"]).unwrap();
        let (says, suggested) = sparse.rsplit_once(' ').unwrap();
        assert_eq!(
            says,
            "method.min_layer_distance is 1% of the scene's diagonal, 0.042; the spacing of the points suggests"
        );
        // 0.29; rings are shifted at random, so that the 8th neighbor gives the spacing to within a seventh.
        assert!((0.25..0.33).contains(&suggested.parse::<f64>().unwrap()), "{suggested}");
        assert!(note(10_000, &["method.name=peel-layers"]).is_some());
        assert_eq!(note(1_000_000, &["method.name=image-space"]), None);
        assert_eq!(note(10_000, &["method.name=image-space", "method.min_layer_distance=0.05"]), None);
        assert_eq!(note(10_000, &[]), None);
    }

    #[test]
    fn numbers_are_short() {
        for (value, wanted) in
            [(0.034_41, "0.034"), (1234.5, "1200"), (0.999, "1"), (3.14e-7, "3.1e-7"), (2.56e9, "2.6e9")]
        {
            assert_eq!(two_digits(value), wanted);
        }
    }
}
