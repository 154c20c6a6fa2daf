//! Properties of the motion through key frames.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use pellucid_core::camera::Projection;
use pellucid_core::camera::path::{CameraPath, Curve, Key, Pose};

use super::{curve, defaults, looking};

/// A key on an orbit around `target`, in degrees.
fn orbiting(target: [f64; 3], distance: f64, azimuth: f64, elevation: f64) -> Key {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    let way = DVec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin()) * distance;
    looking((DVec3::from(target) + way).to_array(), target)
}

/// A flight with all that there is: an orbit, a look around, a rest, a zoom, uneven times.
fn mixed() -> CameraPath {
    let at = [1.0, 2.0, 0.5];
    let mut keys = vec![
        orbiting(at, 5.0, 0.0, 10.0),
        orbiting(at, 5.0, 80.0, 40.0),
        orbiting(at, 9.0, 120.0, 35.0),
        looking([4.0, 4.0, 1.0], [1.0, 2.0, 0.5]),
        looking([4.0, 4.0, 1.0], [9.0, 4.0, 2.0]),
        looking([4.0, 4.0, 1.0], [9.0, 4.0, 2.0]),
        looking([7.0, -4.0, 2.0], [9.0, 4.0, 2.0]),
        looking([-7.0, -4.0, 2.0], [0.0, 0.0, 2.0]),
    ];
    for (i, key) in keys.iter_mut().enumerate() {
        key.time = Some([0.0, 1.0, 1.5, 4.0, 5.0, 6.5, 7.0, 9.0][i]);
        key.fov_y = Some([50.0, 50.0, 30.0, 60.0, 60.0, 60.0, 20.0, 50.0][i]);
    }
    CameraPath::new(keys)
}

/// Makes the same path with orientations instead of targets.
fn oriented(path: &CameraPath) -> CameraPath {
    let poses = curve(path).key_poses();
    let keys = path.keys.iter().zip(&poses).map(|(key, pose)| {
        let q = DQuat::from_mat3(&glam::DMat3::from_cols(pose.right, pose.up, -pose.forward));
        Key { target: None, orientation: Some([q.w, q.x, q.y, q.z]), ..key.clone() }
    });
    CameraPath { keys: keys.collect(), ..path.clone() }
}

fn fov(pose: &Pose) -> f64 {
    match pose.projection {
        Projection::Perspective { fov_y } => fov_y.to_degrees(),
        Projection::Orthographic { .. } => panic!("perspective"),
    }
}

/// The largest difference of two poses' numbers.
fn off(a: &Pose, b: &Pose) -> f64 {
    let vectors = [a.eye - b.eye, a.right - b.right, a.up - b.up, a.forward - b.forward];
    let most = vectors.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    most.max((fov(a) - fov(b)).abs())
}

fn assert_orthonormal(pose: &Pose) {
    let Pose { right, up, forward, .. } = *pose;
    assert!((right.cross(forward) - up).length() < 1e-12, "{pose:?}");
    assert!((forward.length() - 1.0).abs() < 1e-12 && right.dot(forward).abs() < 1e-12, "{pose:?}");
}

#[test]
fn every_key_is_met_at_its_time() {
    for path in [mixed(), oriented(&mixed()), CameraPath { closed: true, ..mixed() }] {
        let curve = curve(&path);
        for key in &path.keys {
            let time = key.time.unwrap();
            let pose = curve.at(time);
            assert_eq!(pose.eye.to_array(), key.eye);
            assert!((fov(&pose) - key.fov_y.unwrap()).abs() < 1e-12);
            if let Some(target) = key.target {
                let way = DVec3::from(target) - pose.eye;
                assert!((way.normalize() - pose.forward).length() < 1e-12);
            }
            // And the curve leads there: over 1e-7 nothing here moves by more than 1e-5.
            for near in [time - 1e-7, time + 1e-7] {
                assert!(off(&curve.at(near), &pose) < 1e-5, "{near}: {:?} and {pose:?}", curve.at(near));
            }
        }
    }
}

