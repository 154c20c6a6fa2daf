//! The window of `pellucid view` on a display without a screen, with a real pointer and real keys. Without Xvfb and xdotool these
//! tests are skipped with a note, or fail if `PELLUCID_REQUIRE_GPU` is 1.
#![cfg(all(unix, feature = "viewer"))]

mod viewer {
    pub mod display;
    mod panel;
    pub mod window;
}

use std::path::Path;
use std::time::{Duration, Instant};

use pellucid::gpu::{Device, DeviceOptions};
use pellucid::output::read_image;
use pellucid::scene::{Overrides, Scene};
use viewer::display::{Display, SIZE};
use viewer::window::{Window, command};

/// The window in these tests.
const WINDOW: &str = "720x420";

fn with_display(test: impl FnOnce(&Display)) {
    match Display::start() {
        Some(display) => test(&display),
        None if std::env::var("PELLUCID_REQUIRE_GPU").is_ok_and(|v| v == "1") => {
            panic!("Xvfb and xdotool are required: tools/setup.sh --tests installs them")
        }
        None => eprintln!("skipped, no Xvfb or no xdotool"),
    }
}

/// A small garden as files, and the folder that they are in.
fn garden() -> tempfile::TempDir {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let output = command(folder.path()).args(["scene", "garden", "--set", "points=12000", "-o", "."]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    folder
}

/// Presses F12 and waits for the files: their common name. The pointer goes to the panel, lest it be seen in the picture.
fn shoot(display: &Display, window: &mut Window) -> String {
    display.do_it("mousemove 715 415");
    display.do_it("key F12");
    let line = window.wait_for("saved ");
    line.split_once("saved ").unwrap().1.split(".toml").next().unwrap().to_owned()
}

/// Waits until the screen shows a picture.
#[track_caller]
fn wait_for_screen(display: &Display, picture: &Path) {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        let differing = not_on_screen(display, picture);
        if differing == 0 {
            return;
        }
        assert!(Instant::now() < until, "{differing} pixels of {} are shown otherwise", picture.display());
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Renders a saved scene with further options; the bytes of the picture.
fn rendered(folder: &Path, name: &str, options: &[&str]) -> Vec<u8> {
    let scene = format!("{name}.toml");
    let output = command(folder).args(["render", &scene, "-o", "again.png"]).args(options).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    std::fs::read(folder.join("again.png")).unwrap()
}

fn scene(folder: &Path, name: &str) -> Scene {
    Scene::read(&folder.join(format!("{name}.toml")), &Overrides::default()).unwrap()
}

/// Pixels that differ between a picture and another one of its size.
fn differing(a: &Path, b: &Path) -> usize {
    let (a, b) = (read_image(a).unwrap(), read_image(b).unwrap());
    assert_eq!((a.width, a.height), (b.width, b.height));
    a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count()
}

/// Pixels of the picture that the screen shows otherwise, the picture being at its left upper corner.
fn not_on_screen(display: &Display, picture: &Path) -> usize {
    let image = read_image(picture).unwrap();
    let byte = |x: f32| (255.0 * pellucid::color::encode_srgb(x) + 0.5).floor() as u8;
    let (screen, width) = (display.pixels(), image.width as usize);
    let shown = |i: usize| screen[i / width * SIZE[0] + i % width];
    image.pixels.iter().enumerate().filter(|(i, pixel)| pixel.map(byte) != shown(*i)).count()
}

#[test]
fn without_a_display_the_error_names_render() {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    for display in [None, Some(":9876"), Some("nonsense")] {
        let mut view = command(folder.path());
        view.arg("view");
        if let Some(display) = display {
            view.env("DISPLAY", display);
        }
        let output = view.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.starts_with("error: no window can be opened: ") && said.contains("`pellucid render`"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(output.stdout.is_empty());
    }
}

/// SwiftShader, as browsers have it, shows nothing in X11's windows: that is said. Without any device there is nothing to test.
fn shows_windows(display: &Display) -> bool {
    let required = std::env::var("PELLUCID_REQUIRE_GPU").is_ok_and(|v| v == "1");
    match Device::open(&DeviceOptions { validation: true, ..DeviceOptions::default() }) {
        Ok(device) if device.info().name.contains("SwiftShader") => {
            let folder = garden();
            let view =
                command(folder.path()).env("DISPLAY", &display.name).args(["view", "scene.toml"]).output().unwrap();
            let said = String::from_utf8(view.stderr).unwrap();
            assert_eq!(view.status.code(), Some(1), "{said}");
            assert!(said.starts_with("error: no picture can be shown in a window: "), "{said}");
            assert!(said.contains("`pellucid render`"), "{said}");
            false
        }
        Ok(_) => true,
        Err(error) if required => panic!("a device is required: {error}"),
        Err(error) => {
            eprintln!("skipped, no device: {error}");
            false
        }
    }
}

/// A slider of a tree's leaves, then the pointer on the picture, then the window: what is seen, saved and rendered is the same.
#[test]
fn what_is_seen_is_what_render_makes() {
    with_display(|display| {
        if !shows_windows(display) {
            return;
        }
        let folder = garden();
        let folder = folder.path();
        let mut window = Window::open(folder, &display.name, &["view", "scene.toml", "--size", WINDOW]);
        window.wait_for("at rest");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        // Without the times over it the picture is there alone.
        display.do_it("key t");

        let first = shoot(display, &mut window);
        let picture = |name: &str| folder.join(format!("{name}.png"));
        assert_eq!(std::fs::read(picture(&first)).unwrap(), rendered(folder, &first, &[]));
        wait_for_screen(display, &picture(&first));

        // Leaves are the last cloud: without them the picture is the one that the scene gives with opacity 0.
        let [left, top, _, height] = window.control("cloud.5.opacity");
        let y = top + height / 2;
        display.drag(1, [left + 40, y], [left - 30, y]);
        window.wait_for("at rest");
        let second = shoot(display, &mut window);
        assert_eq!(scene(folder, &second).clouds[5].opacity, 0.0);
        assert_eq!(std::fs::read(picture(&second)).unwrap(), rendered(folder, &second, &[]));
        rendered(folder, &first, &["--set", "cloud.5.opacity=0"]);
        assert_eq!(differing(&picture(&second), &folder.join("again.png")), 0);
        assert!(differing(&picture(&second), &picture(&first)) > 1000, "the leaves are gone");
        wait_for_screen(display, &picture(&second));

        // Turned by a quarter of the picture's height: 45 degrees around the vertical, as high and as far as before.
        let before = scene(folder, &second);
        let quarter = before.image.size[1] as i32 / 4;
        display.drag(1, [100, 300], [100 + quarter, 300]);
        window.wait_for("at rest");
        display.do_it("mousemove 200 200");
        display.do_it("click --repeat 3 4");
        window.wait_for("at rest");
        let third = shoot(display, &mut window);
        let after = scene(folder, &third);
        assert_eq!(std::fs::read(picture(&third)).unwrap(), rendered(folder, &third, &[]));
        wait_for_screen(display, &picture(&third));
        let along = |scene: &Scene| (scene.camera.target.unwrap() - scene.camera.eye.unwrap()).normalize();
        let angle = along(&before).with_z(0.0).angle_between(along(&after).with_z(0.0)).to_degrees();
        assert!((angle - 180.0 * f64::from(quarter) / f64::from(before.image.size[1])).abs() < 1e-6, "{angle}");
        assert!((along(&before).z - along(&after).z).abs() < 1e-9, "no higher and no lower");

        display.do_it(&format!("windowsize --sync {id} 640 400"));
        window.wait_for(" 310 × 400");
        display.do_it(&format!("windowunmap --sync {id}"));
        display.do_it(&format!("windowmap --sync {id}"));
        display.do_it(&format!("windowsize --sync {id} 600 380"));
        window.wait_for(" 270 × 380");
        display.do_it(&format!("windowfocus --sync {id}"));
        display.do_it("key ctrl+q");
        let (status, said) = window.end();
        assert_eq!(status, Some(0), "{said}");
        assert!(!said.contains("leaked") && !said.contains("error") && !said.contains("panicked"), "{said}");
    });
}
