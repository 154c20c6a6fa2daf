//! The window of `pellucid view` on a display without a screen, with a real pointer and real keys. Without Xvfb and
//! xdotool these tests are skipped with a note, or fail if `PELLUCID_REQUIRE_GPU` is 1.

pub mod display;
pub mod garden;
mod panel;
mod views;
pub mod window;
#[cfg(target_os = "linux")]
pub mod x11;

use std::path::Path;

use garden::{WINDOW, garden, rendered, shoot, wait_for_screen, with_display};
use pellucid_io::output::read_image;
use pellucid_scene::{Overrides, Scene};
use window::{Window, command};

fn scene(folder: &Path, name: &str) -> Scene {
    Scene::read(&folder.join(format!("{name}.toml")), &Overrides::default()).unwrap()
}

/// Pixels that differ between a picture and another one of its size.
fn differing(a: &Path, b: &Path) -> usize {
    let (a, b) = (read_image(a).unwrap(), read_image(b).unwrap());
    assert_eq!((a.width, a.height), (b.width, b.height));
    a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a != b).count()
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
        assert!(said.starts_with("error: can't open a window: ") && said.contains("`pellucid render`"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(output.stdout.is_empty());
    }
}

/// A slider of a tree's leaves, then the pointer on the picture, then the window: what is seen, saved and rendered is
/// the same.
#[test]
fn the_window_shows_the_picture_that_render_makes() {
    with_display(|display| {
        let folder = garden();
        let folder = folder.path();
        let mut window = Window::open(folder, &display.name, &["view", "scene.toml", "--size", WINDOW]);
        window.wait_for("at rest");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        // Without the times over it the picture is there alone.
        display.do_it("key t t");

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
