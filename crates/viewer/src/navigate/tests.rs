//! Properties of every movement, also far from the origin.

use super::*;
use pellucid_scene::{ViewName, camera_at};

const SIZE: [u32; 2] = [640, 480];

fn subject(center: DVec3) -> CameraSubject {
    let half = DVec3::new(5.0, 4.0, 3.0);
    let bounds = Bounds { min: center - half, max: center + half };
    CameraSubject { bounds, radius: 0.1, up: UpAxis::Z, vertical: UpAxis::Z.into() }
}

/// Navigators near the origin and where surveys are, from the side, slanted and from straight above.
fn navigators() -> impl Iterator<Item = Navigator> {
    let centers = [DVec3::ZERO, DVec3::new(500_000.0, 4_500_000.0, 100.0)];
    let eyes = [DVec3::new(0.0, -20.0, 0.0), DVec3::new(9.0, -12.0, 7.0), DVec3::new(-3.0, 8.0, -11.0)];
    let perspective = Projection::Perspective { fov_y: 45f64.to_radians() };
    centers.into_iter().flat_map(move |center| {
        let from = move |eye: DVec3| {
            let camera = Camera::look_at(center + eye, center, DVec3::Z, perspective, 0.1, 100.0).unwrap();
            Navigator::new(&camera, Some(45.0), subject(center))
        };
        let above = Camera::look_at(center + 20.0 * DVec3::Z, center, DVec3::Y, perspective, 0.1, 100.0).unwrap();
        let above = Navigator::new(&above, Some(45.0), subject(center));
        eyes.into_iter().map(from).chain([above]).flat_map(|navigator| {
            let mut flat = navigator;
            flat.toggle_projection();
            [navigator, flat]
        })
    })
}

fn camera(navigator: &Navigator) -> Camera {
    let CameraSubject { bounds, radius, .. } = navigator.subject;
    camera_at(&navigator.settings(None, None), &bounds, radius).expect("a camera")
}

/// Rounding of coordinates of 4.5e6, a few times over, seen from 20 away with some 600 pixels over one unit at depth 1:
/// 4.5e6 · 2⁻⁵² · 600 / 20 = 3e-8 pixels for each.
const ROUNDING_PX: f64 = 1e-6;

#[test]
fn a_navigator_starts_where_its_camera_is() {
    for navigator in navigators() {
        let once = camera(&navigator);
        let again = camera(&Navigator::new(&once, Some(45.0), navigator.subject));
        let turned = (once.right - again.right).length() + (once.up - again.up).length();
        assert!(turned < 1e-9, "{once:?} became {again:?}");
        assert!((once.eye - again.eye).length() < 1e-8);
    }
}

#[test]
fn orbit_keeps_the_distance_to_the_pivot_and_its_place_in_the_picture() {
    for mut navigator in navigators() {
        let [right, up, _] = navigator.axes();
        navigator.set_pivot(navigator.pivot() + right * 1.5 - up * 0.7);
        let before = camera(&navigator);
        let (pixel, distance) =
            (before.project(navigator.pivot(), SIZE).0, (navigator.eye - navigator.pivot()).length());
        for step in 0..200 {
            navigator.orbit(DVec2::new(7.0, f64::from(step % 40) - 19.5), 480.0);
            let after = camera(&navigator);
            assert!((after.project(navigator.pivot(), SIZE).0 - pixel).length() < ROUNDING_PX);
            assert!(((navigator.eye - navigator.pivot()).length() - distance).abs() < 1e-7);
        }
    }
}

