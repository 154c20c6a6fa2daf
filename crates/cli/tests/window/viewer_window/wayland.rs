//! Wayland, by weston without a screen.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use pellucid_testing::skip::{NO_COMPOSITOR, skip};
use tempfile::TempDir;

use crate::viewer::garden::{garden, with_display};
use crate::viewer::window::Window;

struct Compositor {
    process: Child,
    folder: TempDir,
}

impl Compositor {
    /// `None` where weston is not installed.
    fn start() -> Option<Self> {
        // Not in the target folder: names of sockets are short.
        let folder = tempfile::tempdir().unwrap();
        let mut weston = Command::new("weston");
        weston.args(["--backend=headless-backend.so", "--socket=pellucid", "--use-pixman", "--idle-time=0"]);
        weston.args(["--width=1000", "--height=700"]).env("XDG_RUNTIME_DIR", folder.path()).env_remove("DISPLAY");
        let log = folder.path().join("log");
        let said = std::fs::File::create(&log).unwrap();
        let process = weston.stdout(said.try_clone().unwrap()).stderr(said).spawn().ok()?;
        let mut compositor = Self { process, folder };
        let until = Instant::now() + Duration::from_secs(20);
        while !compositor.folder.path().join("pellucid").exists() {
            let ended = compositor.process.try_wait().unwrap().is_some();
            let said = || std::fs::read_to_string(&log).unwrap_or_default();
            assert!(!ended && Instant::now() < until, "weston doesn't start: {}", said());
            std::thread::sleep(Duration::from_millis(20));
        }
        Some(compositor)
    }
}

impl Drop for Compositor {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn a_compositor_shows_the_window_and_its_end_ends_it() {
    // Only for whether there is a device that shows pictures.
    with_display(|_| {
        let Some(compositor) = Compositor::start() else {
            skip(NO_COMPOSITOR, "weston is not installed");
            return;
        };
        let folder = garden();
        let variables =
            [("WAYLAND_DISPLAY", "pellucid"), ("XDG_RUNTIME_DIR", compositor.folder.path().to_str().unwrap())];
        let mut window = Window::open_with(folder.path(), &variables, &["view", "scene.toml", "--size", "720x420"]);
        // Beside the panel.
        window.wait_for(" 390 × 420,");
        drop(compositor);
        let (status, said) = window.end();
        assert_eq!(status, Some(1), "{said}");
        assert!(said.contains("error: the display server closed the window"), "{said}");
        for part in ["validation", "leaked", "panicked"] {
            assert!(!said.contains(part), "{said}");
        }
    });
}
