//! The keys of views by a real keyboard: each shows the picture of `render --view`.

use super::garden::{WINDOW, garden, wait_for_screen, with_display};
use super::window::{Window, command};

/// The picture in a window of [`WINDOW`]: what the panel leaves.
const PICTURE: &str = "390x420";

#[test]
fn the_keys_of_views_show_what_render_shows_with_its_view() {
    with_display(|display| {
        let folder = garden();
        let folder = folder.path();
        // The vertical of an option, and that of the scene.
        for (input, options) in [("leaves.ply", &["--method", "sorted", "--up", "y"][..]), ("scene.toml", &[])] {
            let view = [&["view", input, "--size", WINDOW], options].concat();
            let mut window = Window::open(folder, &display.name, &view);
            window.wait_for("at rest");
            let id = display.do_it("search --sync --onlyvisible --name pellucid");
            display.do_it(&format!("windowfocus --sync {id}"));
            // Without the times over it the picture is there alone.
            display.do_it("key t t");
            display.do_it("mousemove 715 415");
            for (key, name) in ["front", "back", "left", "right", "top", "bottom", "iso"].iter().enumerate() {
                let file = format!("{name}.png");
                let render = ["render", input, "--view", name, "--size", PICTURE, "-o", &file];
                let output = command(folder).args(render).args(options).output().unwrap();
                assert!(output.status.success(), "{output:?}");
                display.do_it(&format!("key {}", key + 1));
                wait_for_screen(display, &folder.join(file));
            }
            display.do_it("key ctrl+q");
            let (status, said) = window.end();
            assert_eq!(status, Some(0), "{said}");
        }
    });
}
