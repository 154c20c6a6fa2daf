//! A device that is lost, once and again, and one without memory.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use pellucid_scene::{Overrides, Scene};
use pellucid_testing::skip::{NO_MANIFEST, skip};

use crate::viewer::display::Display;
use crate::viewer::garden::{WINDOW, garden, rendered, shoot, wait_for_screen, with_display};
use crate::viewer::window::Window;

/// Opens the window with a fault. The host writes into a CPU driver's memory without a submission, so that faults come
/// where a GPU has them.
fn open(folder: &Path, display: &Display, fault: &str) -> Window {
    let variables = [("DISPLAY", display.name.as_str()), ("PELLUCID_FAULT", fault), ("PELLUCID_PREFER", "gpu")];
    Window::open_with(folder, &variables, &["view", "scene.toml", "--size", WINDOW])
}

/// Gives the window the keys; its number.
fn take(display: &Display) -> String {
    let id = display.do_it("search --sync --onlyvisible --name pellucid");
    display.do_it(&format!("windowfocus --sync {id}"));
    id
}

/// Saves the picture, which must be the one that `render` makes and the one on the screen; the saved files' name.
#[track_caller]
fn assert_right(folder: &Path, display: &Display, window: &mut Window) -> String {
    let name = shoot(display, window);
    let picture = folder.join(format!("{name}.png"));
    assert_eq!(std::fs::read(&picture).unwrap(), rendered(folder, &name, &[]));
    wait_for_screen(display, &picture);
    name
}

#[track_caller]
fn assert_ends(display: &Display, window: Window) -> String {
    display.do_it("key ctrl+q");
    let (status, said) = window.end();
    assert_eq!(status, Some(0), "{said}");
    for part in ["error", "leaked", "validation", "panicked"] {
        assert!(!said.contains(part), "{part}: {said}");
    }
    said
}

/// Loses the device in the first upload, in the middle of the first frame, in a frame of the window, and later, when
/// something is saved.
#[test]
fn a_lost_device_is_opened_again_and_everything_goes_on() {
    with_display(|display| {
        for fault in ["device-lost@submit:1", "device-lost@wait:11", "device-lost@show:6"] {
            let folder = garden();
            let folder = folder.path();
            let mut window = open(folder, display, fault);
            window.wait_for("at rest");
            take(display);
            display.do_it("key t t");
            let first = assert_right(folder, display, &mut window);
            let [left, top, _, height] = window.control("cloud.5.opacity");
            let y = top + height / 2;
            display.drag(1, [left + 40, y], [left - 30, y]);
            window.wait_for("at rest");
            let second = assert_right(folder, display, &mut window);
            let scene = |name: &str| Scene::read(&folder.join(format!("{name}.toml")), &Overrides::default()).unwrap();
            assert!(scene(&first).clouds[5].opacity > 0.0);
            assert_eq!(scene(&second).clouds[5].opacity, 0.0);
            let said = assert_ends(display, window);
            let told = said.lines().filter(|line| line.contains("the device was lost (during ")).count();
            assert_eq!(told, 1, "{fault}: {said}");
            assert!(said.contains(") and opened again"), "{said}");
        }
    });
}

#[test]
fn a_device_that_is_lost_again_is_an_error_that_says_what_helps() {
    with_display(|display| {
        for fault in ["device-lost@wait:5,6", "device-lost@show:2,3"] {
            let folder = garden();
            let window = open(folder.path(), display, fault);
            let (status, said) = window.end();
            assert_eq!(status, Some(1), "{fault}: {said}");
            let last = said.lines().last().unwrap();
            assert!(last.starts_with("error: ") && last.contains(" was lost again, during "), "{fault}: {said}");
            for part in ["--size", "--memory-budget", "--device", "`pellucid render`"] {
                assert!(last.contains(part), "{part}: {said}");
            }
            for part in ["leaked", "validation", "panicked"] {
                assert!(!said.contains(part), "{fault}: {said}");
            }
        }
    });
}

/// The manifest of the driver that tests run on, if it is known: the one that was chosen, or lavapipe's.
fn manifest() -> Option<PathBuf> {
    let chosen = std::env::var_os("VK_DRIVER_FILES").map(PathBuf::from);
    let is_lavapipe =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("lvp_icd"));
    let installed = std::fs::read_dir("/usr/share/vulkan/icd.d").into_iter().flatten().flatten();
    chosen.or_else(|| installed.map(|entry| entry.path()).find(is_lavapipe)).filter(|path| path.is_file())
}

#[test]
fn a_device_that_is_gone_is_an_error_that_says_what_helps() {
    with_display(|display| {
        let Some(manifest) = manifest() else {
            skip(NO_MANIFEST, "neither VK_DRIVER_FILES names one nor is lavapipe's at the usual place");
            return;
        };
        let folder = garden();
        let driver = folder.path().join("driver.json");
        std::fs::copy(manifest, &driver).unwrap();
        let variables = [
            ("DISPLAY", display.name.as_str()),
            ("PELLUCID_FAULT", "device-lost@show:60"),
            ("VK_DRIVER_FILES", driver.to_str().unwrap()),
        ];
        let arguments = ["view", "scene.toml", "--size", WINDOW];
        let mut window = Window::open_with(folder.path(), &variables, &arguments);
        window.wait_for("at rest");
        take(display);
        std::fs::remove_file(&driver).unwrap();
        // A frame of the window for each, until one of them is lost.
        let until = Instant::now() + Duration::from_secs(60);
        for x in (0..200).cycle() {
            display.do_it(&format!("mousemove {} 300", 420 + x));
            if window.process.try_wait().unwrap().is_some() || Instant::now() > until {
                break;
            }
        }
        let (status, said) = window.end();
        assert_eq!(status, Some(1), "{said}");
        let last = said.lines().last().unwrap();
        assert!(last.starts_with("error: ") && last.contains(" was lost during showing a picture"), "{said}");
        for part in ["can't be opened again: no Vulkan device", "`pellucid devices`", "--device", "`pellucid render`"] {
            assert!(last.contains(part), "{part}: {said}");
        }
        for part in ["leaked", "validation message", "panicked"] {
            assert!(!said.contains(part), "{said}");
        }
    });
}

#[test]
fn a_device_without_memory_is_a_message_and_the_window_goes_on() {
    with_display(|display| {
        // The renderer has its buffers by then: it is the points or the frame that lacks one.
        for nth in [20, 40] {
            let folder = garden();
            let mut window = open(folder.path(), display, &format!("out-of-memory@allocate:{nth}"));
            window.wait_for("out of device memory: ");
            let id = take(display);
            display.do_it("key t t");
            display.do_it(&format!("windowsize --sync {id} 700 400"));
            window.wait_for(" 370 × 400,");
            display.do_it("mousemove 690 395");
            assert_right(folder.path(), display, &mut window);
            assert_ends(display, window);
        }
    });
}
