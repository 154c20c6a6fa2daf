//! Key frames: made of the camera, gone to, played, saved, and read from files.

use super::*;
use pellucid_core::camera::import::CameraSource;
use pellucid_core::camera::path::{CameraPath, Key};
use pellucid_scene::{CameraSettings, Course};

/// A model with three keys, half a turn of the picture's height apart, and the cameras of their pictures.
fn with_keys() -> (Model, Vec<CameraSettings>) {
    let (mut model, _) = settled();
    let mut cameras = Vec::new();
    for step in 0..3 {
        if step > 0 {
            model.navigate(|navigator| navigator.orbit(DVec2::new(6.0, 1.0), 48.0));
        }
        model.add_key();
        let Pose::At(camera) = model.pose() else { panic!("a key is a place") };
        cameras.push(camera);
    }
    assert_eq!((model.route.keys().len(), model.message.clone()), (3, None));
    (model, cameras)
}

fn pose(model: &mut Model) -> Pose {
    asked(model, Instant::now()).expect("a picture is due").pose
}

/// The picture at a key is the one that `render --path` makes there: the same camera to the last bit.
#[test]
fn a_key_is_the_camera_that_is_shown() {
    let (mut model, cameras) = with_keys();
    let scene = Scene::clone(model.scene());
    let half = DVec3::splat(3.0);
    let points = pellucid_core::points::Points {
        positions: vec![-half, half],
        colors: vec![glam::Vec3::ONE; 2],
        opacities: vec![1.0; 2],
        radii: vec![0.1; 2],
        ..Default::default()
    };
    let course = Course::new(&scene, &points, UpAxis::Z).unwrap();
    let text = model.route.path(SIZE).to_json();
    let path = CameraPath::from_json(&text, Path::new("p.json")).unwrap();
    let curve = pellucid_core::camera::path::Curve::new(&path, &course.defaults()).unwrap();
    let frames = curve.frames(5);
    for (frame, camera) in [(0, &cameras[0]), (2, &cameras[1]), (4, &cameras[2])] {
        let shown = pellucid_scene::camera_at(camera, &points.bounds().unwrap(), f64::from(0.1f32)).unwrap();
        assert_eq!(course.camera(&frames[frame]).unwrap().camera(), shown, "frame {frame}");
    }
    // From anywhere a key leads back there, with the depths of the scene.
    for (at, camera) in cameras.iter().enumerate() {
        model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
        model.go_to_key(at);
        assert_eq!((pose(&mut model), camera.near), (Pose::At(*camera), Some(0.5)));
        assert_eq!(model.route.selected(), Some(at));
    }
    // Turning the camera then starts from the key.
    model.navigate(|navigator| navigator.orbit(DVec2::new(48.0, 0.0), 48.0));
    let (Pose::At(turned), last) = (model.pose(), &cameras[2]) else { panic!("moved") };
    let arm = |camera: &CameraSettings| camera.eye.unwrap() - last.target.unwrap();
    assert!((arm(&turned) * DVec3::new(-1.0, -1.0, 1.0) - arm(last)).length() < 1e-9, "half a turn about the target");
}

#[test]
fn the_camera_runs_as_something_that_moves_until_it_is_moved() {
    let (mut model, cameras) = with_keys();
    model.play();
    model.tick(0.5);
    let request = asked(&mut model, Instant::now()).unwrap();
    assert_eq!(request.effort, Effort::Moving(33.0));
    assert!(model.route.is_playing() && matches!(request.pose, Pose::At(camera) if camera.near == Some(0.5)));
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    assert!(!model.route.is_playing());
    model.play();
    model.look_from(View::default());
    assert!(!model.route.is_playing());
    // At its end the path has arrived at the last key.
    shown(&mut model);
    model.play();
    (0..50).for_each(|_| model.tick(0.1));
    let Pose::At(last) = model.pose() else { panic!("on the path") };
    let off = |a: Option<DVec3>, b: Option<DVec3>| (a.unwrap() - b.unwrap()).length();
    assert!(!model.route.is_playing() && off(last.eye, cameras[2].eye) == 0.0, "{:?}", last.eye);
    model.play();
    model.play();
    assert!(!model.route.is_playing(), "a second time stops it");
    model.seek(2.0);
    let Pose::At(middle) = model.pose() else { panic!("on the path") };
    assert_eq!(off(middle.eye, cameras[1].eye), 0.0);
}

