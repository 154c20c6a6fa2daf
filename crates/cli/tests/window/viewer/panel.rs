//! The panel by a real pointer: what is clicked and dragged there is in the scene that is saved.

use std::path::Path;

use pellucid_core::cloud::field::Field;
use pellucid_scene::{ClassSettings, Clip, ClipShape, Density, Method, Scene, Selection, Shadows, Shells, Soft};

use super::display::Display;
use super::garden::{garden, rendered, shoot, with_display};
use super::scene;
use super::window::Window;

/// High enough for every control that is used here.
const WINDOW: &str = "900x690";

/// A window on a scene file with this text, and the scene that it saves after a few deeds.
struct Desk<'a> {
    display: &'a Display,
    window: Window,
    folder: &'a Path,
}

impl<'a> Desk<'a> {
    fn open(display: &'a Display, folder: &'a Path, text: &str) -> Self {
        std::fs::write(folder.join("desk.toml"), text).unwrap();
        let mut window = Window::open(folder, &display.name, &["view", "desk.toml", "--size", WINDOW]);
        window.wait_for("at rest");
        let id = display.do_it("search --sync --onlyvisible --name pellucid");
        display.do_it(&format!("windowfocus --sync {id}"));
        Self { display, window, folder }
    }

    /// Clicks a control, which changes the picture.
    fn click(&mut self, key: &str) {
        let [left, top, width, height] = self.window.control(key);
        self.display.do_it(&format!("mousemove {} {}", left + width.min(height) / 2, top + height / 2));
        self.display.do_it("click 1");
        self.window.wait_for("at rest");
    }

    /// Drags a slider from one place to another, in pixels from its left end.
    fn drag(&mut self, key: &str, from: i32, to: i32) {
        let [left, top, _, height] = self.window.control(key);
        let y = top + height / 2;
        self.display.drag(1, [left + from, y], [left + to, y]);
        self.window.wait_for("at rest");
    }

    /// Unfolds or folds a section, which leaves the picture.
    fn fold(&mut self, title: &str, shows: &str) {
        let [left, top, _, height] = self.window.control(&format!("section {title}"));
        self.display.do_it(&format!("mousemove {} {}", left + height / 2, top + height / 2));
        self.display.do_it("click 1");
        self.window.wait_for(&format!("control {shows} at"));
    }

    /// The scene that is saved now. Its picture is that of `render`, byte for byte.
    #[track_caller]
    fn saved(&mut self) -> Scene {
        let name = shoot(self.display, &mut self.window);
        let picture = std::fs::read(self.folder.join(format!("{name}.png"))).unwrap();
        assert!(picture == rendered(self.folder, &name, &[]), "{name}: another picture than that of its scene");
        scene(self.folder, &name)
    }
}

/// The threshold, density and classes of soft points.
#[test]
fn soft_points_are_chosen_in_the_panel() {
    with_display(|display| {
        let folder = garden();
        let text = "[method]\nname = 'soft-concentric'\nthreshold = 0.25\n[[cloud]]\npath = 'leaves.ply'\n\
            field = 'classification'\nsoft_classes = [3]\n";
        let mut desk = Desk::open(display, folder.path(), text);
        let soft = |scene: &Scene| *scene.method.fixed().and_then(Method::soft).unwrap();
        let before = soft(&desk.saved());
        assert_eq!(before, Soft { threshold: 0.25, ..Soft::default() });

        desk.click("cloud.0.soft_classes.5");
        desk.click("method.lambda?");
        desk.click("method.modulation?");
        desk.click("method.shells?");
        // Far to the right, where the modulation stops it.
        desk.drag("method.threshold", 30, 300);
        let scene = desk.saved();
        let after = soft(&scene);
        assert!(matches!(after.density, Density::Lambda(lambda) if lambda > 0.0), "{after:?}");
        assert_eq!((after.threshold, after.modulation, after.shells), (0.624, Some(0.625), Shells::Fixed(8)));
        assert_eq!(scene.clouds[0].field, Some(Field::Classification { classes: vec![3, 5] }));

        // Of the same points, since a lambda is another softness for points of another radius.
        desk.click("method.softness?");
        desk.click("cloud.0.soft_classes.5");
        desk.click("method.modulation?");
        desk.click("method.shells?");
        let scene = desk.saved();
        let Soft { density, modulation, shells, .. } = soft(&scene);
        // The slider of the one began where the other one was, to its step.
        assert!(matches!(density, Density::Softness(softness) if (softness - 0.5).abs() < 2e-3), "{density:?}");
        assert_eq!((modulation, shells), (None, Shells::Adaptive));
        assert_eq!(scene.clouds[0].field, Some(Field::Classification { classes: vec![3] }));
    });
}