#[test]
fn velocities_have_no_steps() {
    // Of a curve with third derivatives of up to about 1e4 the differences over h are off by 1e4·h² + 1e-16·10/h.
    let h = 1e-5;
    for path in [mixed(), oriented(&mixed()), CameraPath { closed: true, ..mixed() }] {
        let curve = curve(&path);
        let rate = |from: f64, to: f64| {
            let (a, b) = (curve.at(from), curve.at(to));
            [(b.eye - a.eye) / h, (b.forward - a.forward) / h, DVec3::splat(fov(&b) - fov(&a)) / h]
        };
        let [start, end] = curve.time_range();
        let inner: Vec<f64> = path.keys.iter().filter_map(|key| key.time).filter(|t| *t > start && *t < end).collect();
        assert!(inner.len() >= 6);
        for time in inner {
            let (before, after) = (rate(time - h, time), rate(time, time + h));
            for (a, b) in before.iter().zip(after) {
                assert!((*a - b).length() < 0.02, "{time}: {a} and then {b}");
            }
        }
        if path.closed {
            let (before, after) = (rate(end - h, end), rate(start, start + h));
            assert!((before[0] - after[0]).length() < 0.02, "around: {} and then {}", before[0], after[0]);
        }
    }
    // The straight lines of a polygon have such steps: what is asserted above can fail.
    let corner = |t: f64| if t < 0.0 { DVec3::X * t } else { DVec3::Y * t };
    let [before, after] = [(corner(0.0) - corner(-h)) / h, (corner(h) - corner(0.0)) / h];
    assert!((before - after).length() > 0.02);
}

#[test]
fn keys_that_are_equal_are_one_camera() {
    for key in [looking([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]), Key { orientation: Some([0.5; 4]), ..Key::at([1.0; 3]) }] {
        for closed in [false, true] {
            let path = CameraPath { closed, ..CameraPath::new(vec![key.clone(); 4]) };
            let poses = curve(&path).frames(31);
            assert!(poses.iter().all(|pose| *pose == poses[0]));
            assert_orthonormal(&poses[0]);
        }
    }
}

#[test]
fn coincident_keys_are_a_rest_without_nan() {
    let path = mixed();
    let curve = curve(&path);
    let rest = curve.at(5.0);
    for i in 0..=900 {
        let pose = curve.at(f64::from(i) * 0.01);
        assert_orthonormal(&pose);
        assert!(pose.eye.is_finite() && fov(&pose).is_finite());
        if (500..=650).contains(&i) {
            assert!(off(&pose, &rest) < 1e-12, "{i}");
        }
    }
    let next_to = |x: f64| looking([x, 4.0, 1.0], [0.0; 3]);
    // As near as float64 can tell apart.
    let close = CameraPath::new(vec![next_to(1.0), next_to(1.0 + f64::EPSILON), next_to(2.0), next_to(2.0)]);
    for pose in super::curve(&close).frames(100) {
        assert_orthonormal(&pose);
        assert!((0.9..2.1).contains(&pose.eye.x), "{}", pose.eye);
    }
}

#[test]
fn two_keys_make_a_straight_line_or_the_shortest_turn() {
    let shift = DVec3::new(3.0, -2.0, 1.0);
    let (eye, target) = (DVec3::new(5.0, 1.0, 2.0), DVec3::new(0.0, 1.0, 1.0));
    let path = CameraPath::new(vec![
        looking(eye.to_array(), target.to_array()),
        looking((eye + shift).to_array(), (target + shift).to_array()),
    ]);
    let poses = curve(&path).frames(11);
    for (i, pose) in poses.iter().enumerate() {
        assert!((pose.eye - (eye + shift * (i as f64 / 10.0))).length() < 1e-12);
        assert!((pose.forward - poses[0].forward).length() < 1e-12);
    }
    let (q, r) = (DQuat::from_xyzw(0.1, 0.7, -0.3, 0.5).normalize(), DQuat::from_xyzw(0.4, -0.2, 0.6, 0.3).normalize());
    let key = |q: DQuat, eye| Key { orientation: Some([q.w, q.x, q.y, q.z]), ..Key::at(eye) };
    let path = CameraPath::new(vec![key(q, [0.0; 3]), key(r, [1.0, 2.0, 3.0])]);
    for (i, pose) in curve(&path).frames(11).iter().enumerate() {
        let s = i as f64 / 10.0;
        let expected = q.slerp(r, s);
        assert!((expected * DVec3::NEG_Z - pose.forward).length() < 1e-12);
        assert!((expected * DVec3::X - pose.right).length() < 1e-12);
        assert!((pose.eye - DVec3::new(1.0, 2.0, 3.0) * s).length() < 1e-12);
    }
}

