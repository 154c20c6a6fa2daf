//! The turn around a scene.

use std::path::Path;

use glam::DVec3;
use pellucid_core::camera::path::Turntable;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::UpAxis;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_scene::{self as scene, Course, Scene, View, procedural};

use crate::scene_camera::points;

#[test]
fn a_quarter_is_ninety_degrees_of_azimuth() {
    let center = DVec3::new(10.0, -3.0, 2.0);
    let camera = |azimuth: f64, up: UpAxis| {
        let view = View { name: None, azimuth: Some(azimuth), elevation: Some(25.0) };
        let (forward, top) = view.axes(up);
        let projection = Projection::Perspective { fov_y: 0.7 };
        let camera = Camera::look_at(DVec3::ZERO, forward, top, projection, 0.1, 10.0).unwrap();
        Camera { eye: center - forward * 7.0, ..camera }
    };
    for (up, axis) in [(UpAxis::Z, DVec3::Z), (UpAxis::Y, DVec3::Y)] {
        let frames = Turntable::new(&camera(20.0, up), center, axis).frames(36);
        assert_eq!(frames.len(), 36);
        for (i, frame) in frames.iter().enumerate() {
            let expected = camera(20.0 + 10.0 * i as f64, up);
            let pairs = [
                (frame.eye, expected.eye),
                (frame.right, expected.right),
                (frame.up, expected.up),
                (frame.forward, expected.forward),
            ];
            for (a, b) in pairs {
                assert!((a - b).length() < 1e-13 * 20.0, "{up:?}, frame {i}: {a} {b}");
            }
        }
        let quarter = camera(110.0, up);
        assert!((frames[9].eye - quarter.eye).length() < 1e-12 && (frames[8].eye - quarter.eye).length() > 0.1);
    }
}

#[test]
fn the_first_frame_is_the_camera_itself() {
    let (center, projection) = (DVec3::new(0.7, -0.3, 4_500_000.1), Projection::Perspective { fov_y: 0.7 });
    for i in 1..50 {
        let eye = DVec3::new(0.1 * f64::from(i), 0.37, -7.7 + f64::from(i) * 0.3);
        let camera = Camera::look_at(eye, center, DVec3::Y, projection, 0.1, 10.0).unwrap();
        let turntable = Turntable::new(&camera, center, DVec3::Z);
        assert_eq!((turntable.frames(3)[0], turntable.start.eye), (turntable.start, eye));
    }
}

/// The cameras of a turn around points in a scene of this text.
fn turned(text: &str, points: &Points, up: UpAxis, view: View, count: usize) -> Vec<Camera> {
    let text = format!("{text}\n[[cloud]]\npath = \"a.ply\"\n");
    let mut scene = Scene::from_toml(&text, Path::new("s.toml")).unwrap();
    scene.camera.view = view;
    let course = Course::new(&scene, points, up).unwrap();
    let (turntable, warnings) = course.turntable().unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    turntable.frames(count).iter().map(|pose| course.camera(pose).unwrap().camera()).collect()
}

/// Distance of the nearest disc from the image's border, as a share of that side; all must be within the depths.
fn margin(camera: &Camera, points: &Points, size: [u32; 2]) -> f64 {
    let mut least = f64::INFINITY;
    for (position, radius) in points.positions.iter().zip(&points.radii) {
        let (pixel, z) = camera.project(*position, size);
        let radius_px = f64::from(*radius) * camera.pixels_per_unit(z, size[1]);
        assert!(z >= camera.near && z <= camera.far, "{z} in {}..{}", camera.near, camera.far);
        for (at, side) in [(pixel.x, f64::from(size[0])), (pixel.y, f64::from(size[1]))] {
            least = least.min((at - radius_px) / side).min((side - at - radius_px) / side);
        }
    }
    least
}

