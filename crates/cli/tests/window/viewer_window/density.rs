//! Screens of high density: winit takes the scale from WINIT_X11_SCALE_FACTOR.

use pellucid_io::output::read_image;
use pellucid_scene::{Overrides, Scene};

use crate::viewer::garden::{garden, rendered, shoot_from, wait_for_screen, with_display};
use crate::viewer::window::Window;

/// Width of the panel in points.
const PANEL: u32 = 330;

#[test]
fn pictures_have_the_screens_pixels_and_controls_are_where_they_say() {
    with_display(|display| {
        let folder = garden();
        let folder = folder.path();
        // Such that 1.5 makes whole pixels of all that is asked for.
        for (factor, [width, height], twice) in [("2", [480, 300], 4), ("1.5", [600, 400], 3)] {
            let size = format!("{width}x{height}");
            let variables = [("DISPLAY", display.name.as_str()), ("WINIT_X11_SCALE_FACTOR", factor)];
            let mut window = Window::open_with(folder, &variables, &["view", "scene.toml", "--size", &size]);
            let expected = [(width - PANEL) * twice / 2, height * twice / 2];
            window.wait_for(&format!(" {} × {},", expected[0], expected[1]));
            let id = display.do_it("search --sync --onlyvisible --name pellucid");
            display.do_it(&format!("windowfocus --sync {id}"));
            display.do_it("key t t");

            let [left, top, _, high] = window.control("cloud.1.opacity");
            let y = top + high / 2;
            display.drag(1, [left + 60, y], [left - 60, y]);
            window.wait_for("at rest");
            let first = shoot_from(display, &mut window, [955, 595]);
            let png = folder.join(format!("{first}.png"));
            let picture = read_image(&png).unwrap();
            assert_eq!([picture.width, picture.height], expected, "{factor}");
            assert_eq!(std::fs::read(&png).unwrap(), rendered(folder, &first, &[]));
            wait_for_screen(display, &png);
            let scene = |name: &str| Scene::read(&folder.join(format!("{name}.toml")), &Overrides::default()).unwrap();
            assert_eq!(scene(&first).clouds[1].opacity, 0.0, "{factor}");

            // A quarter of the picture's height is 45 degrees, whatever the density.
            let quarter = expected[1] as i32 / 4;
            display.drag(1, [40, 200], [40 + quarter, 200]);
            window.wait_for("at rest");
            let second = shoot_from(display, &mut window, [955, 595]);
            let along = |name: &str| (scene(name).camera.target.unwrap() - scene(name).camera.eye.unwrap()).with_z(0.0);
            let angle = along(&first).angle_between(along(&second)).to_degrees();
            assert!((angle - 45.0).abs() < 1e-6, "{factor}: {angle}");
            display.do_it("key ctrl+q");
            let (status, said) = window.end();
            assert_eq!(status, Some(0), "{said}");
        }
    });
}