#[test]
fn a_turntable_is_round() {
    let (mut model, _) = settled();
    model.pivot_at(DVec2::new(40.0, 24.0));
    model.navigate(|navigator| navigator.orbit(DVec2::new(3.0, 7.0), 48.0));
    let (navigator, before) = (model.navigator().unwrap(), model.pose());
    model.fill_turntable();
    assert_eq!((model.pose(), model.route.keys().len(), model.route.is_closed()), (before, 16, true));
    let arm = |eye: DVec3| eye - navigator.pivot();
    let first = arm(DVec3::from(model.route.keys()[0].eye));
    for step in 0..=160 {
        model.seek(model.route.duration() * f64::from(step) / 160.0);
        let Pose::At(camera) = model.pose() else { panic!("on the path") };
        let off = (arm(camera.eye.unwrap()).length() / first.length() - 1.0).abs();
        assert!(off < 1e-3, "{off} of the radius at step {step}");
        let (from, to) = (first.truncate(), arm(camera.eye.unwrap()).truncate());
        // Ascending from 0 to 360, without the arc cosine, which would lose half of the digits at 180.
        let angle = from.perp_dot(to).atan2(from.dot(to)).to_degrees();
        let expected = 2.25 * f64::from(step);
        let angle = angle + 360.0 * ((expected - angle) / 360.0).round();
        // At keys it is there, and between them no further off than the curve's own pace.
        assert!((angle - expected).abs() < if step % 10 == 0 { 1e-6 } else { 1.0 }, "{angle} and not {expected}");
    }
}

#[test]
fn a_path_is_saved_with_the_scene_that_it_leads_through() {
    let (mut model, _) = with_keys();
    model.set("cloud.0.opacity", Setting::Number(0.25));
    model.save_path();
    let Some(Task::Save(saving)) = model.next_task(Instant::now()) else { panic!("nothing to save") };
    let scene = saving.document.scene().unwrap();
    // The scene keeps its camera, which supplies what keys leave open.
    assert_eq!((scene.camera, scene.image.size, scene.clouds[0].opacity), (model.scene().camera, SIZE, 0.25));
    assert_eq!((saving.path, saving.picture, model.busy), (Some(model.route.path(SIZE)), false, true));
    model.take_in(News::Saved(vec!["s-path-1.toml".into(), "s-path-1.json".into()])).unwrap();
    let (text, _) = model.message.clone().unwrap();
    let command = "pellucid render s-path-1.toml --path s-path-1.json --frames 101 -o s-path-1_%04d.png";
    assert!(text == format!("saved s-path-1.toml and s-path-1.json; {command}"), "{text}");
    model.take_in(News::Saved(vec!["my scan.toml".into(), "my scan.json".into()])).unwrap();
    let (text, _) = model.message.clone().unwrap();
    assert!(text.ends_with("render 'my scan.toml' --path 'my scan.json' --frames 101 -o 'my scan_%04d.png'"), "{text}");
}

#[test]
fn a_scene_is_saved_under_the_name_that_was_chosen() {
    let (mut model, now) = settled();
    let folder = tempfile::tempdir().unwrap();
    let there = folder.path().join("there.toml");
    std::fs::write(&there, "").unwrap();
    let mut chosen = |name: &str| {
        model.message = None;
        model.save_as(folder.path().join(name));
        match model.next_task(now) {
            Some(Task::Save(saving)) => Ok(saving.to.unwrap().file_name().unwrap().to_str().unwrap().to_owned()),
            _ => Err(model.message.clone().unwrap().0),
        }
    };
    assert_eq!(chosen("a.toml").unwrap(), "a.toml");
    assert_eq!(chosen("a").unwrap(), "a.toml");
    assert_eq!(chosen("a.b").unwrap(), "a.b.toml");
    // For a complete name the dialog has already asked whether to replace the file.
    assert_eq!(chosen("there.toml").unwrap(), "there.toml");
    assert!(chosen("there").unwrap_err().contains("exists; "));
}

