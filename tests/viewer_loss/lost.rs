//! A device that is lost, once and again, and one without memory.

use std::path::Path;

use pellucid::scene::{Overrides, Scene};

use crate::viewer::display::Display;
use crate::viewer::garden::{WINDOW, garden, rendered, shoot, wait_for_screen, with_display};
use crate::viewer::window::Window;

fn open(folder: &Path, display: &Display, fault: &str) -> Window {
    let variables = [("DISPLAY", display.name.as_str()), ("PELLUCID_FAULT", fault)];
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

/// In the first upload, in the middle of the first frame, in a frame of the window, and later, when something is saved.
#[test]
fn a_lost_device_is_opened_again_and_everything_goes_on() {
    with_display(|display| {
        for fault in ["device-lost@submit:1", "device-lost@wait:11", "device-lost@show:6"] {
            let folder = garden();
            let folder = folder.path();
            let mut window = open(folder, display, fault);
            window.wait_for("at rest");
            take(display);
            display.do_it("key t");
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

#[test]
fn a_device_without_memory_is_a_message_and_the_window_goes_on() {
    with_display(|display| {
        // The renderer has its buffers by then: it is the points or the frame that lacks one.
        for nth in [20, 40] {
            let folder = garden();
            let mut window = open(folder.path(), display, &format!("out-of-memory@allocate:{nth}"));
            window.wait_for("out of device memory: ");
            let id = take(display);
            display.do_it("key t");
            display.do_it(&format!("windowsize --sync {id} 700 400"));
            window.wait_for(" 370 × 400,");
            display.do_it("mousemove 690 395");
            assert_right(folder.path(), display, &mut window);
            assert_ends(display, window);
        }
    });
}