#[test]
fn the_sign_of_a_quaternion_does_not_count() {
    let path = oriented(&mixed());
    let mut turned = path.clone();
    for key in turned.keys.iter_mut().skip(1).step_by(2) {
        key.orientation = key.orientation.map(|q| q.map(|x| -3.0 * x));
    }
    let (a, b) = (curve(&path), curve(&turned));
    for i in 0..=90 {
        let time = f64::from(i) * 0.1;
        assert!(off(&a.at(time), &b.at(time)) < 1e-12);
    }
}

#[test]
fn orbits_are_round_level_and_even() {
    let target = [1.0, 2.0, 0.5];
    let keys: Vec<Key> = (0..4).map(|i| orbiting(target, 5.0, 90.0 * f64::from(i), 30.0)).collect();
    let path = CameraPath { closed: true, ..CameraPath::new(keys) };
    let poses = curve(&path).frames(36);
    for (i, pose) in poses.iter().enumerate() {
        let arm = pose.eye - DVec3::from(target);
        assert!((arm.length() - 5.0).abs() < 1e-12 && (arm.z - 2.5).abs() < 1e-12, "{arm}");
        assert!(pose.right.z.abs() < 1e-12 && (pose.forward + arm / 5.0).length() < 1e-12);
        let azimuth = arm.y.atan2(arm.x).rem_euclid(TAU);
        assert!((azimuth - TAU * i as f64 / 36.0).abs() < 1e-12, "frame {i}: {azimuth}");
    }
    // Orientations turn as evenly; their eyes know no target, so only the keys are as far from it.
    let free = curve(&oriented(&path)).frames(36);
    for (a, b) in poses.iter().zip(&free) {
        assert!((a.forward - b.forward).length() < 1e-12 && (a.right - b.right).length() < 1e-12);
    }
    let round = |pose: &Pose| ((pose.eye - DVec3::from(target)).length() - 5.0).abs() < 1e-12;
    assert!(free.iter().step_by(9).all(round) && !free.iter().all(round));
}

#[test]
fn a_target_that_rests_stays_in_the_middle_and_an_eye_that_rests_stays() {
    let at = [1.0, 2.0, 0.5];
    let angles = [(0.0, 10.0), (40.0, 60.0), (130.0, -20.0), (200.0, 0.0)];
    let distances = [5.0, 2.0, 9.0, 4.0];
    let key = |((azimuth, elevation), distance): (&(f64, f64), &f64)| orbiting(at, *distance, *azimuth, *elevation);
    let around = CameraPath::new(angles.iter().zip(&distances).map(key).collect());
    for pose in curve(&around).frames(100) {
        let way = DVec3::from(at) - pose.eye;
        assert!((way.normalize() - pose.forward).length() < 1e-9);
        assert!(way.length() > 2.0 - 1e-9 && way.length() < 9.0 + 1e-9 && pose.right.z.abs() < 1e-12);
    }
    let look = |key: &Key| looking(at, key.eye);
    let panned = CameraPath::new(around.keys.iter().map(look).collect());
    for pose in curve(&panned).frames(100) {
        assert!((pose.eye - DVec3::from(at)).length() < 1e-12, "{}", pose.eye);
    }
    assert!(curve(&panned).frames(4)[1].forward.distance(curve(&panned).frames(4)[2].forward) > 0.1);
}