/// A field that is reset or undone gives the result that it had, whatever was computed for the points in between.
#[test]
fn a_field_returns_to_that_of_the_opened_scene() {
    with_display(|display| {
        let folder = garden();
        let text = "[method]\nname = 'soft-express'\nthreshold = 0.1\n[[cloud]]\npath = 'leaves.ply'\n\
            field = 'classification'\nsoft_classes = [3]\nneighbors = 5\n";
        let mut desk = Desk::open(display, folder.path(), text);
        let of_classes = |classes: &[u8]| Some(Field::Classification { classes: classes.to_vec() });
        desk.click("cloud.0.soft_classes.5");
        assert_eq!(desk.saved().clouds[0].field, of_classes(&[3, 5]));
        desk.click("cloud.0.field default");
        assert_eq!(desk.saved().clouds[0].field, of_classes(&[3]));
        for (key, classes) in [("ctrl+z", &[3, 5][..]), ("ctrl+z", &[3]), ("ctrl+shift+z", &[3, 5]), ("ctrl+y", &[3])] {
            display.do_it(&format!("key {key}"));
            desk.window.wait_for("at rest");
            assert_eq!(desk.saved().clouds[0].field, of_classes(classes), "{key}");
        }
        // The cloud's name unfolds it, however slowly it is clicked: frames may take long between pressing and letting
        // go.
        let [left, top, width, height] = desk.window.control("cloud.0");
        display.do_it(&format!("mousemove {} {}", left + width / 2, top + height / 2));
        display.do_it("mousedown 1");
        std::thread::sleep(std::time::Duration::from_secs(1));
        display.do_it("mouseup 1");
        desk.window.wait_for("control cloud.0.neighbors?");
        desk.click("cloud.0.neighbors?");
        assert_eq!(desk.saved().clouds[0].neighbors, None);
        desk.click("cloud.0.neighbors?");
        assert_eq!(desk.saved().clouds[0].neighbors, Some(5), "as it was opened");
    });
}

/// A light that turns, and shadows that come and go.
#[test]
fn light_and_shadows_are_set_in_the_panel() {
    with_display(|display| {
        let folder = garden();
        let text = "[method]\nname = 'circles'\n[shading]\nmodel = 'phong'\nlight = [0.5, 0.5, -1.0]\n[shadows]\n\
            [[cloud]]\npath = 'structure.ply'\n";
        let mut desk = Desk::open(display, folder.path(), text);
        let before = desk.saved();
        assert_eq!(before.shadows, Some(Shadows::default()));
        desk.drag("shading.light.elevation", 90, 60);
        desk.drag("shading.specular", 6, 80);
        desk.drag("shadows.light_radius", 6, 60);
        let after = desk.saved();
        let Some(shadows) = after.shadows else { panic!("{:?}", after.warnings) };
        assert!(shadows.light_radius > 10.0 && after.shading.specular > 0.5, "{shadows:?} {:?}", after.shading);
        assert_ne!(after.shading.light, before.shading.light);
        desk.click("shadows.method");
        assert_eq!(desk.saved().shadows, None);
        desk.click("shadows.method");
        assert_eq!(desk.saved().shadows, Some(shadows));
    });
}

/// A box whose face is dragged in the picture, and a class that is hidden and shown again.
#[test]
fn the_scene_is_cut_in_the_picture_and_by_classes() {
    with_display(|display| {
        let folder = garden();
        let text = "[method]\nname = 'sorted'\n[[cloud]]\npath = 'leaves.ply'\nopacity = 0.5\n";
        let mut desk = Desk::open(display, folder.path(), text);
        desk.fold("Clips", "clip.box+");
        desk.click("clip.box+");
        let ends = |scene: &Scene| match &scene.clips[..] {
            [Clip { shape: ClipShape::Box { min, max }, invert: false }] => [*min, *max],
            clips => panic!("{clips:?}"),
        };
        let [min, max] = ends(&desk.saved());
        // Toward the middle of the box.
        let middle = |name: &str| {
            let [left, top, width, height] = desk.window.control(name);
            [left + width / 2, top + height / 2]
        };
        let ([low, high], [x, y]) = ([middle("clip.0.-x"), middle("clip.0.+x")], middle("clip.0.+x"));
        display.drag(1, [x, y], [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2]);
        desk.window.wait_for("at rest");
        let [least, most] = ends(&desk.saved());
        assert_eq!((least, most.with_x(max.x)), (min, max), "the other faces stay");
        let share = (most.x - min.x) / (max.x - min.x);
        assert!((0.3..0.7).contains(&share), "{share}");
        desk.click("clip.0-");
        assert_eq!(desk.saved().clips, []);

        desk.fold("Classes", "cloud.0.class.5.visible");
        desk.click("cloud.0.class.5.visible");
        let hidden = ClassSettings {
            points: Selection::Class(5),
            opacity: None,
            color: None,
            radius: None,
            visible: Some(false),
        };
        assert_eq!(desk.saved().clouds[0].class, [hidden]);
        desk.click("cloud.0.class.5.visible");
        assert_eq!(desk.saved().clouds[0].class, []);
    });
}
