//! Keys, their order and times, and where the camera is between them.

use glam::DVec3;

use super::*;
use pellucid_core::camera::Projection;

fn defaults() -> Defaults {
    Defaults { up: DVec3::Z, projection: Projection::Perspective { fov_y: 0.8 } }
}

/// A key that looks at the origin from `x` along the x axis.
fn key(x: f64) -> Key {
    Key { target: Some([0.0; 3]), up: Some([0.0, 0.0, 1.0]), fov_y: Some(40.0), ..Key::at([x, -5.0, 2.0]) }
}

fn eyes(route: &Route) -> Vec<f64> {
    route.keys().iter().map(|key| key.eye[0]).collect()
}

fn times(route: &Route) -> Vec<f64> {
    route.keys().iter().filter_map(|key| key.time).collect()
}

/// Four keys at 0, 1, 2 and 3; the last is selected.
fn four() -> Route {
    let mut route = Route::default();
    (0..4).for_each(|x| route.add(key(f64::from(x)), &defaults()).unwrap());
    route
}

#[test]
fn keys_come_behind_the_selected_one_and_go_where_they_are_moved() {
    let mut route = four();
    assert_eq!((eyes(&route), route.selected()), (vec![0.0, 1.0, 2.0, 3.0], Some(3)));
    route.select(1, &defaults()).unwrap();
    route.add(key(9.0), &defaults()).unwrap();
    assert_eq!((eyes(&route), route.selected()), (vec![0.0, 1.0, 9.0, 2.0, 3.0], Some(2)));
    route.shift(true, &defaults()).unwrap();
    assert_eq!((eyes(&route), route.selected()), (vec![0.0, 9.0, 1.0, 2.0, 3.0], Some(1)));
    route.shift(true, &defaults()).unwrap();
    // The first key can't move forward.
    route.shift(true, &defaults()).unwrap();
    assert_eq!((eyes(&route), route.selected()), (vec![9.0, 0.0, 1.0, 2.0, 3.0], Some(0)));
    route.shift(false, &defaults()).unwrap();
    route.delete(&defaults()).unwrap();
    assert_eq!((eyes(&route), route.selected()), (vec![0.0, 1.0, 2.0, 3.0], Some(1)));
    route.replace(key(7.0), &defaults()).unwrap();
    assert_eq!((eyes(&route), route.selected()), (vec![0.0, 7.0, 2.0, 3.0], Some(1)));
    for left in (0..4usize).rev() {
        route.delete(&defaults()).unwrap();
        assert_eq!((route.keys().len(), route.selected()), (left, left.checked_sub(1).map(|last| last.min(1))));
    }
    route.delete(&defaults()).unwrap();
    route.shift(false, &defaults()).unwrap();
    assert!(route.select(0, &defaults()).unwrap().is_none() && route.seek(1.0, &defaults()).unwrap().is_none());
    assert_eq!((route.duration(), route.position()), (0.0, 0.0));
}

#[test]
fn keys_that_make_no_path_change_nothing() {
    let mut route = four();
    let before = route.path([64, 48]);
    let flat = Key { fov_y: None, height: Some(3.0), ..key(5.0) };
    let problem = route.add(flat.clone(), &defaults()).unwrap_err().to_string();
    assert!(problem.contains("keys[4]") && problem.contains("orthographic"), "{problem}");
    route.replace(flat, &defaults()).unwrap_err();
    route.add(Key { up: Some([5.0, -5.0, 2.0]), ..key(5.0) }, &defaults()).unwrap_err();
    route.add(key(f64::NAN), &defaults()).unwrap_err();
    route.set_timed(true, &defaults()).unwrap();
    for wrong in [0.0, -1.0, 4.0, 9.0, f64::NAN] {
        route.set_time(1, wrong, &defaults()).unwrap_err();
    }
    route.set_timed(false, &defaults()).unwrap();
    assert_eq!((route.path([64, 48]), route.selected()), (before, Some(3)));
}

#[test]
fn times_belong_to_places_and_not_to_keys() {
    let mut route = four();
    assert!(!route.is_timed() && times(&route).is_empty());
    route.set_pace(1.5);
    route.set_timed(true, &defaults()).unwrap();
    assert_eq!(times(&route), [0.0, 1.5, 3.0, 4.5]);
    route.set_time(3, 6.0, &defaults()).unwrap();
    route.shift(true, &defaults()).unwrap();
    assert_eq!((eyes(&route), times(&route)), (vec![0.0, 1.0, 3.0, 2.0], vec![0.0, 1.5, 3.0, 6.0]));
    // Behind the last as far as they are apart on average, between two in the middle.
    route.select(3, &defaults()).unwrap();
    route.add(key(4.0), &defaults()).unwrap();
    assert_eq!(times(&route), [0.0, 1.5, 3.0, 6.0, 8.0]);
    route.select(2, &defaults()).unwrap();
    route.add(key(5.0), &defaults()).unwrap();
    assert_eq!(times(&route), [0.0, 1.5, 3.0, 4.5, 6.0, 8.0]);
    route.replace(key(6.0), &defaults()).unwrap();
    assert_eq!((times(&route)[3], route.duration()), (4.5, 8.0));
    route.set_closed(true, &defaults()).unwrap();
    assert!((route.duration() - 9.6).abs() < 1e-12, "back takes a mean piece: {}", route.duration());
    assert_eq!(route.frames(), 240);
}

