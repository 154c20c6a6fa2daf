//! A window that is closed, and a process that gets a signal, while a long frame is rendered.

use std::os::unix::process::ExitStatusExt;
use std::process::Command;

use crate::viewer::garden::{WINDOW, garden, with_display};
use crate::viewer::window::Window;

/// Takes long at rest.
const LONG: [&str; 8] = ["view", "scene.toml", "--size", WINDOW, "--method", "spbr", "--set", "method.ensembles=1000"];

#[test]
fn a_window_that_is_closed_in_the_middle_of_a_frame_says_nothing() {
    with_display(|display| {
        let folder = garden();
        let before = std::fs::read_dir(folder.path()).unwrap().count();
        let mut window = Window::open(folder.path(), &display.name, &LONG);
        window.wait_for("control ");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        display.do_it("key ctrl+q");
        let (status, said) = window.end();
        assert_eq!(status, Some(0), "{said}");
        for part in ["error", "lost", "leaked", "validation", "panicked", "at rest"] {
            assert!(!said.contains(part), "{part}: {said}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before);
    });
}

#[test]
fn signals_end_the_window_and_leave_nothing_behind() {
    with_display(|display| {
        for (name, number) in [("INT", 2), ("TERM", 15)] {
            let folder = garden();
            let before = std::fs::read_dir(folder.path()).unwrap().count();
            let mut window = Window::open(folder.path(), &display.name, &LONG);
            window.wait_for("control ");
            let pid = window.process.id().to_string();
            assert!(Command::new("kill").args([format!("-{name}"), pid]).status().unwrap().success());
            let status = window.process.wait().unwrap();
            assert_eq!(status.signal(), Some(number));
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before);
        }
    });
}
