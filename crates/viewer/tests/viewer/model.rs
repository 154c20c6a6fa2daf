//! Tests of the tasks that are requested, of their times, and of the files that are saved.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_scene::{Document, Method, Overrides, Scene, Setting, View, ViewName};
use pellucid_viewer::accuracy::{Accuracy, Exactness, History, Reference};
use pellucid_viewer::draft::Effort;
use pellucid_viewer::messages::{CloudShare, News, Request, Task, WindowPicture};
use pellucid_viewer::model::{Model, Passes, REST, STILL, Viewport};
use pellucid_viewer::navigate::{CameraSubject, Navigator, Pose};

mod edited;
mod keys;
mod opened;
mod path;
mod reopened;
mod undo;

const SIZE: [u32; 2] = [64, 48];

fn model() -> Model {
    let text =
        "[camera]\neye = [0, -10, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\nnear = 0.5\n[[cloud]]\npath = 'a.ply'\n";
    let document = Document::from_toml(text, Path::new("/scans/s.toml"), &Overrides::default()).unwrap();
    let mut model = Model::new("s.toml".into(), document, View::default(), 33.0).unwrap();
    model.set_viewport(Viewport { at: [0, 0], size: SIZE });
    model
}

fn asked(model: &mut Model, now: Instant) -> Option<Request> {
    match model.next_task(now)? {
        Task::Show(request) => Some(*request),
        _ => None,
    }
}

/// A picture for a request: a wall at depth 10.
fn picture(request: &Request, whole: bool) -> News {
    let perspective = Projection::Perspective { fov_y: 45f64.to_radians() };
    let camera = Camera::look_at(-10.0 * DVec3::Y, DVec3::ZERO, DVec3::Z, perspective, 0.5, 100.0).unwrap();
    let half = DVec3::splat(3.0);
    let wall = Duration::from_millis(5);
    News::Picture(Box::new(WindowPicture {
        serial: request.serial,
        pose: request.pose,
        camera,
        subject: CameraSubject {
            bounds: Bounds { min: -half, max: half },
            radius: 0.1,
            up: UpAxis::Z,
            vertical: UpAxis::Z.into(),
        },
        size: SIZE,
        pixels: None,
        depths: vec![10.0; 64 * 48],
        whole,
        lacks_samples: false,
        draft: String::new(),
        accuracy: History::default().accuracy(None),
        method: "sorted",
        profile: FrameProfile {
            passes: Vec::new(),
            begin: Instant::now(),
            timeline: Vec::new(),
            submitted: wall,
            total: None,
            wall,
            waits: 1,
        },
        facts: Facts::default(),
        plan: Vec::new(),
        field: None,
        held: None,
        legend: None,
    }))
}

/// A model that shows its first picture, and a moment later.
fn settled() -> (Model, Instant) {
    let (mut model, now) = (model(), Instant::now());
    shown(&mut model);
    (model, now + REST)
}

/// A model whose camera has just moved, and the time.
fn moved() -> (Model, Instant) {
    let (mut model, _) = settled();
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    (model, Instant::now())
}

/// Asks for the picture that is due, and shows the whole of it.
fn shown(model: &mut Model) {
    let request = asked(model, Instant::now()).expect("a picture is due");
    model.take_in(picture(&request, true)).unwrap();
}

/// Opens the scene of a cloud of this name.
fn opened(model: &mut Model, name: &str) {
    let document = Document::from_clouds([name], &Overrides::default()).unwrap();
    model.take_in(News::Opened(name.into(), Box::new(document))).unwrap();
}

