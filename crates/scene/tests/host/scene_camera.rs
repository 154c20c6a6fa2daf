//! Cameras of a scene: given, framed, and what is said of them.

use glam::{DVec2, DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::points::Points;
use pellucid_scene::*;

use crate::scene::{CLOUD, scene_of, with_cloud};

pub fn points(positions: &[DVec3], radius: f32) -> Points {
    Points {
        positions: positions.to_vec(),
        colors: vec![Vec3::ONE; positions.len()],
        opacities: vec![1.0; positions.len()],
        radii: vec![radius; positions.len()],
        ..Points::default()
    }
}

fn camera_of(text: &str, points: &Points, up: UpAxis, view: View) -> (Camera, Vec<String>) {
    let mut scene = scene_of(&format!("{text}\n{CLOUD}"));
    scene.camera.view = view;
    camera(&scene, points, up).unwrap()
}

/// Asserts that every point's disc lies inside the image and the depth range.
fn assert_frames(camera: &Camera, points: &Points, size: [u32; 2]) {
    for (position, radius) in points.positions.iter().zip(&points.radii) {
        let (pixel, z) = camera.project(*position, size);
        let radius_px = f64::from(*radius) * camera.pixels_per_unit(z, size[1]);
        assert!(z >= camera.near && z <= camera.far, "{z} in {}..{}", camera.near, camera.far);
        for (at, side) in [(pixel.x, size[0]), (pixel.y, size[1])] {
            assert!(at - radius_px >= 0.0 && at + radius_px <= f64::from(side), "{pixel} ± {radius_px} in {size:?}");
        }
    }
}

#[test]
fn automatic_cameras_frame_any_scene_at_any_shape_of_image() {
    let scenes: [(&[DVec3], f32); 6] = [
        (&[DVec3::new(-3.0, 0.0, 1.0), DVec3::new(5.0, 2.0, 9.0)], 0.1),
        (&[DVec3::new(636_000.0, 850_500.0, 411.0), DVec3::new(638_000.0, 852_500.0, 598.0)], 2.0),
        (&[DVec3::ZERO, DVec3::Z * 10.0], 0.0),
        (&[DVec3::new(5e5, 4.5e6, 1e2)], 0.0),
        (&[DVec3::ZERO], 7.0),
        (&[DVec3::ZERO, DVec3::X * 1e-9], 0.0),
    ];
    let views = [None, Some(ViewName::Front), Some(ViewName::Top), Some(ViewName::Left), Some(ViewName::Iso)];
    for (positions, radius) in scenes {
        for (size, name) in [[100, 100], [400, 100], [100, 400], [1, 16384]].iter().zip(views.iter().cycle()) {
            for up in [UpAxis::Y, UpAxis::Z] {
                let points = points(positions, radius);
                let text = format!("[image]\nsize = {size:?}");
                let (camera, warnings) = camera_of(&text, &points, up, View { name: *name, ..View::default() });
                assert!(warnings.is_empty(), "{warnings:?}");
                assert_frames(&camera, &points, *size);
            }
        }
    }
}

#[test]
fn a_camera_that_is_given_in_full_needs_no_points() {
    let points = points(&[DVec3::new(-3.0, 0.0, 1.0), DVec3::new(5.0, 2.0, 9.0)], 0.1);
    let bounds = points.bounds().unwrap();
    let given = "eye = [4500000.3, -20.1, 7.7]\ntarget = [4500000.1, 0.3, 0.2]\nup = [0.1, 0.2, 0.9]\n";
    for lens in ["fov_y = 33.3", "height = 12.5", "near = 0.5", "far = 77"] {
        let scene = with_cloud(&format!("[camera]\n{given}{lens}\n"));
        let (found, _) = camera(&scene, &points, UpAxis::Z).unwrap();
        assert_eq!(camera_at(&scene.camera, &bounds, f64::from(0.1f32)), Some(found), "{lens}");
    }
    for missing in ["eye = [1, 2, 3]\ntarget = [0, 0, 0]", "eye = [1, 2, 3]\nup = [0, 0, 1]", "up = [0, 0, 1]"] {
        let scene = with_cloud(&format!("[camera]\n{missing}\n"));
        assert_eq!(camera_at(&scene.camera, &bounds, 0.1), None, "{missing}");
    }
}

#[test]
fn framing_fills_the_image_up_to_the_margin() {
    // A square of side 2 across the view: 95% of 100 pixels.
    let square = points(&[DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)], 0.0);
    let (camera, _) = camera_of(
        "[image]\nsize = [100, 100]",
        &square,
        UpAxis::Y,
        View { name: Some(ViewName::Front), ..View::default() },
    );
    let (corner, _) = camera.project(DVec3::new(-1.0, 1.0, 0.0), [100, 100]);
    assert!((corner.x - 2.5).abs() < 1e-9 && (corner.y - 2.5).abs() < 1e-9, "{corner}");
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 45f64.to_radians() });
}