#[test]
fn all_of_the_scene_is_in_every_frame_and_not_far_from_its_border() {
    let beam = [DVec3::new(-30.0, 1.0, -2.0), DVec3::new(30.0, 0.0, 3.0), DVec3::new(0.0, 0.0, 9.0)];
    let survey = [DVec3::new(636_000.0, 850_500.0, 411.0), DVec3::new(638_000.0, 852_500.0, 598.0)];
    let mut wide_eyes = 0;
    for (positions, radius) in [(&beam[..], 0.0), (&beam[..], 0.5), (&survey[..], 2.0), (&[DVec3::ZERO][..], 7.0)] {
        let points = points(positions, radius);
        for size in [[100, 100], [400, 100], [100, 400]] {
            for (up, elevation) in [(UpAxis::Z, 30.0), (UpAxis::Y, -20.0), (UpAxis::Z, 90.0), (UpAxis::Z, 0.0)] {
                let view = View { name: None, azimuth: Some(33.0), elevation: Some(elevation) };
                let cameras = turned(&format!("[image]\nsize = {size:?}"), &points, up, view, 720);
                let least = cameras.iter().map(|camera| margin(camera, &points, size)).fold(f64::INFINITY, f64::min);
                // 2.5% are left where something comes nearest. A sphere of radius r touches the plane of slope t, but
                // the disc that is drawn of it ends r·(√(1 + t²) − 1)/z earlier, a share of that over 2t/0.95 of the
                // side. At half a degree from frame to frame the nearest point is missed by less than 1e-4 of its way.
                let tangent = 0.95 * 22.5f64.to_radians().tan();
                let slack = |t: f64, z: f64| f64::from(radius) * ((1.0 + t * t).sqrt() - 1.0) / z * 0.95 / (2.0 * t);
                let nearest = cameras.iter().flat_map(|camera| positions.iter().map(|p| camera.to_view(*p).z));
                let z = nearest.fold(f64::INFINITY, f64::min);
                let wide = tangent * f64::from(size[0]) / f64::from(size[1]);
                let most = 0.0252 + slack(tangent, z).max(slack(wide, z));
                // In a wide image the planes would let the eye come nearer than a tenth of the scene's size to it.
                let near = 0.1 * (points.bounds().unwrap().diagonal() + f64::from(radius)) + f64::from(radius);
                let held = z < 1.001 * near;
                wide_eyes += usize::from(held);
                assert!(z >= near * (1.0 - 1e-9), "{z} is nearer than {near}");
                assert!(
                    least >= 0.025 - 1e-9 && (held || least < most),
                    "{least} to {most} of {size:?}, {up:?}, {elevation}°, nearest {z}"
                );
            }
        }
    }
    assert!(wide_eyes < 12, "most of 48 turns touch the margin: {wide_eyes} don't");
}

#[test]
fn a_target_and_an_eye_are_kept() {
    let points = points(&[DVec3::new(-3.0, 0.0, 1.0), DVec3::new(5.0, 2.0, 9.0)], 0.1);
    let target = DVec3::new(1.0, 2.0, 3.0);
    let view = View::default();
    let cameras = turned("[camera]\ntarget = [1, 2, 3]", &points, UpAxis::Z, view, 8);
    for camera in &cameras {
        let (pixel, _) = camera.project(target, [100, 100]);
        assert!((pixel - 50.0).length() < 1e-9 && margin(camera, &points, [1024, 1024]) >= 0.0);
    }
    let text = "[camera]\neye = [9, 2, 4]\ntarget = [1, 2, 3]\nup = [0, 1, 0]\nnear = 0.5\nheight = 4.0";
    let cameras = turned(text, &points, UpAxis::Z, view, 4);
    // Around y, as up says: z comes from x.
    let expected = [[9.0, 2.0, 4.0], [2.0, 2.0, -5.0], [-7.0, 2.0, 2.0], [0.0, 2.0, 11.0]];
    for (camera, eye) in cameras.iter().zip(expected) {
        assert!((camera.eye - DVec3::from(eye)).length() < 1e-12, "{}", camera.eye);
        assert_eq!((camera.near, camera.projection), (0.5, Projection::Orthographic { height: 4.0 }));
    }
}

/// The points of a built-in scene with the radii of its file, and its text with another size.
fn builtin(name: &str, size: [u32; 2]) -> (Points, String) {
    let set = [("points".to_owned(), 4000.0)];
    let generated = procedural::build(name, if name == "spheres" { &[] } else { &set }, 0).unwrap();
    let scene = Scene::from_toml(&generated.scene_toml, Path::new("s.toml")).unwrap();
    let clouds = scene::take_generated(&scene, &generated).unwrap();
    let arranged = scene::arrange(&scene, clouds, 0, &Progress::hidden()).unwrap();
    let text = generated.scene_toml.split("[[cloud]]").next().unwrap();
    let lines = text.lines().map(|line| match line.starts_with("size = ") {
        true => format!("size = {size:?}"),
        false => line.to_owned(),
    });
    (arranged.points().clone(), lines.collect::<Vec<_>>().join("\n"))
}

