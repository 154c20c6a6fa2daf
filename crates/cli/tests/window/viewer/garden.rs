//! A small scene in a window, and whether its pictures are right.

use std::path::Path;
use std::time::{Duration, Instant};

use pellucid_gpu::{Device, DeviceOptions};
use pellucid_io::output::read_image;
use pellucid_testing::skip::{NO_DEVICE, NO_DISPLAY, NO_PRESENTING, skip};

use super::display::{Display, SIZE};
use super::window::{Window, command};

/// The window in most tests.
pub const WINDOW: &str = "720x420";

/// Runs a test on a display, if there is one and a device that shows pictures there.
pub fn with_display(test: impl FnOnce(&Display)) {
    match Display::start() {
        Some(display) if shows_windows(&display) => test(&display),
        Some(_) => {}
        None => skip(NO_DISPLAY, "Xvfb or xdotool is not installed"),
    }
}

/// A small garden as files, and the folder that they are in.
pub fn garden() -> tempfile::TempDir {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let output = command(folder.path()).args(["scene", "garden", "--set", "points=12000", "-o", "."]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    folder
}

/// Presses F12 and waits for the files: their common name. The pointer goes to the window's corner, lest it be seen in
/// the picture, or a control's hint.
pub fn shoot(display: &Display, window: &mut Window) -> String {
    shoot_from(display, window, [715, 415])
}

/// Saves a picture like [`shoot`], in a window of another size, with the pointer's place.
pub fn shoot_from(display: &Display, window: &mut Window, [x, y]: [usize; 2]) -> String {
    display.do_it(&format!("mousemove {x} {y}"));
    display.do_it("key F12");
    let line = window.wait_for("saved ");
    line.split_once("saved ").unwrap().1.split(".toml").next().unwrap().to_owned()
}

/// Waits until the screen shows a picture at its left upper corner.
#[track_caller]
pub fn wait_for_screen(display: &Display, picture: &Path) {
    wait_for_screen_at(display, picture, [0, 0]);
}

/// Waits until the screen shows a picture at a place.
#[track_caller]
pub fn wait_for_screen_at(display: &Display, picture: &Path, at: [usize; 2]) {
    let until = Instant::now() + Duration::from_secs(60);
    loop {
        let differing = not_on_screen(display, picture, at);
        if differing == 0 {
            return;
        }
        assert!(Instant::now() < until, "{differing} pixels of {} are shown otherwise", picture.display());
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Renders a saved scene with further options; the bytes of the picture.
pub fn rendered(folder: &Path, name: &str, options: &[&str]) -> Vec<u8> {
    let scene = format!("{name}.toml");
    let output = command(folder).args(["render", &scene, "-o", "again.png"]).args(options).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    std::fs::read(folder.join("again.png")).unwrap()
}

/// Pixels of the picture that the screen shows otherwise, the picture being at a place of the screen.
fn not_on_screen(display: &Display, picture: &Path, [left, top]: [usize; 2]) -> usize {
    let image = read_image(picture).unwrap();
    let byte = |x: f32| (255.0 * pellucid_core::color::encode_srgb(x) + 0.5).floor() as u8;
    let (screen, width) = (display.pixels(), image.width as usize);
    let shown = |i: usize| screen[(top + i / width) * SIZE[0] + left + i % width];
    image.pixels.iter().enumerate().filter(|(i, pixel)| pixel.map(byte) != shown(*i)).count()
}

/// SwiftShader, as browsers have it, shows nothing in X11's windows: that is said. Without any device there is nothing
/// to test.
fn shows_windows(display: &Display) -> bool {
    match Device::open(&DeviceOptions { validation: true, ..DeviceOptions::default() }) {
        Ok(device) if device.info().name.contains("SwiftShader") => {
            let folder = garden();
            let view =
                command(folder.path()).env("DISPLAY", &display.name).args(["view", "scene.toml"]).output().unwrap();
            let said = String::from_utf8(view.stderr).unwrap();
            assert_eq!(view.status.code(), Some(1), "{said}");
            assert!(said.starts_with("error: can't show pictures in a window: "), "{said}");
            assert!(said.contains("`pellucid render`"), "{said}");
            skip(NO_PRESENTING, &device.info().name);
            false
        }
        Ok(_) => true,
        Err(error) => {
            skip(NO_DEVICE, &error.to_string());
            false
        }
    }
}
