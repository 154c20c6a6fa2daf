//! The background of a scene that leaves it to its points: white where these are dark.

use glam::Vec3;
use pellucid_core::points::Points;
use rayon::prelude::*;

use crate::prepare::radius::median;

/// The median luminance below which points are dark on black, linear.
const DARK: f64 = 0.05;

/// Returns `true` if the median relative luminance (ITU-R BT.709) of the colors of drawn points is below 0.05, of
/// clouds with many points that of a sample. Neither the order of the points nor where they are kept affects it.
pub fn are_dark(points: &Points) -> bool {
    let mut luminances: Vec<f64> = points.sampled_colors().map(luminance).collect();
    // Where nearly all points are in one place, the sample may hold none.
    if luminances.is_empty() {
        luminances = points.colors.par_iter().map(luminance).collect();
    }
    !luminances.is_empty() && median(&mut luminances) < DARK
}

fn luminance(color: &Vec3) -> f64 {
    color.as_dvec3().dot(glam::DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use pellucid_core::points::Unseen;

    use super::*;
    use crate::{Background, Document, Overrides, Setting};

    fn points(colors: Vec<Vec3>) -> Points {
        let positions = (0..colors.len()).map(|i| DVec3::new(i as f64, 0.0, 1.0)).collect();
        Points { colors, ..pellucid_testing_host::white(positions, 0.5) }
    }

    #[test]
    fn points_with_a_median_luminance_below_a_twentieth_are_dark() {
        let grays = |grays: &[f32]| points(grays.iter().map(|gray| Vec3::splat(*gray)).collect());
        assert!(are_dark(&grays(&[0.049, 0.01, 0.02])));
        assert!(!are_dark(&grays(&[0.051, 0.06, 0.0])));
        assert!(are_dark(&grays(&[1.0, 0.0, 0.04, 0.01, 1.0])), "two of five are bright");
        assert!(!are_dark(&grays(&[0.0, 0.11])), "the mean of the two in the middle is 0.055");
        assert!(are_dark(&grays(&[0.0, 0.09])));
        assert!(!are_dark(&grays(&[])));
        // Blue is darker than green.
        assert!(are_dark(&points(vec![Vec3::Z * 0.6; 3])) && !are_dark(&points(vec![Vec3::Y * 0.6; 3])));
    }

    #[test]
    fn points_that_are_not_drawn_do_not_count() {
        let mut bright = points(vec![Vec3::ONE; 5]);
        bright.unseen = Arc::new(Unseen { positions: vec![DVec3::ONE; 99], radii: vec![0.5; 99] });
        assert!(!are_dark(&bright));
    }

    #[test]
    fn neither_order_nor_a_sample_changes_the_background() {
        // So many that only some are looked at.
        let colors = |i: usize| if i % 100 < 51 { Vec3::splat(0.01) } else { Vec3::ONE };
        let all = points((0..300_000).map(colors).collect());
        assert!(are_dark(&all));
        let backward = all.clone().in_order(|i| 299_999 - i);
        assert!(are_dark(&backward));
        let known = all.known().unwrap();
        assert!(are_dark(&all.sampled_points().standing_for(&known, String::new())));
        // All in a place that is not sampled.
        for x in 0..4 {
            assert!(are_dark(&Points { positions: vec![DVec3::splat(f64::from(x)); 300_000], ..all.clone() }));
        }
    }

    #[test]
    fn clouds_without_a_scene_file_leave_the_background_to_their_points() {
        let (dark, bright) = (points(vec![Vec3::splat(0.02); 9]), points(vec![Vec3::splat(0.5); 9]));
        let named = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap();
        for (points, color, name) in [(&dark, Vec3::ONE, "white"), (&bright, Vec3::ZERO, "black")] {
            let mut scene = named.scene().unwrap();
            assert_eq!(scene.image.background, Background::Auto);
            assert_eq!(scene.settle_background(|| are_dark(points)), Some(name));
            assert_eq!(scene.image.background, Background::Color(color));
            assert_eq!(scene.settle_background(|| true), None, "settled once");
        }
        // A given one stays, and a scene file has a black one.
        let mut given = named.clone();
        let mut scene = given.set("image.background", Setting::from([0.0; 3])).unwrap();
        assert_eq!(scene.settle_background(|| true), None);
        let file = |text: &str| {
            let text = format!("{text}\n[[cloud]]\npath = 'a.ply'");
            Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap().scene().unwrap()
        };
        assert_eq!(file("").image.background, Background::Color(Vec3::ZERO));
        assert_eq!(file("image = { background = 'auto' }").settle_background(|| true), Some("white"));
        assert_eq!(file("image = { background = 'white' }").image.background, Background::Color(Vec3::ONE));
        // Saved, it is what it was.
        let saved = named.to_toml("".as_ref()).unwrap();
        let again = Document::from_toml(&saved, "s.toml".as_ref(), &Overrides::default()).unwrap();
        assert_eq!(again.scene().unwrap().image.background, Background::Auto);
        assert!(!given.to_toml("".as_ref()).unwrap().contains("auto"));
    }
}