#[test]
fn only_the_latest_request_counts() {
    let (mut model, now) = settled();
    assert!(model.is_at_rest(now) && asked(&mut model, now).is_none());
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    let now = Instant::now();
    let first = asked(&mut model, now).unwrap();
    assert_eq!((first.serial, first.effort, first.scene.image.size), (2, Effort::Moving(33.0), SIZE));
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    // A change in the meantime is requested at once; the picture that arrives is outdated.
    let second = asked(&mut model, now).unwrap();
    assert_ne!(first.pose, second.pose);
    assert!(asked(&mut model, now).is_none());
    let now = Instant::now();
    model.take_in(picture(&first, true)).unwrap();
    assert!(!model.is_at_rest(now + REST));
    model.take_in(picture(&second, true)).unwrap();
    assert!(model.is_at_rest(now + REST) && !model.is_at_rest(now));
}

#[test]
fn at_rest_nothing_is_left_out() {
    let (mut model, now) = moved();
    let draft = asked(&mut model, now).unwrap();
    model.take_in(picture(&draft, false)).unwrap();
    assert!(asked(&mut model, now).is_none(), "still moving");
    assert!(model.due_at(now).is_some());
    // Each may take four times as long as the one before it, until one is the whole picture.
    for budget in [250.0, 1000.0, 4000.0] {
        let finer = asked(&mut model, now + REST).unwrap();
        assert_eq!((finer.effort, finer.pose), (Effort::Refining(budget), draft.pose));
        assert!(!model.is_at_rest(now + REST));
        model.take_in(picture(&finer, budget == 4000.0)).unwrap();
    }
    assert!(model.is_at_rest(now + REST) && model.due_at(now + REST).is_none());
    assert!(asked(&mut model, now + REST).is_none());
}

#[test]
fn samples_come_at_rest_once_nothing_else_is_missing() {
    let (mut model, now) = settled();
    model.set("image.samples", Setting::Integer(4));
    let later = now + Duration::from_secs(10);
    let Some(Task::Show(draft)) = model.next_task(later) else { panic!("a picture is due") };
    assert!(matches!(draft.effort, Effort::Moving(_)));
    let News::Picture(one) = picture(&draft, false) else { unreachable!() };
    model.take_in(News::Picture(Box::new(WindowPicture { lacks_samples: true, ..*one }))).unwrap();
    let Some(Task::Show(whole)) = model.next_task(later + Duration::from_secs(10)) else {
        panic!("a finer one is due")
    };
    assert_eq!(whole.effort, Effort::Whole);
    model.take_in(picture(&whole, true)).unwrap();
    assert!(model.next_task(later + Duration::from_secs(20)).is_none());
}

#[test]
fn every_point_of_a_store_is_drawn_only_if_that_is_asked_for() {
    let (mut model, _) = settled();
    let held = |news: News, is_fine: bool| match news {
        News::Picture(picture) => {
            let held = CloudShare {
                points: if picture.whole { 1_000_000_000 } else { 2_340_000 },
                all: 1_000_000_000,
                is_fine,
            };
            News::Picture(Box::new(WindowPicture { held: Some(held), ..*picture }))
        }
        _ => unreachable!(),
    };
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    let now = Instant::now();
    let draft = asked(&mut model, now).unwrap();
    model.take_in(held(picture(&draft, false), false)).unwrap();
    assert_eq!(model.held_line().as_deref(), Some("2.3M of 1000M points"));
    let finer = asked(&mut model, now + REST).unwrap();
    model.take_in(held(picture(&finer, false), true)).unwrap();
    assert_eq!(model.held_line().as_deref(), Some("2.3M of 1000M points; the others are less than a pixel from these"));
    assert!(model.is_at_rest(now + REST) && asked(&mut model, now + REST).is_none());
    model.draw_everything(true);
    let whole = asked(&mut model, now + REST).unwrap();
    assert_eq!(whole.effort, Effort::Whole);
    model.take_in(held(picture(&whole, true), true)).unwrap();
    assert!(model.is_at_rest(now + REST) && model.held_line().is_none());
}

#[test]
fn whatever_a_draft_costs_the_whole_picture_comes() {
    let (mut model, now) = moved();
    let mut efforts = Vec::new();
    for _ in 0..20 {
        let Some(request) = asked(&mut model, now + efforts.len().min(1) as u32 * REST) else { break };
        efforts.push(request.effort);
        model.take_in(picture(&request, request.effort == Effort::Whole)).unwrap();
    }
    assert_eq!((efforts.len(), efforts.last()), (8, Some(&Effort::Whole)));
    assert!(model.is_at_rest(now + REST));
}