#[test]
fn zooms_are_even_and_depths_stay_between_those_of_the_keys() {
    let key = |fov_y, near, far| Key {
        fov_y: Some(fov_y),
        near: Some(near),
        far: Some(far),
        ..looking([5.0, 0.0, 0.0], [0.0; 3])
    };
    let path = CameraPath::new(vec![key(90.0, 0.1, 10.0), key(20.0, 1.0, 30.0)]);
    let poses = curve(&path).frames(9);
    // The cotangent of half the angle, so the size of what is seen, grows by the same factor from frame to frame.
    let sizes: Vec<f64> = poses.iter().map(|pose| 1.0 / (0.5 * fov(pose)).to_radians().tan()).collect();
    let factor = sizes[1] / sizes[0];
    assert!(sizes.windows(2).all(|pair| (pair[1] / pair[0] - factor).abs() < 1e-12) && factor > 1.1);
    for pose in &poses {
        let (near, far) = (pose.near.unwrap(), pose.far.unwrap());
        assert!((0.1..=1.0).contains(&near) && (10.0..=30.0).contains(&far));
    }
    let flat = |height| Key { height: Some(height), ..looking([5.0, 0.0, 0.0], [0.0; 3]) };
    let [middle] = [curve(&CameraPath::new(vec![flat(1.0), flat(4.0)])).frames(3)[1]];
    assert!(matches!(middle.projection, Projection::Orthographic { height } if (height - 2.0).abs() < 1e-12));
    let both = CameraPath::new(vec![flat(1.0), looking([5.0, 0.0, 0.0], [0.0; 3])]);
    let problem = Curve::new(&both, &defaults()).unwrap_err().to_string();
    assert!(problem.contains("keys[1]") && problem.contains("orthographic"), "{problem}");
}

#[test]
fn frames_of_open_and_closed_paths() {
    let path = CameraPath::new((0..3).map(|i| looking([f64::from(i), 5.0, 0.0], [0.0; 3])).collect());
    let eyes = |path: &CameraPath, count| curve(path).frames(count).iter().map(|p| p.eye.x).collect::<Vec<_>>();
    assert_eq!(eyes(&path, 1), [0.0]);
    assert_eq!([eyes(&path, 3), eyes(&path, 5).into_iter().step_by(2).collect()], [[0.0, 1.0, 2.0]; 2]);
    let closed = CameraPath { closed: true, ..path.clone() };
    // Back from the last key to the first takes as long as from key to key.
    assert_eq!(eyes(&closed, 6).into_iter().step_by(2).collect::<Vec<_>>(), [0.0, 1.0, 2.0]);
    assert_eq!(curve(&closed).time_range(), [0.0, 3.0]);
    let one = CameraPath { closed: true, ..CameraPath::new(vec![looking([1.0, 5.0, 0.0], [0.0; 3])]) };
    assert_eq!(eyes(&one, 3), [1.0; 3]);
    let up = Key { up: Some([0.0, 0.0, -2.0]), ..looking([0.0, 0.0, 5.0], [0.0; 3]) };
    let problem = Curve::new(&CameraPath::new(vec![up]), &defaults()).unwrap_err().to_string();
    assert!(problem.starts_with("keys[0].up: ") && problem.contains("parallel to the view"), "{problem}");
}

#[test]
fn a_flight_far_from_the_origin_is_the_same_flight() {
    let far = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let moved = |path: &CameraPath| {
        let mut path = path.clone();
        for key in &mut path.keys {
            key.eye = (DVec3::from(key.eye) + far).to_array();
            key.target = key.target.map(|target| (DVec3::from(target) + far).to_array());
        }
        path
    };
    let (here, there) = (curve(&mixed()), curve(&moved(&mixed())));
    for i in 0..=90 {
        let (a, mut b) = (here.at(f64::from(i) * 0.1), there.at(f64::from(i) * 0.1));
        b.eye -= far;
        // Coordinates of 4.5e6 are rounded to 1e-9.
        assert!(off(&a, &b) < 1e-7, "{i}: {a:?} {b:?}");
    }
}
