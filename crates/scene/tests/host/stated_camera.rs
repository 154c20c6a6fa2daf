//! The numbers of a camera, as pictures hold them, give it again to the last bit: the same picture.

use glam::{DQuat, DVec3};
use pellucid_core::camera::path::{CameraPath, Curve, Key};
use pellucid_core::camera::{Projection, StatedCamera};
use pellucid_core::cloud::UpAxis;
use pellucid_core::points::Points;
use pellucid_scene::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::scene::{CLOUD, scene_of};
use crate::scene_camera::points;

/// Near the origin, where surveys are, and where nothing is.
const PLACES: [DVec3; 3] = [DVec3::ZERO, DVec3::new(512_345.67, 5_403_210.98, 312.5), DVec3::new(-4.1e9, 3.3e9, 7.0e8)];

fn blob(center: DVec3) -> Points {
    let mut random = Pcg64::seed_from_u64(11);
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
    let positions: Vec<DVec3> = (0..40).map(|_| center + vector() * DVec3::new(9.0, 4.0, 2.0)).collect();
    points(&positions, 0.25)
}

/// Asserts that the numbers of a camera give it again, and the vertical of its scene, without anything of its scene.
#[track_caller]
fn assert_comes_back(camera: &StatedCamera, points: &Points, up: UpAxis, vertical: Vertical, case: &str) {
    let text = camera.to_toml();
    let again = scene_of(&format!("[camera]\n{text}\n{CLOUD}"));
    let (found, warnings) = stated_camera(&again, points, up).unwrap();
    assert_eq!(warnings.iter().filter(|warning| !warning.contains("sees nothing")).count(), 0, "{case}: {warnings:?}");
    assert_eq!((found, found.to_toml()), (*camera, text.clone()), "{case}");
    assert_eq!(again.camera.vertical(up), vertical, "{case}: {text}");
    // Depths are given, so other points change nothing.
    let other = blob(DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(camera_at(&again.camera, &other.bounds().unwrap(), 9.0), Some(camera.camera()), "{case}");
}

#[test]
fn a_camera_comes_back_from_its_numbers_to_the_last_bit() {
    let straight = [90.0, -90.0, 89.99, 89.9].map(|elevation| View { elevation: Some(elevation), ..View::default() });
    let named = ViewName::ALL.iter().map(|(name, ..)| View { name: Some(*name), ..View::default() });
    let odd = View { azimuth: Some(123.4), elevation: Some(-71.3), ..View::default() };
    let views: Vec<View> = [View::default(), odd].into_iter().chain(straight).chain(named).collect();
    let texts =
        ["", "fov_y = 33.3", "ortho = true", "height = 7.7", "near = 0.37", "up = [0, -2, 0.1]", "up = [1, 1, 0]"];
    for place in PLACES {
        let points = blob(place);
        for (text, up) in
            texts.iter().flat_map(|text| [(text, UpAxis::Z), (text, UpAxis::Y), (text, UpAxis::NegativeY)])
        {
            for view in &views {
                let mut scene = scene_of(&format!("[camera]\n{text}\n{CLOUD}"));
                scene.camera.view = *view;
                let (camera, _) = stated_camera(&scene, &points, up).unwrap();
                let case = format!("{place}, {text:?}, {view:?}, {up:?}");
                assert_comes_back(&camera, &points, up, scene.camera.vertical(up), &case);
            }
        }
    }
}

#[test]
fn a_stated_camera_comes_back_with_its_own_numbers() {
    for place in PLACES {
        let (points, of) = (blob(place), |v: DVec3| format!("{:?}", (place + v).to_array()));
        let (eye, target) = (of(DVec3::new(20.3, -31.1, 17.0)), of(DVec3::new(0.1, 0.2, 0.3)));
        for text in [
            format!("eye = {eye}"),
            format!("target = {target}"),
            format!("eye = {eye}\ntarget = {target}"),
            format!("eye = {eye}\ntarget = {target}\nup = [0.1, 0.2, 7.0]\nfov_y = 61.7"),
            format!("eye = {eye}\ntarget = {target}\northo = true"),
            format!("eye = {}\nup = [0, 1, 0]", of(DVec3::Z * 30.0)),
        ] {
            let scene = scene_of(&format!("[camera]\n{text}\n{CLOUD}"));
            let (camera, _) = stated_camera(&scene, &points, UpAxis::Z).unwrap();
            let CameraSettings { eye, target, up, .. } = scene.camera;
            assert!(eye.is_none_or(|eye| eye == camera.eye) && target.is_none_or(|target| target == camera.target()));
            assert!(up.is_none_or(|up| up == camera.stated_up()), "{text}");
            assert_comes_back(&camera, &points, UpAxis::Z, scene.camera.vertical(UpAxis::Z), &text);
        }
    }
}

#[test]
fn the_numbers_of_a_view_are_those_that_a_person_would_write() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.0);
    let of = |name| {
        let mut scene = scene_of(&format!("[camera]\nheight = 4\nnear = 0.5\nfar = 9\n{CLOUD}"));
        scene.camera.view = View { name: Some(name), ..View::default() };
        stated_camera(&scene, &cube, UpAxis::Z).unwrap().0.to_toml()
    };
    // The eye stands a tenth of the diagonal, 2√3/10, before the cube.
    let distance = 1.0 + 0.1 * 12f64.sqrt();
    let front = format!("eye = [0.0, -{distance:?}, 0.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 0.0, 1.0]\n");
    assert_eq!(of(ViewName::Front), format!("{front}height = 4.0\nnear = 0.5\nfar = 9.0\n"));
    // The vertical is along the view, and nearest to `up` nevertheless.
    assert!(of(ViewName::Top).contains("\nup = [0.0, 1.0, 2.0]\n"), "{}", of(ViewName::Top));
}

