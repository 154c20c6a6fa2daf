//! Tests that the window's views have the vertical of the scene, as those of `render --view` do.

use super::*;
use pellucid_core::cloud::UpAxis;
use pellucid_scene::{Vertical, View, ViewName, procedural};

const SIZE: &str = "[image]\nsize = [40, 30]\n";

/// Clouds, a scene of them, and the vertical that it has.
type Case = (&'static str, Vec<Cloud>, Document, DVec3);

/// The built-in garden, whose clouds say nothing of a vertical but its scene does.
fn garden() -> Case {
    let generated = procedural::build("garden", &[("points".into(), 3000.0)], SEED).unwrap();
    let document = Document::from_toml(&generated.scene_toml, Path::new("garden"), &Overrides::default()).unwrap();
    ("the garden", generated.clouds.into_iter().map(|(_, cloud)| cloud).collect(), document, DVec3::Z)
}

fn of_cloud(name: &'static str, up: UpAxis, camera: &str, vertical: DVec3) -> Case {
    let text =
        format!("{SIZE}[method]\nname = 'sorted'\n[camera]\n{camera}\n[[cloud]]\npath = 'a.ply'\nradius = 0.05\n");
    let document = Document::from_toml(&text, Path::new("/scans/s.toml"), &Overrides::default()).unwrap();
    (name, vec![Cloud { up, ..cloud(3, 400) }], document, vertical)
}

fn cases() -> Vec<Case> {
    let eye = "eye = [3, 4, 5]\ntarget = [0, 0, 0]\n";
    vec![
        garden(),
        of_cloud("--up y", UpAxis::Z, "up = [0, 1, 0]", DVec3::Y),
        of_cloud("--up -x", UpAxis::Z, "up = [-1, 0, 0]", DVec3::NEG_X),
        of_cloud("a tilted up", UpAxis::Y, &format!("{eye}up = [0.3, -0.2, -1]"), DVec3::NEG_Z),
        of_cloud("an up between two axes", UpAxis::Y, &format!("{eye}up = [0, 1, 1]"), DVec3::Y),
        of_cloud("a file of a depth camera", UpAxis::NegativeY, "", DVec3::NEG_Y),
        of_cloud("a survey", UpAxis::Z, "", DVec3::Z),
    ]
}

/// The direction of each key's view and what is at the top of its picture, by the names of the views.
fn wanted(name: ViewName, vertical: Vertical) -> [DVec3; 2] {
    let (up, front, right) = (vertical.up(), vertical.front(), vertical.right());
    match name {
        ViewName::Front => [-front, up],
        ViewName::Back => [front, up],
        ViewName::Left => [right, up],
        ViewName::Right => [-right, up],
        ViewName::Top => [-up, -front],
        ViewName::Bottom => [up, front],
        _ => {
            let forward = -(front + right + up).normalize();
            [forward, (up - up.dot(forward) * forward).normalize()]
        }
    }
}

#[test]
fn keys_show_the_pictures_of_render_with_the_vertical_of_the_scene() {
    with_device(|device| {
        for (what, clouds, document, up) in cases() {
            let vertical = Vertical::nearest(up).unwrap();
            let mut scene = document.scene().unwrap();
            scene.image.size = [40, 30];
            let mut live = stage(device, clouds.clone());
            for (name, word, _) in &ViewName::ALL[..7] {
                let view = View { name: Some(*name), ..View::default() };
                let shown = live.take(&scene, Pose::View(view), Effort::Whole).unwrap();
                let camera = shown.frame.camera;
                let [forward, image_up] = wanted(*name, vertical);
                let off = (camera.forward - forward).length() + (camera.up - image_up).length();
                assert!(off < 1e-12, "{what}, {word}: {camera:?}");
                // As the option has it.
                let mut by_option = scene.clone();
                by_option.camera.view = view;
                let rendered = stage(device, clouds.clone()).take(&by_option, Pose::Scene, Effort::Whole).unwrap();
                assert_eq!(camera, rendered.frame.camera, "{what}, {word}");
                assert_same(&shown, &rendered, &format!("{what}, {word}"));
                assert!(shown.rendered.image.depth.iter().any(|depth| depth.is_finite()), "{what}, {word}: empty");
            }
            let home = live.take(&scene, Pose::View(View::default()), Effort::Whole).unwrap().frame.camera;
            let levels = [home.right.dot(up), home.up.dot(up), home.forward.dot(up)];
            assert!(levels[0].abs() < 1e-12 && levels[1] > 0.5 && levels[2] < -0.1, "{what}, Home: {home:?}");
        }
    });
}