#[test]
fn the_camera_runs_from_key_to_key_and_ends_there() {
    let mut route = four();
    assert_eq!((route.duration(), route.frames()), (6.0, 151));
    assert!(route.advance(1.0, &defaults()).unwrap().is_none(), "it does not run yet");
    // From the end a path restarts.
    route.seek(6.0, &defaults()).unwrap();
    route.play();
    assert!(route.is_playing());
    let curve = Curve::new(&route.path([64, 48]), &defaults()).unwrap();
    for step in 1..=23 {
        let pose = route.advance(0.25, &defaults()).unwrap().unwrap();
        assert_eq!(pose, curve.at(0.125 * f64::from(step)), "{step}");
        assert!((route.position() - 0.25 * f64::from(step)).abs() < 1e-12);
    }
    let last = route.advance(0.5, &defaults()).unwrap().unwrap();
    assert!(last == curve.at(3.0) && last.eye.x == 3.0 && !route.is_playing() && route.position() == 6.0);
    assert!(route.advance(0.5, &defaults()).unwrap().is_none());
    // The slider and the keys meet.
    assert_eq!(route.select(2, &defaults()).unwrap(), route.seek(4.0, &defaults()).unwrap());
    assert_eq!((route.position(), route.selected()), (4.0, Some(2)));
    for nonsense in [-1.0, f64::NAN] {
        assert_eq!(route.seek(nonsense, &defaults()).unwrap(), Some(curve.at(0.0)));
    }
    // Another pace leaves the camera where it is.
    route.seek(4.0, &defaults()).unwrap();
    route.set_pace(1.0);
    assert_eq!((route.position(), route.duration()), (2.0, 3.0));
}

#[test]
fn a_loop_goes_on_and_changes_stop_it() {
    let mut route = four();
    route.set_closed(true, &defaults()).unwrap();
    assert_eq!((route.duration(), route.frames()), (8.0, 200));
    route.play();
    let curve = Curve::new(&route.path([64, 48]), &defaults()).unwrap();
    route.advance(7.5, &defaults()).unwrap();
    let pose = route.advance(1.5, &defaults()).unwrap().unwrap();
    assert!(route.is_playing() && route.position() == 1.0 && pose == curve.at(0.5));
    route.delete(&defaults()).unwrap();
    assert!(!route.is_playing());
    route.play();
    route.stop();
    assert!(!route.is_playing());
    let mut one = Route::default();
    one.add(key(1.0), &defaults()).unwrap();
    one.set_closed(true, &defaults()).unwrap();
    one.play();
    assert!(!one.is_playing() && one.frames() == 2, "a single key leads nowhere");
}

#[test]
fn a_saved_path_loads_unchanged() {
    let mut route = four();
    route.set_closed(true, &defaults()).unwrap();
    route.set_timed(true, &defaults()).unwrap();
    route.set_time(2, 4.1, &defaults()).unwrap();
    let path = route.path([64, 48]);
    assert_eq!((path.size, path.closed), (Some([64, 48]), true));
    let read = CameraPath::from_json(&path.to_json(), "a.json".as_ref()).unwrap();
    assert_eq!(read, path);
    let mut again = Route::default();
    again.load(read, &defaults()).unwrap();
    // The pictures' size is that of the file from now on.
    assert_eq!((again.path([1, 1]), again.selected()), (path.clone(), Some(0)));
    assert_eq!(again.duration(), route.duration());
    let broken = CameraPath { keys: vec![Key::at([0.0; 3])], ..path.clone() };
    again.load(broken, &defaults()).unwrap_err();
    assert_eq!(again.path([1, 1]), path, "what is wrong changes nothing");
    again.clear();
    assert!(again.keys().is_empty() && again.path([1, 1]).size == Some([1, 1]));
}

/// Keys without `up` follow the scene, which may change.
#[test]
fn another_scene_has_other_defaults() {
    let mut route = Route::default();
    route.add(Key { up: None, ..key(1.0) }, &defaults()).unwrap();
    let before = route.select(0, &defaults()).unwrap().unwrap();
    route.invalidate();
    let other = Defaults { up: DVec3::Y, ..defaults() };
    let after = route.select(0, &other).unwrap().unwrap();
    assert!(before.up != after.up && before.forward == after.forward);
    route.invalidate();
    let along = Defaults { up: DVec3::new(1.0, -5.0, 2.0), ..defaults() };
    assert!(route.select(0, &along).is_err(), "up along the view is said, not shown");
}
