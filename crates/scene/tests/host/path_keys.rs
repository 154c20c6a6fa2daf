//! A key gives the camera of a scene that has the key's numbers in `[camera]`, to the last bit: the same picture.

use std::path::Path;

use glam::{DVec3, Vec3};
use pellucid_core::camera::path::{CameraPath, Curve, Key};
use pellucid_core::cloud::UpAxis;
use pellucid_core::points::Points;
use pellucid_scene::{self as scene, Course, Scene};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

fn points(center: DVec3) -> Points {
    let positions = vec![center - DVec3::new(3.0, 2.0, 1.0), center, center + DVec3::new(2.0, 4.0, 3.0)];
    Points {
        colors: vec![Vec3::ONE; positions.len()],
        opacities: vec![1.0; positions.len()],
        radii: vec![0.3; positions.len()],
        positions,
        ..Points::default()
    }
}

#[test]
fn keys_are_cameras_of_scenes_to_the_last_bit() {
    let mut random = Pcg64::seed_from_u64(5);
    let mut vector = |scale: f64| DVec3::from_array(std::array::from_fn(|_| scale * random.random_range(-1.0..1.0)));
    for case in 0..500 {
        // Near the origin and where surveys are.
        let center = if case % 2 == 0 { DVec3::ZERO } else { DVec3::new(4_500_000.0, 850_000.0, 300.0) };
        let points = points(center);
        let keys = (0..3).map(|_| (center + vector(9.0), center + vector(3.0), vector(1.0)));
        let keys: Vec<_> = keys.collect();
        let lens = if case % 3 == 0 { "height = 7.3" } else { "fov_y = 37.1" };
        let depths = if case % 5 == 0 { "near = 0.37" } else { "" };
        let text = |[eye, target, up]: [DVec3; 3]| {
            let of = |vector: DVec3| format!("{:?}", vector.to_array());
            let camera = format!("eye = {}\ntarget = {}\nup = {}", of(eye), of(target), of(up));
            format!("[camera]\n{camera}\n{lens}\n{depths}\n[[cloud]]\npath = \"a.ply\"\n")
        };
        let scenes = keys
            .iter()
            .map(|(eye, target, up)| Scene::from_toml(&text([*eye, *target, *up]), Path::new("s.toml")).unwrap());
        let scenes: Vec<Scene> = scenes.collect();
        let key = |(eye, target, up): &(DVec3, DVec3, DVec3)| Key {
            target: Some(target.to_array()),
            up: Some(up.to_array()),
            fov_y: scenes[0].camera.fov_y,
            height: scenes[0].camera.height,
            ..Key::at(eye.to_array())
        };
        let path = CameraPath::new(keys.iter().map(key).collect());
        // As a file has it.
        let path = CameraPath::from_json(&path.to_json(), Path::new("p.json")).unwrap();
        let course = Course::new(&scenes[0], &points, UpAxis::Z).unwrap();
        let curve = Curve::new(&path, &course.defaults()).unwrap();
        let frames = curve.frames(7);
        for (at, scene) in scenes.iter().enumerate() {
            let (expected, _) = scene::camera(scene, &points, UpAxis::Z).unwrap();
            for pose in [curve.key_poses()[at], frames[3 * at]] {
                assert_eq!(course.camera(&pose).unwrap().camera(), expected, "case {case}, key {at}");
            }
            let settings = scene.camera;
            let at = scene::camera_at(&settings, &points.bounds().unwrap(), f64::from(0.3f32)).unwrap();
            assert_eq!(at, expected, "case {case}");
        }
    }
}