#[test]
fn a_stopped_picture_is_requested_again() {
    let (mut model, now) = moved();
    let first = asked(&mut model, now).unwrap();
    model.take_in(News::Stopped(first.serial)).unwrap();
    let second = asked(&mut model, now + REST).unwrap();
    assert_eq!((second.pose, second.effort), (first.pose, Effort::Moving(33.0)));
    // News nobody waits for changes nothing.
    model.take_in(News::Stopped(first.serial)).unwrap();
    assert!(asked(&mut model, now + REST).is_none());
}

#[test]
fn approximations_at_rest_are_held_against_the_exact_picture_once() {
    let approximation = Exactness::Approximation(Method::ABuffer(Default::default()));
    let (mut model, now) = moved();
    let request = asked(&mut model, now).unwrap();
    let News::Picture(mut shown) = picture(&request, true) else { unreachable!() };
    shown.accuracy.exactness = Some(approximation);
    model.take_in(News::Picture(shown)).unwrap();
    assert!(model.next_task(now + REST).is_none());
    let due = model.due_at(now + REST).unwrap();
    assert!(model.is_at_rest(now + REST), "a measurement changes nothing in the picture");
    let Some(Task::Measure(serial)) = model.next_task(due) else { panic!("no measurement") };
    assert_eq!(serial, request.serial);
    assert!(model.next_task(due).is_none());
    let measured = Accuracy { refinements: Vec::new(), against: Some(Reference::Exact("abuffer")), exactness: None };
    model.take_in(News::Measured(serial, measured.clone())).unwrap();
    assert_eq!(model.picture().unwrap().accuracy, measured);
    // A stopped picture is requested again.
    let (mut model, now) = settled();
    let unmeasured = Accuracy { refinements: Vec::new(), against: None, exactness: Some(approximation) };
    model.take_in(News::Measured(model.picture().unwrap().serial, unmeasured)).unwrap();
    let Some(Task::Measure(serial)) = model.next_task(now + STILL) else { panic!("no measurement") };
    model.take_in(News::Stopped(serial)).unwrap();
    assert!(matches!(model.next_task(now + STILL), Some(Task::Measure(_))));
}

#[test]
fn a_failure_is_reported_and_not_tried_again() {
    let (mut model, _) = settled();
    model.set("cloud.0.opacity", Setting::Number(2.0));
    let (text, wrong) = model.message.clone().unwrap();
    assert!(wrong && text.contains("cloud.0.opacity"), "{text}");
    assert_eq!(model.scene().clouds[0].opacity, 1.0);
    let now = Instant::now();
    assert!(asked(&mut model, now).is_none(), "nothing changed");
    model.set("method.name", Setting::Word("peel".into()));
    assert_eq!(model.message, None);
    let request = asked(&mut model, Instant::now()).unwrap();
    model.take_in(News::Failed(request.serial, "too many layers".into())).unwrap();
    assert_eq!(model.message, Some(("too many layers".into(), true)));
    assert!(asked(&mut model, now + REST).is_none());
}

#[test]
fn the_camera_is_saved_when_it_has_moved() {
    let (mut model, _) = settled();
    let saved = |model: &mut Model| {
        model.save(false);
        let Some(Task::Save(saving)) = model.next_task(Instant::now()) else { panic!("nothing to save") };
        assert_eq!((saving.stem.as_str(), saving.picture, model.busy), ("s", false, true));
        let text = saving.document.to_toml(Path::new("/scans")).unwrap();
        Document::from_toml(&text, Path::new("/scans/t.toml"), &Overrides::default()).unwrap().scene().unwrap()
    };
    let before = model.scene().camera;
    let scene = saved(&mut model);
    assert_eq!((scene.camera, scene.image.size), (before, SIZE));
    model.navigate(|navigator| navigator.orbit(DVec2::new(5.0, 3.0), 48.0));
    let Pose::At(shown) = model.pose() else { panic!("moved") };
    assert_eq!(saved(&mut model).camera, shown, "to the last bit");
    model.navigate(Navigator::toggle_projection);
    let Pose::At(shown) = model.pose() else { panic!("moved") };
    assert_eq!(saved(&mut model).camera, shown);
    assert!(shown.height.is_some() && shown.fov_y.is_none() && shown.near == Some(0.5));
}