#[test]
fn files_of_cameras_become_keys() {
    let mut model = model();
    let text = r#"{"version": 1, "size": [640, 480], "loop": true, "keys": [
        {"eye": [0, -9, 0], "target": [0, 0, 0]}, {"eye": [9, 0, 0], "target": [0, 0, 0]}]}"#;
    let path = CameraPath::from_json(text, Path::new("a.json")).unwrap();
    // Before the first picture the position of the camera is unknown.
    model.take_path("a.json".into(), CameraSource::Path(path.clone()));
    assert!(model.route.keys().is_empty());
    shown(&mut model);
    assert_eq!((model.route.path(SIZE), model.message.clone()), (path, Some(("a.json: 2 keys".into(), false))));
    assert!(matches!(pose(&mut model), Pose::At(camera) if camera.eye == Some(DVec3::new(0.0, -9.0, 0.0))));
    // A second file replaces the first; an invalid file changes nothing.
    let key = Key { target: Some([0.0; 3]), up: Some([1.0, 0.0, 0.0]), ..Key::at([5.0, 0.0, 0.0]) };
    model.take_in(News::Cameras("b.json".into(), Box::new(CameraSource::Path(CameraPath::new(vec![key]))))).unwrap();
    let (text, wrong) = model.message.clone().unwrap();
    assert!(wrong && text.starts_with("b.json: keys[0].up: ") && model.route.keys().len() == 2, "{text}");
    // Depths of a key are saved with its picture, and are gone with the next movement.
    let key = Key { target: Some([0.0; 3]), near: Some(1.5), far: Some(40.0), ..Key::at([5.0, 0.0, 0.0]) };
    model.take_path("c.json".into(), CameraSource::Path(CameraPath::new(vec![key])));
    let depths = |model: &Model| {
        let camera = model.document_as_shown().unwrap().scene().unwrap().camera;
        (camera.near, camera.far)
    };
    assert_eq!(depths(&model), (Some(1.5), Some(40.0)));
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    assert_eq!(depths(&model), (Some(0.5), None));
    // Another scene keeps the keys.
    opened(&mut model, "b.ply");
    assert_eq!(model.route.keys().len(), 1);
}

/// Cameras of nerfstudio keep their poses, and a message names what they lose.
#[test]
fn cameras_of_other_programs_become_keys() {
    let (mut model, _) = settled();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("transforms.json");
    // The first looks along y from (0, −9, 0), with z up; the second is turned by 90° about the view.
    let frames = "{\"transform_matrix\": [[1,0,0,0],[0,0,-1,-9],[0,1,0,0],[0,0,0,1]]},
        {\"transform_matrix\": [[0,1,0,0],[0,0,-1,-9],[-1,0,0,0],[0,0,0,1]]}";
    let lens = "\"fl_x\": 48, \"fl_y\": 48, \"w\": 64, \"h\": 96, \"k1\": 0.1";
    std::fs::write(&file, format!("{{{lens}, \"frames\": [{frames}]}}")).unwrap();
    model.take_path("transforms.json".into(), CameraSource::read(&file).unwrap());
    let (text, warned) = model.message.clone().unwrap();
    assert!(warned && text.starts_with("transforms.json: 2 keys; ") && text.contains("distortion"), "{text}");
    assert!(model.route.keys().iter().all(|key| key.orientation.is_some() && key.target.is_none()));
    assert_eq!(model.route.path(SIZE).size, Some([64, 96]));
    for (at, up) in [(0, DVec3::Z), (1, DVec3::X)] {
        model.go_to_key(at);
        let Pose::At(camera) = model.pose() else { panic!("a key is a place") };
        let along = (camera.target.unwrap() - camera.eye.unwrap()).normalize();
        let off = (along - DVec3::Y).length() + (camera.up.unwrap() - up).length();
        assert!(off < 1e-12 && camera.eye == Some(DVec3::new(0.0, -9.0, 0.0)), "{camera:?}");
        assert!((camera.fov_y.unwrap() - 90.0).abs() < 1e-12);
    }
}

#[test]
fn cameras_are_told_from_clouds() {
    let (mut model, now) = settled();
    model.open(vec!["a.ply".into(), "flight.json".into(), "b.las".into()]);
    let (first, second) = (model.next_task(now), model.next_task(now));
    assert!(matches!(first, Some(Task::Open(files)) if files == [Path::new("a.ply"), Path::new("b.las")]));
    assert!(matches!(second, Some(Task::Cameras(file)) if file == Path::new("flight.json")));
    model.busy = false;
    model.open(vec!["a.json".into(), "b.JSON".into()]);
    assert!(model.next_task(now).is_none() && model.message.as_ref().is_some_and(|(_, wrong)| *wrong));
    // Without keys, playing and saving do nothing.
    for ask in [Model::play, Model::save_path] {
        model.message = None;
        ask(&mut model);
        assert!(model.message.as_ref().is_some_and(|(text, wrong)| text.contains("press K") && !wrong));
    }
    assert!(!model.route.is_playing() && model.next_task(now).is_none());
}