#[test]
fn frames_of_paths_and_turns_come_back_to_the_last_bit() {
    let mut random = Pcg64::seed_from_u64(3);
    let mut vector = || DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
    for place in PLACES {
        let points = blob(place);
        let turn = |i: usize| {
            // A camera of another program: an orientation, and an angle of no round number of degrees.
            let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, vector().normalize());
            let (eye, [x, y, z, w]) = (place + 30.0 * vector(), turn.to_array());
            let fov_y = Some((1.1 + 0.01 * i as f64).to_degrees());
            Key { orientation: Some([w, x, y, z]), fov_y, ..Key::at(eye.to_array()) }
        };
        let path = CameraPath::new((0..20).map(turn).collect());
        for up in [UpAxis::Z, UpAxis::Y] {
            let scene = scene_of(CLOUD);
            let course = Course::new(&scene, &points, up).unwrap();
            let curve = Curve::new(&path, &course.defaults()).unwrap();
            let turn = course.turntable().unwrap().0;
            let level = turn.frames(17).into_iter().map(|pose| (pose, true));
            let free = curve.frames(101).into_iter().chain(curve.key_poses()).map(|pose| (pose, false));
            for (pose, is_level) in level.chain(free) {
                let camera = course.camera(&pose).unwrap();
                // As near as a target in float64 allows.
                let slack = 1e-14 + 1e-15 * place.abs().max_element();
                assert!((camera.forward - pose.forward).length() < slack && camera.eye == pose.eye, "{pose:?}");
                // Straight views turn the image's top by more than the view.
                assert!((camera.right - pose.right).length() < 2e3 * slack, "{camera:?}, {pose:?}");
                let (Projection::Perspective { fov_y }, Projection::Perspective { fov_y: wanted }) =
                    (camera.projection, pose.projection)
                else {
                    panic!("{camera:?}")
                };
                assert!((fov_y - wanted).abs() < 1e-15, "{fov_y}, not {wanted}");
                // The vertical of the scene is kept, except by a camera that is tilted by more than 30°.
                let vertical = Vertical::from(up);
                let kept = Vertical::nearest(camera.stated_up()).unwrap_or(vertical);
                let [aside, upward] = [pose.right, pose.up].map(|axis| axis.dot(vertical.up()));
                let is_upright = is_level || (aside.abs() < 0.5 && upward > 2e-3);
                assert!(kept == vertical || !is_upright, "{pose:?}: {}", camera.to_toml());
                assert_comes_back(&camera, &points, up, kept, &format!("{pose:?}"));
            }
        }
    }
}
