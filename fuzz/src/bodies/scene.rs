//! Scene files, with options laid over them, up to where a device would be needed.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_engine::plan;
use pellucid_scene::{self as scene, Overrides, Scene};

use super::with_file;

/// Clouds of a scene that are taken further than the checks.
const MOST_CLOUDS: usize = 4;

/// A scene file. A line `#set KEY=VALUE`, a comment to TOML, is an option `--set KEY=VALUE`.
pub fn scene(input: &[u8]) {
    let Ok(text) = str::from_utf8(input) else { return };
    let mut overrides = Overrides::default();
    for pair in text.lines().filter_map(|line| line.strip_prefix("#set ")) {
        // The command line ends here.
        if overrides.set_pair(pair).is_err() {
            return;
        }
    }
    let Ok(scene) = Scene::from_toml_with(text, Path::new("folder/input.toml"), &overrides) else { return };
    if scene.clouds.len() <= MOST_CLOUDS {
        let clouds = scene.clouds.iter().map(|_| sample()).collect();
        arrange(&scene, clouds);
    }
}

/// A GeoJSON file whose polygons cut a cloud.
pub fn polygon(input: &[u8]) {
    with_file("area.geojson", input, |path| {
        let text = "[[cloud]]\npath = 'a.ply'\nradius = 1\n[[clip]]\npolygon = 'area.geojson'\n";
        arrange(&Scene::from_toml(text, path).expect("a scene"), vec![sample()]);
    });
}

/// Makes of clouds what a renderer gets.
pub(super) fn arrange(scene: &Scene, clouds: Vec<Cloud>) {
    scene::notes(scene, &clouds, scene.method.needs_radii());
    scene::shadow_texture(scene, &clouds, 1);
    let up = scene::up_axis(&clouds);
    let Ok(arranged) = scene::arrange(scene, clouds, 1, &Progress::hidden()) else { return };
    let points = arranged.points();
    assert!(points.positions.iter().all(|position| position.is_finite()));
    assert!(points.radii.iter().all(|radius| radius.is_finite() && *radius >= 0.0), "a radius out of range");
    scene::note_of_layers(scene, points);
    plan::resolve(scene.method, points);
    if let Ok((camera, _)) = scene::camera(scene, points, up) {
        assert!(camera.eye.is_finite() && camera.near > 0.0 && camera.near < camera.far, "{camera:?}");
    }
}

/// A little cloud that has every column.
fn sample() -> Cloud {
    const POINTS: u8 = 30;
    let position = |i: u8| DVec3::new((i % 5).into(), (i / 5 % 3).into(), 0.25 * f64::from(i));
    let column = |value: fn(u8) -> f32| (0..POINTS).map(value).collect();
    Cloud {
        positions: (0..POINTS).map(position).collect(),
        colors: Some(vec![Vec3::new(0.5, 0.25, 1.0); POINTS.into()]),
        alphas: Some(column(|i| f32::from(i) / 30.0)),
        normals: Some((0..POINTS).map(|i| if i == 7 { Vec3::ZERO } else { Vec3::Z }).collect()),
        classification: Some((0..POINTS).map(|i| i % 6).collect()),
        intensity: Some(column(|i| f32::from(i) * 100.0)),
        scalars: vec![("word".to_owned(), column(|i| if i == 3 { f32::NAN } else { f32::from(i) }))],
        ..Cloud::default()
    }
}