#[test]
fn nothing_turns_over_at_the_poles() {
    for mut navigator in navigators() {
        for down in [1.0, -1.0] {
            let mut last = navigator.axes();
            for _ in 0..400 {
                navigator.orbit(DVec2::new(0.0, 3.0 * down), 480.0);
                let axes = navigator.axes();
                // 3 pixels are π·3/480 = 0.02 radians.
                let turned = (0..3).map(|i| (axes[i] - last[i]).length()).fold(0.0, f64::max);
                assert!(turned < 0.0197, "turned by {turned}");
                assert!(axes[1].dot(navigator.table.vertical) > -1e-12, "upside down");
                last = axes;
            }
            let straight = last[2].dot(navigator.table.vertical) * down;
            assert!((straight + 1.0).abs() < 1e-12, "{straight}");
            // Straight from above a turn to the side is still a turn of the picture.
            navigator.orbit(DVec2::new(120.0, 0.0), 480.0);
            assert!((navigator.axes()[1].dot(last[1]) - (PI / 4.0).cos()).abs() < 1e-9);
        }
    }
}

#[test]
fn zoom_keeps_the_point_under_the_pointer() {
    for navigator in navigators() {
        let before = camera(&navigator);
        for (pixel, z) in [(DVec2::new(100.5, 400.0), 12.0), (DVec2::new(600.0, 3.0), 25.0)] {
            let point = unproject(&before, SIZE, pixel, z);
            let mut moved = navigator;
            for factor in [0.9, 0.5, 0.8, 2.0, 0.3, 0.95] {
                moved.zoom(point, factor);
                let there = camera(&moved).project(point, SIZE).0;
                // 0.1 as far away after all, so that rounding counts ten times.
                assert!((there - pixel).length() < 10.0 * ROUNDING_PX, "{pixel} became {there}");
            }
            let share = match moved.height {
                Some(height) => height / navigator.height.unwrap(),
                None => (moved.eye - point).length() / (navigator.eye - point).length(),
            };
            assert!((share - 0.9 * 0.5 * 0.8 * 2.0 * 0.3 * 0.95).abs() < 1e-6, "{share}");
        }
    }
}

#[test]
fn zoom_ends_before_the_point_and_far_outside() {
    for mut navigator in navigators() {
        let point = navigator.pivot();
        (0..10_000).for_each(|_| navigator.zoom(point, 0.5));
        assert!(camera(&navigator).eye.is_finite() && navigator.eye != point);
        (0..10_000).for_each(|_| navigator.zoom(point, 2.0));
        assert!((navigator.eye - point).length() < 2e3 * navigator.subject.reach());
        navigator.zoom(DVec3::NAN, 0.5);
        navigator.zoom(point, f64::NAN);
        assert!(camera(&navigator).eye.is_finite());
    }
}

#[test]
fn pan_moves_the_pivot_with_the_pointer() {
    for mut navigator in navigators() {
        let (point, drag) = (navigator.pivot(), DVec2::new(30.0, -12.0));
        let before = camera(&navigator).project(point, SIZE).0;
        navigator.pan(drag, 480.0);
        let after = camera(&navigator).project(point, SIZE).0;
        assert!((after - before - drag).length() < ROUNDING_PX, "{before} {after}");
    }
}

#[test]
fn picking_inverts_projection() {
    for navigator in navigators() {
        let camera = camera(&navigator);
        for (x, y, z) in [(0.0, 0.0, 1.0), (320.0, 240.0, 15.0), (639.5, 7.25, 40.0)] {
            let pixel = DVec2::new(x, y);
            let (back, depth) = camera.project(unproject(&camera, SIZE, pixel, z), SIZE);
            // At depth 1 rounding counts 20 times as much as at 20.
            assert!((back - pixel).length() < 20.0 * ROUNDING_PX, "{pixel} became {back}");
            assert!((depth - z).abs() < 1e-8);
        }
    }
}

#[test]
fn both_projections_show_the_pivot_equally_large_at_the_same_place() {
    for navigator in navigators() {
        let mut other = navigator;
        other.toggle_projection();
        assert_ne!(other.is_orthographic(), navigator.is_orthographic());
        let (a, b) = (camera(&navigator), camera(&other));
        let [right, ..] = navigator.axes();
        for point in [navigator.pivot(), navigator.pivot() + right] {
            assert!((a.project(point, SIZE).0 - b.project(point, SIZE).0).length() < 1e-5);
        }
        other.toggle_projection();
        assert!((other.eye - navigator.eye).length() < 1e-7);
    }
}