#[test]
fn framing_follows_the_points_and_not_the_corners_of_their_box() {
    // The diagonal of a long box, and one larger sphere in the middle that reaches nowhere.
    let mut line = points(&[DVec3::new(-40.0, 0.0, -5.0), DVec3::ZERO, DVec3::new(40.0, 1.0, 5.0)], 0.0);
    line.radii[1] = 0.5;
    let size = [300, 100];
    for name in [ViewName::Front, ViewName::Back, ViewName::Top] {
        let view = View { name: Some(name), ..View::default() };
        let (camera, _) = camera_of("[image]\nsize = [300, 100]", &line, UpAxis::Y, view);
        assert_frames(&camera, &line, size);
        let pixels = [0, 2].map(|i| camera.project(line.positions[i], size).0);
        let (min, max) = (pixels[0].min(pixels[1]), pixels[0].max(pixels[1]));
        // Both ends lie on the margin, 2.5% of the width or of the height.
        let wide = (min.x - 7.5).abs() < 1e-6 && (max.x - 292.5).abs() < 1e-6;
        let high = (min.y - 2.5).abs() < 1e-6 && (max.y - 97.5).abs() < 1e-6;
        assert!(wide || high, "{name:?}: {min} to {max}");
    }
}

#[test]
fn framing_centers_what_does_not_fill_the_image() {
    // A flat square of ground from above its front edge: the far edge is shorter and higher in the image.
    let mut ground: Vec<_> = (0..400).map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0)).collect();
    ground.push(DVec3::new(3.0, 4.0, 2.0));
    let ground = points(&ground, 0.0);
    for text in ["", "[camera]\nfov_y = 100.0", "[camera]\nheight = 60.0"] {
        for elevation in [Some(5.0), Some(35.0), Some(80.0)] {
            let size = [200, 200];
            let view = View { elevation, ..View::default() };
            let (camera, _) = camera_of(&format!("[image]\nsize = [200, 200]\n{text}"), &ground, UpAxis::Z, view);
            assert_frames(&camera, &ground, size);
            let pixels = || ground.positions.iter().map(|p| camera.project(*p, size).0);
            let (min, max) = pixels().fold((DVec2::INFINITY, -DVec2::INFINITY), |(a, b), p| (a.min(p), b.max(p)));
            // The last step of the search is below a ten-thousandth of the distance: 0.03 pixels at 45°.
            let off = (0.5 * (min + max) - 100.0).abs();
            assert!(off.max_element() < 0.05, "{text} {elevation:?}: {min} to {max}");
        }
    }
}

#[test]
fn surveys_stand_on_z_and_models_on_y() {
    let cube = points(&[DVec3::ZERO, DVec3::ONE], 0.0);
    let up = |axis| camera_of("", &cube, axis, View::default()).0;
    assert!(up(UpAxis::Z).up.z > 0.5 && up(UpAxis::Z).eye.y < 0.0, "from the south, Z up");
    assert!(up(UpAxis::Y).up.y > 0.5 && up(UpAxis::Y).eye.z > 1.0, "from the front, Y up");
    let cloud = |up| Cloud { up, ..Cloud::default() };
    assert_eq!(up_axis(&[cloud(UpAxis::Y), cloud(UpAxis::Z)]), UpAxis::Z);
    assert_eq!(up_axis(&[cloud(UpAxis::Y), cloud(UpAxis::Y), cloud(UpAxis::Z)]), UpAxis::Y);
}

#[test]
fn a_given_camera_is_taken_as_it_is_with_the_default_depths() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.5);
    let (camera, warnings) =
        camera_of("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]", &cube, UpAxis::Z, View::default());
    assert_eq!((camera.eye, camera.forward, camera.up), (DVec3::Z * 5.0, -DVec3::Z, DVec3::Y));
    // z runs from 4 to 6 over the corners, r_max is 0.5.
    assert!((camera.far - 1.001 * 6.5).abs() < 1e-12 && (camera.near - 0.999 * 3.5).abs() < 1e-12);
    assert_eq!(warnings, [""; 0]);
    // Inside the box z_min is negative: near is far·1e-5.
    let (camera, _) = camera_of("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, -1]", &cube, UpAxis::Y, View::default());
    assert!((camera.far - 1.001 * 1.5).abs() < 1e-12 && (camera.near - camera.far * 1e-5).abs() < 1e-15);
}