/// An eye of a scene from which a turn would lose corners goes back along its line of sight, as far as a turn without
/// an eye stands away: nothing is lost in any frame, and what comes nearest to the border keeps the same margin.
#[test]
fn an_eye_goes_back_until_all_of_the_turn_is_in_view() {
    let mut moved = 0;
    for name in ["garden", "tori", "spheres"] {
        for size in [[640, 480], [300, 300], [160, 500], [900, 200]] {
            let (points, text) = builtin(name, size);
            let whole = format!("{text}\n[[cloud]]\npath = \"a.ply\"\n");
            let own = Scene::from_toml(&whole, Path::new("s.toml")).unwrap().camera;
            let cameras = turned(&text, &points, UpAxis::Z, View::default(), 720);
            let margins = |cameras: &[Camera]| {
                cameras.iter().map(|camera| margin(camera, &points, size)).fold(f64::INFINITY, f64::min)
            };
            let least = margins(&cameras);
            assert!(least >= 0.0, "{name}, {size:?}: {least}");
            let (eye, target) = (own.eye.unwrap(), own.target.unwrap());
            let [near, far] = [eye, cameras[0].eye].map(|eye| (eye - target).length());
            let along = (cameras[0].eye - target).normalize().dot((eye - target).normalize());
            assert!((along - 1.0).abs() < 1e-12, "{name}: along the line of sight");
            if cameras[0].eye == eye {
                continue;
            }
            moved += 1;
            assert!(far > near, "{name}, {size:?}: it goes back");
            let back = |camera: &Camera| Camera { eye: target - camera.forward * near, near: 1e-9, ..*camera };
            let lost = margins(&cameras.iter().map(back).collect::<Vec<_>>());
            // 2.5% are left where something comes nearest, and what a disc is less than its sphere (see above).
            let tangents = [1.0, f64::from(size[0]) / f64::from(size[1])]
                .map(|aspect| 0.95 * aspect * (0.5 * own.fov_y.unwrap().to_radians()).tan());
            let radius = points.radii.iter().fold(0.0, |max: f64, r| max.max(f64::from(*r)));
            let depths = cameras.iter().flat_map(|camera| points.positions.iter().map(|p| camera.to_view(*p).z));
            let z = depths.fold(f64::INFINITY, f64::min);
            let slack = tangents.map(|t| radius * ((1.0 + t * t).sqrt() - 1.0) / z * 0.95 / (2.0 * t));
            let most = 0.0252 + slack[0].max(slack[1]);
            assert!(least >= 0.025 - 1e-9 && least < most, "{name}, {size:?}: {least} to {most}");
            // A sphere that the planes touched may have a disc that did not: with what is between them counted, points
            // were lost.
            assert!(lost < slack[0].max(slack[1]), "{name}, {size:?}: {lost}");
        }
    }
    assert!(moved >= 6, "{moved} of 12 turns would lose points");
}

#[test]
fn an_eye_that_sees_all_and_one_among_the_points_stay() {
    let (points, text) = builtin("garden", [640, 480]);
    for eye in [DVec3::new(60.0, -90.0, 60.0), DVec3::new(1.0, -2.0, 1.5)] {
        let text = text.replace("eye = [12.5, -20.0, 13.5]", &format!("eye = {:?}", eye.to_array()));
        let cameras = turned(&text, &points, UpAxis::Z, View::default(), 36);
        assert_eq!(cameras[0].eye, eye);
    }
}

/// Depths that a scene gives are those of its own eye: from farther away they would cut off what was seen.
#[test]
fn given_depths_go_back_with_the_eye() {
    let (points, text) = builtin("garden", [640, 480]);
    let own = turned(&text, &points, UpAxis::Z, View::default(), 36);
    let still = "eye = [12.5, -20.0, 13.5]";
    let back = (own[0].eye - DVec3::new(12.5, -20.0, 13.5)).length();
    assert!(back > 1.0, "{back}");
    let text = text.replace(still, &format!("{still}\nnear = 2.0\nfar = 60.0"));
    for camera in turned(&text, &points, UpAxis::Z, View::default(), 36) {
        assert!((camera.near - 2.0 - back).abs() < 1e-9 && (camera.far - 60.0 - back).abs() < 1e-9, "{camera:?}");
    }
}