#[test]
fn an_orthographic_camera_has_everything_before_it() {
    for mut navigator in navigators().filter(Navigator::is_orthographic) {
        for step in 0..60 {
            navigator.orbit(DVec2::new(31.0, f64::from(step) - 30.0), 480.0);
            navigator.fly(DVec3::new(0.1, -0.2, 0.3), 0.1);
            let camera = camera(&navigator);
            let nearest = navigator.subject.bounds.corners().map(|corner| camera.to_view(corner).z);
            assert!(nearest.iter().all(|z| *z - 0.1 > camera.near && *z + 0.1 < camera.far), "{camera:?}");
        }
    }
}

#[test]
fn flying_ahead_comes_nearer_as_fast_as_said() {
    let mut navigator = navigators().next().expect("one");
    let before = navigator.eye;
    navigator.fly(DVec3::Z, 0.25);
    // The pivot is 20 away: a quarter of it in a quarter of a second, straight ahead.
    assert!((navigator.eye - before - DVec3::Y * 5.0).length() < 1e-9, "{}", navigator.eye);
    navigator.fly(DVec3::X, 0.25);
    assert!((navigator.eye.x - 5.0).abs() < 1e-9, "{}", navigator.eye);
}

#[test]
fn depths_are_found_near_the_pointer() {
    let mut depths = vec![f32::INFINITY; 5 * 4];
    depths[2 * 5 + 3] = 7.0;
    depths[5] = f32::NAN;
    let at = |x, y, reach| depth_at(&depths, [5, 4], DVec2::new(x, y), reach);
    assert_eq!(at(3.2, 2.9, 0), Some(7.0));
    assert_eq!(at(2.2, 2.9, 0), None);
    assert_eq!(at(2.2, 2.9, 1), Some(7.0));
    assert_eq!(at(2.2, 1.9, 1), None, "the corner is more than a pixel away");
    assert_eq!(at(0.5, 1.5, 2), None, "NaN is no depth");
    assert_eq!(at(-1e30, f64::NAN, 2), None);
    assert_eq!(at(1e30, 1e30, 2), None);
}

/// Straight views included, whose pictures have another direction at the top.
#[test]
fn a_saved_view_says_the_vertical() {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    for vertical in axes.map(|axis| Vertical::nearest(axis).unwrap()) {
        let center = DVec3::new(500_000.0, 4_500_000.0, 100.0);
        let subject = CameraSubject { vertical, ..subject(center) };
        for (name, word, _) in &ViewName::ALL[..7] {
            let (forward, up) = View { name: Some(*name), ..View::default() }.axes(vertical);
            let perspective = Projection::Perspective { fov_y: 45f64.to_radians() };
            let shown = Camera {
                eye: center - 20.0 * forward,
                forward,
                up,
                right: forward.cross(up),
                ..camera(&navigators().next().unwrap())
            };
            let mut navigator = Navigator::new(&Camera { projection: perspective, ..shown }, Some(45.0), subject);
            let settings = navigator.settings(None, None);
            assert_eq!(Vertical::nearest(settings.up.unwrap()), Some(vertical), "{word} {vertical}");
            let saved = camera(&navigator);
            // Rounding of coordinates of 4.5e6 over a distance of 20.
            let off = (saved.forward - forward).length() + (saved.up - up).length();
            assert!(off < 1e-9, "{word} {vertical}: {saved:?}");
            navigator.orbit(DVec2::new(50.0, 20.0), 480.0);
            assert!(camera(&navigator).right.dot(vertical.up()).abs() < 1e-9, "{word} {vertical}: not level");
        }
    }
}