#[test]
fn the_pointer_finds_what_is_there() {
    let (mut model, _) = settled();
    // The middle of the wall, 10 before the eye.
    assert!(model.point_at(DVec2::new(32.0, 24.0)).unwrap().length() < 1e-9);
    model.pivot_at(DVec2::new(40.0, 24.0));
    let pivot = model.navigator().unwrap().pivot();
    // 8 pixels of 2·10·tan(22.5°)/48 units.
    assert!((pivot - DVec3::X * (160.0 / 48.0) * 22.5f64.to_radians().tan()).length() < 1e-9, "{pivot}");
    let request = asked(&mut model, Instant::now()).unwrap();
    let Pose::At(camera) = request.pose else { panic!("a pivot is a place") };
    assert!((camera.eye.unwrap() - DVec3::Y * -10.0).length() < 1e-9, "the picture stays");
}

#[test]
fn another_side_keeps_the_projection() {
    let (mut model, _) = settled();
    model.navigate(Navigator::toggle_projection);
    assert!(model.is_orthographic());
    let view = View { name: Some(ViewName::Top), ..View::default() };
    model.look_from(view);
    let request = asked(&mut model, Instant::now()).unwrap();
    assert_eq!(request.pose, Pose::View(view));
    // On its way there nothing moves, and nothing is saved that would be somewhere else.
    model.navigate(|navigator| navigator.orbit(DVec2::new(5.0, 3.0), 48.0));
    model.save(true);
    assert!(model.is_orthographic() && model.next_task(Instant::now()).is_none());
    model.take_in(picture(&request, true)).unwrap();
    assert!(model.is_orthographic());
    let request = asked(&mut model, Instant::now()).unwrap();
    assert!(matches!(request.pose, Pose::At(camera) if camera.height.is_some()));
}

#[test]
fn other_files_take_the_place_of_the_scene() {
    let (mut model, now) = settled();
    model.open(vec!["b.ply".into()]);
    assert!(matches!(model.next_task(now), Some(Task::Open(files)) if files == [Path::new("b.ply")]));
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    assert!(asked(&mut model, now).is_none(), "not while files are read");
    opened(&mut model, "b.ply");
    let request = asked(&mut model, Instant::now()).unwrap();
    assert_eq!((model.name.as_str(), request.pose, request.serial), ("b.ply", Pose::Scene, 2));
    model.open(vec!["c.ply".into()]);
    model.next_task(now);
    model.take_in(News::Failed(0, "c.ply: there is no such file".into())).unwrap();
    assert!(!model.busy && model.message.as_ref().is_some_and(|(_, wrong)| *wrong));
}

#[test]
fn the_progress_line_shows_the_stage_that_a_picture_waits_for() {
    let (mut model, now) = settled();
    model.progress.set_message("finding neighbors");
    assert_eq!(model.progress_line(), None, "nothing is asked for");
    model.set("cloud.0.opacity", Setting::Number(0.5));
    let request = asked(&mut model, now).expect("a picture is due");
    assert_eq!(model.progress_line().as_deref(), Some("finding neighbors"));
    model.progress.set_length(200);
    model.progress.set_position(50);
    assert_eq!(model.progress_line().as_deref(), Some("finding neighbors, 25 %"));
    model.progress.set_message("");
    assert_eq!(model.progress_line(), None, "points are there");
    model.take_in(picture(&request, true)).unwrap();
    assert!(!model.is_waiting());
}
