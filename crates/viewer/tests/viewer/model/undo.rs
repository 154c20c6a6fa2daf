//! Undo and redo, and the way back to the scene that was opened.

use egui::{Context, Event, Key, Modifiers, PointerButton, Pos2, RawInput};

use super::*;
use pellucid_viewer::pointer;

fn opacity(model: &Model) -> f32 {
    model.scene().clouds[0].opacity
}

fn set_opacity(model: &mut Model, opacity: f64) {
    model.set("cloud.0.opacity", Setting::Number(opacity));
}

/// A frame with these events, in which something is done after the keys were handled.
fn frame(ctx: &Context, model: &mut Model, events: Vec<Event>, act: impl Fn(&mut Model)) {
    let _ = ctx.run(RawInput { events, ..RawInput::default() }, |ctx| {
        pointer::keys(ctx, model);
        act(model);
    });
}

fn button(pressed: bool) -> Event {
    Event::PointerButton { pos: Pos2::ZERO, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

fn press(ctx: &Context, model: &mut Model, key: Key, modifiers: Modifiers) {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    frame(ctx, model, vec![event(true), event(false)], |_| {});
}

#[test]
fn a_drag_of_a_slider_is_one_step() {
    let (mut model, _) = settled();
    let ctx = Context::default();
    let drag = |model: &mut Model, places: &[f64]| {
        frame(&ctx, model, vec![button(true)], |model| set_opacity(model, places[0]));
        places[1..].iter().for_each(|place| frame(&ctx, model, vec![], |model| set_opacity(model, *place)));
        // The last movement comes with the release.
        frame(&ctx, model, vec![button(false)], |model| set_opacity(model, 0.5 * places[0]));
        frame(&ctx, model, vec![], |_| {});
    };
    drag(&mut model, &[0.875, 0.75, 0.5]);
    drag(&mut model, &[0.25, 0.125]);
    let (control, shift) = (Modifiers::CTRL, Modifiers::CTRL | Modifiers::SHIFT);
    let keys = [(Key::Z, control, 0.4375), (Key::Z, control, 1.0), (Key::Z, control, 1.0)];
    let again = [(Key::Z, shift, 0.4375), (Key::Y, control, 0.125), (Key::Y, control, 0.125)];
    for (key, modifiers, wanted) in keys.into_iter().chain(again) {
        press(&ctx, &mut model, key, modifiers);
        assert_eq!(opacity(&model), wanted, "{key:?} {modifiers:?}");
    }
    assert_eq!(model.message, Some(("nothing to redo".into(), false)));
    // A change takes the place of what was undone.
    press(&ctx, &mut model, Key::Z, control);
    frame(&ctx, &mut model, vec![], |model| set_opacity(model, 0.75));
    press(&ctx, &mut model, Key::Y, control);
    assert_eq!(opacity(&model), 0.75);
    press(&ctx, &mut model, Key::Z, control);
    assert_eq!(opacity(&model), 0.4375);
}

#[test]
fn clicks_in_one_frame_each_are_steps_of_their_own() {
    let (mut model, _) = settled();
    let ctx = Context::default();
    for value in [0.5, 0.25] {
        frame(&ctx, &mut model, vec![button(true), button(false)], |model| set_opacity(model, value));
    }
    // Two keys in one drag, as if the pointer had let go.
    frame(&ctx, &mut model, vec![button(true)], |model| {
        set_opacity(model, 0.125);
        model.set("cloud.0.radius_factor", Setting::Number(2.0));
    });
    let mut undone = || {
        model.undo();
        (opacity(&model), model.scene().clouds[0].radius_factor)
    };
    assert_eq!([(); 4].map(|()| undone()), [(0.125, 1.0), (0.25, 1.0), (0.5, 1.0), (1.0, 1.0)]);
}

/// Every kind of change of the panel: the scene, its picture and what is saved are as before.
#[test]
fn every_change_of_the_scene_is_undone_and_done_again() {
    let (mut model, _) = settled();
    let text = |model: &Model| model.document_as_shown().unwrap().to_toml(Path::new("/scans")).unwrap();
    let changes: [fn(&mut Model); 6] = [
        |model| model.set_method("soft-express"),
        |model| model.set("cloud.*.field", Setting::Word("z".into())),
        |model| model.set("image.background", Setting::from([1.0, 0.5, 0.0])),
        |model| model.set_mean_opacity(0.25),
        |model| model.change(&[("shadows.method".into(), Some("texture".into()))]),
        |model| model.reset(&["cloud.0.opacity"]),
    ];
    let mut states = vec![text(&model)];
    for change in changes {
        model.end_step();
        change(&mut model);
        assert_eq!(model.message, None);
        states.push(text(&model));
    }
    // A change that is refused, and one that changes nothing, is no step.
    model.end_step();
    set_opacity(&mut model, 7.0);
    model.set("image.background", Setting::from([1.0, 0.5, 0.0]));
    for state in states.iter().rev().skip(1) {
        model.undo();
        assert_eq!(text(&model), *state);
        let request = asked(&mut model, Instant::now()).expect("a picture is due");
        assert_eq!(request.scene.clouds, model.scene().clouds);
    }
    model.undo();
    assert_eq!(model.message, Some(("nothing to undo".into(), false)));
    for state in &states[1..] {
        model.redo();
        assert_eq!(text(&model), *state);
    }
}

#[test]
fn the_camera_stays_and_the_path_is_undone() {
    let (mut model, _) = settled();
    model.add_key();
    model.end_step();
    model.navigate(|navigator| navigator.pan(DVec2::X, 48.0));
    model.add_key();
    model.end_step();
    set_opacity(&mut model, 0.5);
    model.end_step();
    model.navigate(|navigator| navigator.orbit(DVec2::new(5.0, 3.0), 48.0));
    model.edit_route(|route| route.set_rate(50));
    let (pose, keys) = (model.pose(), model.route.keys().to_vec());
    let state = |model: &Model| (model.route.rate(), opacity(model), model.route.keys().len());
    let mut undone = || {
        model.undo();
        state(&model)
    };
    assert_eq!([(); 4].map(|()| undone()), [(25, 0.5, 2), (25, 1.0, 2), (25, 1.0, 1), (25, 1.0, 0)]);
    (0..4).for_each(|_| model.redo());
    assert_eq!((state(&model), model.route.keys(), model.pose()), ((50, 0.5, 2), &keys[..], pose));
    // A turntable is one step, and other files begin anew.
    model.end_step();
    model.fill_turntable();
    assert_eq!(model.route.keys().len(), 16);
    model.undo();
    assert_eq!((model.route.keys(), model.route.pace()), (&keys[..], 2.0));
    opened(&mut model, "b.ply");
    model.undo();
    assert_eq!(model.message, Some(("nothing to undo".into(), false)));
}

/// A scene with values of its own, and the keys of one of its rows each.
const OPENED: &str = "
    [method]
    name = 'soft-base'
    threshold = 0.25
    modulation = 0.5
    [shading]
    model = 'lambert'
    ambient = 0.5
    light = [1, 2, -3]
    [shadows]
    [[cloud]]
    path = 'a.ply'
    opacity = 0.8
    radius_factor = 1.5
    color_by = 'height'
    range = [1, 2]
    [[cloud.class]]
    id = 6
    opacity = 0.1
    [[cloud]]
    path = 'b.ply'
    surface_opacity = 0.2
";

fn opened_model() -> Model {
    let document = Document::from_toml(OPENED, Path::new("/scans/s.toml"), &Overrides::default()).unwrap();
    Model::new("s.toml".into(), document, View::default(), 33.0).unwrap()
}

#[test]
fn resets_return_to_the_scene_that_was_opened() {
    let mut model = opened_model();
    let before = model.scene().clone();
    let same = |model: &Model| {
        let plain = |scene: &Scene| Scene { settings: String::new(), ..scene.clone() };
        plain(model.scene()) == plain(&before)
    };
    let number = |x: f64| Some(Setting::Number(x));
    type Changed<'a> = (&'a str, Option<Setting>);
    let rows: [(&[&str], &[Changed<'_>]); 6] = [
        (&["cloud.*.radius_factor"], &[("cloud.*.radius_factor", number(3.0))]),
        (&["cloud.0.color_by", "cloud.0.range"], &[("cloud.0.color_by", Some("z".into())), ("cloud.0.range", None)]),
        (&["shading.ambient"], &[("shading.ambient", None)]),
        (&["shading.light"], &[("shading.light", Some("headlight".into()))]),
        (&["cloud.1.neighbors"], &[("cloud.1.neighbors", Some(Setting::Integer(7)))]),
        (
            &["cloud.1.opacity", "cloud.1.surface_opacity"],
            &[("cloud.1.surface_opacity", None), ("cloud.1.opacity", number(0.5))],
        ),
    ];
    for (keys, changes) in rows {
        assert!(!keys.iter().any(|key| model.is_changed(key)), "{keys:?}: as opened");
        let changes: Vec<_> = changes.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        model.change(&changes);
        assert!(keys.iter().any(|key| model.is_changed(key)) && !same(&model), "{keys:?}");
        model.reset(keys);
        assert!(!keys.iter().any(|key| model.is_changed(key)) && same(&model), "{keys:?}: {:?}", model.scene());
    }
}

#[test]
fn the_mean_opacity_keeps_ratios_and_returns_to_the_opened_scene() {
    let mut model = opened_model();
    let values = |model: &Model| {
        let clouds = &model.scene().clouds;
        (clouds[0].opacity, clouds[1].surface_opacity, clouds[0].class[0].opacity)
    };
    // As a slider does that is dragged to its right end, to its left one and back.
    for (mean, wanted) in [
        (0.25, (0.4, Some(0.1), Some(0.05))),
        (1.0, (1.0, Some(1.0), Some(0.5))),
        (0.0, (0.0, Some(0.0), Some(0.0))),
        (0.5, (0.8, Some(0.2), Some(0.1))),
        (0.125, (0.2, Some(0.05), Some(0.025))),
    ] {
        model.set_mean_opacity(mean);
        assert_eq!(values(&model), wanted, "{mean}");
    }
    let keys = pellucid_viewer::controls::opacity_keys(&model.scene().clouds, &model.opened_scene().clouds);
    model.reset(&keys);
    assert_eq!(values(&model), (0.8, Some(0.2), Some(0.1)));
    assert!(!keys.iter().any(|key| model.is_changed(key)));
}

#[test]
fn keys_of_a_method_return_with_what_excludes_them() {
    let mut model = opened_model();
    model.change(&[
        ("method.modulation".into(), Some(Setting::Number(0.125))),
        ("method.threshold".into(), Some(Setting::Number(0.0625))),
    ]);
    model.reset_method("threshold");
    assert_eq!(model.message, None);
    let soft = |model: &Model| *model.scene().method.representative().soft().unwrap();
    assert_eq!((soft(&model).threshold, soft(&model).modulation), (0.25, Some(0.5)));
    // Of another method the opened scene says nothing: what is given is removed.
    model.set_method("sorted");
    assert!(!model.is_changed("method.shape"));
    model.set("method.shape", Setting::Word("oriented".into()));
    assert!(model.is_changed("method.shape"));
    model.reset_method("shape");
    assert!(!model.is_changed("method.shape") && !model.is_given("method.shape"));
}
