//! A window manager that minimizes and maximizes: ctwm.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use pellucid_testing::skip::{NO_WINDOW_MANAGER, skip};

use crate::viewer::display::{Display, SIZE};
use crate::viewer::garden::{WINDOW, garden, rendered, shoot, shoot_from, wait_for_screen_at, with_display};
use crate::viewer::window::Window;
use crate::viewer::x11::Client;

/// Windows without anything around them.
const SETTINGS: &str = "DontShowWelcomeWindow\nNoTitle\nBorderWidth 0\nThreeDBorderWidth 0\nUsePPosition \"on\"\n";

struct Manager(Child);

impl Manager {
    fn start(display: &Display, folder: &Path) -> Option<Self> {
        std::fs::write(folder.join("ctwmrc"), SETTINGS).unwrap();
        let mut manager = Command::new("ctwm");
        manager.args(["-f", "ctwmrc"]).current_dir(folder).env("DISPLAY", &display.name).env_remove("SESSION_MANAGER");
        let started = manager.stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok().map(Self);
        if started.is_none() {
            skip(NO_WINDOW_MANAGER, "ctwm is not installed");
        }
        started
    }
}

impl Drop for Manager {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[track_caller]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_secs(60);
    while !is_so() {
        assert!(Instant::now() < until, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_window_that_is_minimized_maximized_and_full_screen_shows_what_it_should() {
    with_display(|display| {
        let folder = garden();
        let folder = folder.path();
        let Some(_manager) = Manager::start(display, folder) else { return };
        let client = Client::connect(&display.name);
        let mut window = Window::open(folder, &display.name, &["view", "scene.toml", "--size", WINDOW]);
        window.wait_for("at rest");
        let name = display.do_it("search --sync --onlyvisible --name pellucid");
        let id: u32 = name.parse().unwrap();
        display.do_it(&format!("windowfocus --sync {name}"));
        display.do_it("key t t");
        let first = shoot(display, &mut window);
        let picture = |name: &str| folder.join(format!("{name}.png"));
        let wait_for_screen = |picture: &Path| wait_for_screen_at(display, picture, client.position(id));
        wait_for_screen(&picture(&first));

        // Files opened in the meantime are read, but nothing is rendered before the window is visible.
        display.do_it(&format!("windowminimize {name}"));
        wait_until("minimized", || !client.is_mapped(id));
        client.drop_files(id, &[&folder.join("ground.ply")]);
        window.wait_for("hidden: pictures wait");
        std::thread::sleep(Duration::from_millis(700));
        let said = window.lines.0.lock().unwrap().clone();
        let hidden = said.iter().position(|line| line.contains("hidden: pictures wait")).unwrap();
        assert!(!said[hidden..].iter().any(|line| line.contains("at rest")), "{said:#?}");
        display.do_it(&format!("windowmap --sync {name}"));
        window.wait_for("no picture waits any more");
        window.wait_for("at rest");
        display.do_it(&format!("windowfocus --sync {name}"));
        let ground = shoot(display, &mut window);
        assert_eq!(std::fs::read(picture(&ground)).unwrap(), rendered(folder, &ground, &[]));
        wait_for_screen(&picture(&ground));

        // The panel is 330 wide.
        let all = [SIZE[0] as u16, SIZE[1] as u16];
        let rest = format!(" {} × {},", SIZE[0] - 330, SIZE[1]);
        for way in ["maximized", "full"] {
            let toggle = |on| match way {
                "full" => drop(display.do_it("key F11")),
                _ => client.maximize(id, on),
            };
            toggle(true);
            window.wait_for(&rest);
            wait_until(way, || client.size(id) == all);
            let large = shoot_from(display, &mut window, [SIZE[0] - 5, SIZE[1] - 5]);
            assert_eq!(std::fs::read(picture(&large)).unwrap(), rendered(folder, &large, &[]), "{way}");
            wait_for_screen(&picture(&large));
            toggle(false);
            window.wait_for(" 390 × 420,");
            // The keys go where the pointer is.
            display.do_it("mousemove 300 300");
            display.do_it(&format!("windowfocus --sync {name}"));
        }
        display.do_it("key ctrl+q");
        let (status, said) = window.end();
        assert_eq!(status, Some(0), "{said}");
        assert!(!said.contains("leaked") && !said.contains("error") && !said.contains("panicked"), "{said}");
    });
}