#[test]
fn a_camera_that_sees_nothing_says_so() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.1);
    let away = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 10]";
    let (camera, warnings) = camera_of(away, &cube, UpAxis::Y, View::default());
    assert!(camera.near > 0.0 && camera.near < camera.far);
    assert!(warnings[0].contains("the camera sees nothing"), "{warnings:?}");
    let (_, warnings) = camera_of("[camera]\nfar = 0.01", &cube, UpAxis::Y, View::default());
    assert!(warnings[0].contains("the camera sees nothing"), "{warnings:?}");
    let beside = "[camera]\neye = [0, 0, 5]\ntarget = [100, 0, 5]\nup = [0, 1, 0]";
    assert_eq!(camera_of(beside, &cube, UpAxis::Y, View::default()).1.len(), 1);
}

#[test]
fn a_camera_moved_with_its_cloud_is_the_same_camera() {
    let shift = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let camera = |shift: DVec3| {
        let [eye, target] = [shift + DVec3::new(1.0, 2.0, 5.0), shift].map(|v| format!("{:?}", v.to_array()));
        let cube = points(&[shift - DVec3::ONE, shift + DVec3::ONE], 0.5);
        camera_of(&format!("[camera]\neye = {eye}\ntarget = {target}"), &cube, UpAxis::Y, View::default()).0
    };
    let (here, there) = (camera(DVec3::ZERO), camera(shift));
    assert_eq!(Camera { eye: here.eye, ..there }, here);
}

#[test]
fn coordinates_that_no_camera_can_hold_are_an_error() {
    let huge = points(&[DVec3::ZERO, DVec3::X * 1e200], 0.0);
    let error = camera(&scene_of(CLOUD), &huge, UpAxis::Y).unwrap_err();
    assert_eq!(error.exit_status(), 1, "{error}");
}

#[test]
fn the_up_of_the_file_says_which_axis_views_take_as_the_vertical() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.0);
    let front = View { name: Some(ViewName::Front), ..View::default() };
    let up = |text, axis| camera_of(text, &cube, axis, front).0.up;
    assert_eq!(up("[camera]\nup = [0, 0.1, 1]", UpAxis::Y), DVec3::Z);
    assert_eq!(up("[camera]\nup = [0, 2, 0]", UpAxis::Z), DVec3::Y);
    assert_eq!(up("[camera]\nup = [0, -1, 0.5]", UpAxis::Z), -DVec3::Y);
    assert_eq!(up("[camera]\nup = [1, 0, 0]", UpAxis::Z), DVec3::X);
    assert_eq!(up("[camera]\nup = [1, 1, 0]", UpAxis::Z), DVec3::Z, "between two axes: the clouds' own");
    let (_, warnings) = camera_of("[camera]\nup = [1, 0, 0]", &cube, UpAxis::Z, front);
    assert_eq!(warnings, [""; 0], "a view heeds it");
}

#[test]
fn an_orthographic_camera_shows_the_whole_scene() {
    // 6 wide and 4 high from the front, 2 deep.
    let flat = points(&[DVec3::new(-3.0, -2.0, -1.0), DVec3::new(3.0, 2.0, 1.0)], 0.0);
    let front = View { name: Some(ViewName::Front), ..View::default() };
    let of = |text: &str, size: [u32; 2], view| {
        let text = format!("[image]\nsize = {size:?}\n[camera]\northo = true\n{text}");
        let (camera, _) = camera_of(&text, &flat, UpAxis::Y, view);
        let Projection::Orthographic { height } = camera.projection else { panic!("{camera:?}") };
        (camera, height)
    };
    // The width decides in a square and in a high image, the height in a wide one.
    for (size, wanted) in [([100, 100], 6.0), ([100, 200], 12.0), ([400, 100], 4.0)] {
        let (camera, height) = of("", size, front);
        assert!((height - wanted / 0.95).abs() < 1e-12, "{size:?}: {height}");
        assert_frames(&camera, &flat, size);
        assert_frames(&of("", size, View::default()).0, &flat, size);
    }
    assert_eq!(of("height = 5", [100, 100], front).1, 5.0);
    // Around a point of the left edge: the right edge is 6 away, on both sides of the image.
    let aside = "eye = [-3, 0, 9]\ntarget = [-3, 0, 0]\nup = [0, 1, 0]";
    assert!((of(aside, [100, 100], View::default()).1 - 12.0 / 0.95).abs() < 1e-12);
    let refused = Scene::from_toml(&format!("[camera]\northo = true\nfov_y = 30\n{CLOUD}"), "s.toml".as_ref());
    assert!(refused.unwrap_err().to_string().contains("keep one"));
}

#[test]
fn a_view_replaces_the_eye_but_keeps_the_projection() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.0);
    let view = View { name: Some(ViewName::Right), ..View::default() };
    let (camera, warnings) = camera_of("[camera]\neye = [0, 0, 5]\nheight = 4", &cube, UpAxis::Y, view);
    assert_eq!((camera.forward, camera.projection), (-DVec3::X, Projection::Orthographic { height: 4.0 }));
    assert!(warnings[0].contains("replaces `eye`"), "{warnings:?}");
}
