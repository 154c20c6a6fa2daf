//! Lengths that hardly anybody means, as those in another unit than the scene's.

use super::scene::Scene;
use super::settings::CloudSettings;
use pellucid_core::points::Points;

/// Points of a scene that was hardly made by hand, at least. Scenes of a few points have large ones on purpose.
const LEAST_POINTS: usize = 100;

/// Share of the scene's diagonal below which a picture hardly shows anything.
const LEAST_HEIGHT: f64 = 1e-4;

/// Returns warnings about given radii that are larger than a scene whose eye is not given, and about a given height of
/// an orthographic picture that is far smaller, one sentence each.
pub fn odd_sizes(scene: &Scene, points: &Points) -> Vec<String> {
    let diagonal = points.bounds().map_or(0.0, |bounds| bounds.diagonal());
    if points.len() < LEAST_POINTS || diagonal == 0.0 {
        return Vec::new();
    }
    // Whoever placed the eye saw what the radius does.
    let clouds = scene.clouds.iter().filter(|_| scene.camera.eye.is_none());
    let radii = clouds.filter_map(|cloud| Some((cloud, largest_given(cloud)?)));
    let radii = radii.filter(|(_, radius)| f64::from(*radius) > diagonal).map(|(cloud, radius)| {
        let path = cloud.path.display();
        format!("{path}: a radius of {radius} is larger than the scene, whose diagonal is {diagonal:.4}: is it in the same unit?")
    });
    let height = scene.camera.height.filter(|height| *height < LEAST_HEIGHT * diagonal).map(|height| {
        format!("a picture {height} high shows next to nothing of the scene, whose diagonal is {diagonal:.4}: is `camera.height` in the same unit?")
    });
    radii.chain(height).collect()
}

/// The largest radius that a cloud's settings give.
fn largest_given(cloud: &CloudSettings) -> Option<f32> {
    cloud.class.iter().filter_map(|entry| entry.radius).chain(cloud.radius).reduce(f32::max)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;

    fn warnings(keys: &str, count: u32) -> Vec<String> {
        let text = format!("[[cloud]]\npath = 'a.las'\n{keys}");
        let scene = Scene::from_toml(&text, Path::new("s.toml")).unwrap();
        // A diagonal of 5.
        let place = |i: u32| DVec3::new(3.0, 4.0, 0.0) * f64::from(i) / f64::from(count - 1);
        odd_sizes(&scene, &Points { positions: (0..count).map(place).collect(), ..Points::default() })
    }

    #[test]
    fn a_radius_larger_than_the_scene_is_told() {
        let [warning] = &warnings("radius = 500", 100)[..] else { panic!("one warning") };
        let of_class = warnings("radius = 1\n[[cloud.class]]\nid = 2\nradius = 500", 100);
        assert!(of_class.len() == 1 && of_class[0] == *warning, "{of_class:?}");
        assert!(
            warning.starts_with("a.las: a radius of 500 is larger than the scene, whose diagonal is 5.0000"),
            "{warning}"
        );
        assert!(warnings("radius = 4.9", 100).is_empty() && warnings("", 100).is_empty());
        assert!(warnings("radius = 500", 99).is_empty(), "a scene made by hand");
        assert!(warnings("radius = 500\n[camera]\neye = [0, 0, 9]", 100).is_empty(), "looked at by hand");
    }

    #[test]
    fn a_height_far_below_the_scene_is_told() {
        let camera = |height: f64| format!("[camera]\nheight = {height}");
        let [warning] = &warnings(&camera(0.0004), 100)[..] else { panic!("one warning") };
        assert!(warning.starts_with("a picture 0.0004 high") && warning.contains("`camera.height`"), "{warning}");
        assert!(warnings(&camera(0.0006), 100).is_empty());
    }
}
