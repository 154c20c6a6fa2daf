//! Files that another program drops onto the window.

use std::path::Path;

use pellucid_io::output::read_image;

use crate::viewer::garden::{WINDOW, garden, rendered, shoot, wait_for_screen, with_display};
use crate::viewer::window::{Window, command};
use crate::viewer::x11::Client;

/// Asserts that a saved picture is the one that `render` makes of these files.
#[track_caller]
fn assert_shows(folder: &Path, saved: &str, files: &[&str]) {
    let png = folder.join(format!("{saved}.png"));
    assert_eq!(std::fs::read(&png).unwrap(), rendered(folder, saved, &[]));
    let size = read_image(&png).unwrap();
    let size = format!("{}x{}", size.width, size.height);
    let output =
        command(folder).arg("render").args(files).args(["--size", &size, "-o", "wanted.png"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let (a, b) = (read_image(&png).unwrap(), read_image(&folder.join("wanted.png")).unwrap());
    assert!(a.pixels == b.pixels, "{saved} doesn't show {files:?}");
    assert!(a.pixels.iter().any(|pixel| *pixel != a.pixels[0]), "something is to be seen");
}

#[test]
fn dropped_files_are_opened() {
    with_display(|display| {
        let folder = garden();
        let folder = folder.path();
        let made =
            command(folder).args(["scene", "tori", "--set", "points=900", "-o", "other scenes"]).output().unwrap();
        assert!(made.status.success(), "{made:?}");
        let mut window = Window::open(folder, &display.name, &["view", "scene.toml", "--size", WINDOW]);
        window.wait_for("at rest");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        display.do_it("key t t");
        let client = Client::connect(&display.name);
        let drop_files = |files: &[&str]| {
            let paths: Vec<_> = files.iter().map(|file| folder.join(file)).collect();
            client.drop_files(id.parse().unwrap(), &paths.iter().map(|path| path.as_path()).collect::<Vec<_>>());
        };

        drop_files(&["other scenes/scene.toml"]);
        window.wait_for("scene.toml: opened");
        window.wait_for("at rest");
        let tori = shoot(display, &mut window);
        assert_shows(folder, &tori, &["other scenes/scene.toml"]);
        wait_for_screen(display, &folder.join(format!("{tori}.png")));

        // Two clouds at once, one of which has a name that must be escaped.
        std::fs::copy(folder.join("leaves.ply"), folder.join("grüne Blätter 1.ply")).unwrap();
        drop_files(&["ground.ply", "grüne Blätter 1.ply"]);
        let reading = window.wait_for("reading ");
        assert!(reading.contains("ground.ply, ") && reading.contains("grüne Blätter 1.ply"), "{reading}");
        window.wait_for(": opened");
        window.wait_for("at rest");
        assert!(display.do_it(&format!("getwindowname {id}")).contains("ground.ply"));
        let two = shoot(display, &mut window);
        assert_shows(folder, &two, &["ground.ply", "grüne Blätter 1.ply"]);

        // An unreadable file is reported, and the scene stays.
        std::fs::write(folder.join("torn.ply"), "ply\nformat ascii 1.0\nelement vertex 3\n").unwrap();
        drop_files(&["torn.ply"]);
        window.wait_for("reading ");
        let message = window.wait_for("torn.ply");
        assert!(!message.contains("opened"), "{message}");
        let still = shoot(display, &mut window);
        assert_shows(folder, &still, &["ground.ply", "grüne Blätter 1.ply"]);
        display.do_it("key ctrl+q");
        let (status, said) = window.end();
        assert_eq!(status, Some(0), "{said}");
    });
}
