//! Key frames that are made in the window of `pellucid view`, on a display without a screen: what is saved there is
//! what `render --path` makes frames of.

use std::path::Path;
use std::time::Duration;

use crate::viewer::display::Display;
use crate::viewer::garden::with_display;
use crate::viewer::window::{Window, command};
use pellucid_core::camera::path::CameraPath;
use pellucid_io::output::read_image;

/// The window, high enough for the panel to show the path.
const WINDOW: &str = "720x890";

/// Presses keys; the pointer is over the panel, lest it be seen in the picture.
fn press(display: &Display, keys: &str) {
    display.do_it("mousemove 715 685");
    display.do_it(&format!("key {keys}"));
}

/// Presses F12; the bytes of the picture that is written.
fn shoot(display: &Display, window: &mut Window, folder: &Path) -> Vec<u8> {
    press(display, "F12");
    let line = window.wait_for("saved ");
    let name = line.split_once("saved ").unwrap().1.split(".toml").next().unwrap();
    std::fs::read(folder.join(format!("{name}.png"))).unwrap()
}

/// Opens a dialog, types into it key by key, as fast as a hand, and waits for what the window then says. A dialog that
/// a busy machine draws more slowly than that misses what was typed, and is opened again.
#[track_caller]
fn choose(display: &Display, window: &mut Window, opened: &str, told: &[&str], said: &str) {
    for _ in 0..4 {
        press(display, opened);
        for told in told.iter().chain(&["key Return"]) {
            std::thread::sleep(Duration::from_millis(400));
            display.do_it(told);
        }
        if window.hear_within(said, Duration::from_secs(20)).is_some() {
            return;
        }
        display.do_it("key Escape");
        std::thread::sleep(Duration::from_secs(1));
    }
    panic!("no {said:?} in {:#?}", window.lines.0.lock().unwrap());
}

/// Clicks what was said to be somewhere.
fn click(display: &Display, window: &Window, control: &str) {
    let [left, top, width, height] = window.control(control);
    display.do_it(&format!("mousemove {} {}", left + width / 2, top + height / 2));
    display.do_it("click 1");
}

/// The pixels of a picture.
fn pixels(bytes: &[u8]) -> Vec<[u32; 3]> {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let file = folder.path().join("a.png");
    std::fs::write(&file, bytes).unwrap();
    read_image(&file).unwrap().pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Three places to which drags lead are keys; the film of the file that is saved begins and ends with the pictures that
/// were saved there, and has the one between them in its middle.
#[test]
fn a_path_from_the_window_is_the_path_of_render() {
    with_display(record);
}

fn record(display: &Display) {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let folder = folder.path();
    let made = command(folder).args(["scene", "garden", "--set", "points=6000", "-o", "."]).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    let arguments = ["view", "scene.toml", "--method", "sorted", "--size", WINDOW];
    let mut window = Window::open(folder, &display.name, &arguments);
    window.wait_for("at rest");
    let id = display.do_it("search --sync --onlyvisible --name pellucid");
    display.do_it(&format!("windowfocus --sync {id}"));
    press(display, "t t");

    let mut pictures = Vec::new();
    for (key, drag) in [(1, None), (2, Some((1, [170, 390]))), (3, Some((3, [120, 330])))] {
        if let Some((button, to)) = drag {
            display.drag(button, [100, 350], to);
            window.wait_for("at rest");
        }
        press(display, "k");
        window.wait_for(&format!("control path.key.{key} at"));
        pictures.push(shoot(display, &mut window, folder));
    }
    let apart = |a: usize, b: usize| pixels(&pictures[a]) != pixels(&pictures[b]);
    assert!(apart(0, 1) && apart(1, 2) && apart(0, 2), "each drag leads somewhere else");

    press(display, "ctrl+k");
    let said = window.wait_for("saved scene-path-1.toml and scene-path-1.json");
    assert!(said.contains("pellucid render scene-path-1.toml --path scene-path-1.json --frames 101 -o"), "{said}");
    let text = std::fs::read_to_string(folder.join("scene-path-1.json")).unwrap();
    let path = CameraPath::from_json(&text, Path::new("scene-path-1.json")).unwrap();
    assert_eq!((path.keys.len(), path.closed), (3, false));
    let film = ["render", "scene-path-1.toml", "--path", "scene-path-1.json", "--frames", "5", "-o", "f_%d.png"];
    let rendered = command(folder).args(film).output().unwrap();
    assert!(rendered.status.success(), "{rendered:?}");
    let frame = |i: usize| pixels(&std::fs::read(folder.join(format!("f_{i}.png"))).unwrap());
    for (number, picture) in [0, 2, 4].into_iter().zip(&pictures) {
        assert!(frame(number) == pixels(picture), "frame {number} is another picture");
    }
    assert!(frame(1) != frame(0) && frame(1) != frame(2), "the camera moves between keys");

    // From the last key to the first by a click, to the last again by the path, which runs there by itself.
    click(display, &window, "path.key.1");
    window.wait_for("at rest");
    assert!(pixels(&shoot(display, &mut window, folder)) == frame(0), "a key leads back to its picture");
    press(display, "space");
    window.wait_for("at rest");
    assert!(pixels(&shoot(display, &mut window, folder)) == frame(4), "the path ends at its last key");

    // The same keys from the file, and what is none.
    display.do_it("key ctrl+q");
    let (status, said) = window.end();
    assert_eq!(status, Some(0), "{said}");
    let again = ["view", "scene-path-1.toml", "--path", "scene-path-1.json", "--size", WINDOW];
    let mut window = Window::open(folder, &display.name, &again);
    window.wait_for("scene-path-1.json: 3 keys");
    window.wait_for("at rest");
    let id = display.do_it("search --sync --onlyvisible --name pellucid");
    display.do_it(&format!("windowfocus --sync {id}"));
    assert!(pixels(&shoot(display, &mut window, folder)) == frame(0), "it begins at the first key");

    // By the dialog: the scene under another name, and the one of a picture again.
    choose(display, &mut window, "ctrl+shift+s", &["key ctrl+a", "type kept.toml"], "saved kept.toml");
    choose(display, &mut window, "ctrl+o", &["type scene-2.t", "key Down"], "scene-2.toml: opened");
    window.wait_for("at rest");
    assert!(pixels(&shoot(display, &mut window, folder)) == frame(2), "a saved scene is the same again");
    choose(display, &mut window, "ctrl+o", &["type kept.t", "key Down"], "kept.toml: opened");
    window.wait_for("at rest");
    assert!(pixels(&shoot(display, &mut window, folder)) == frame(0), "as it was kept");
}
