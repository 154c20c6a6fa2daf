//! The whole panel, laid out without a window: everything has room, and no text is meant for a reference.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use egui::epaint::{ClippedShape, TextShape};
use egui::{Context, Event, Modifiers, PointerButton, Pos2, RawInput, Rect, Shape, pos2, vec2};
use glam::DVec3;

use super::WIDTH;
use crate::accuracy::History;
use crate::messages::{News, Task, WindowPicture};
use crate::model::Model;
use crate::navigate::CameraSubject;
use crate::statistics::{FieldFacts, Statistics};
use crate::ui;
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_engine::methods::{Facts, FrameProfile};
use pellucid_engine::passes::project::Parts;
use pellucid_scene::{Document, METHODS, Overrides, View};

/// The usual window, but so high that nothing must be scrolled.
const SIZE: [f32; 2] = [1280.0, 4000.0];

/// Most characters of a text beside a control; sentences that wrap may be longer.
const MOST: usize = 30;

fn model(clouds: usize, gaussians: bool) -> Model {
    let cloud = |i: usize| format!("[[cloud]]\npath = 'cloud{i}.ply'\nopacity = 0.{}\n", i + 1);
    let text: String = (0..clouds).map(cloud).collect();
    let text = format!("{text}[shading]\nmodel = 'phong'\nlight = [1, 2, -3]\n");
    let document = Document::from_toml(&text, "s.toml".as_ref(), &Overrides::default()).unwrap();
    let mut model = Model::new("s.toml".into(), document, View::default(), 33.0).unwrap();
    let classes: BTreeMap<u8, usize> = (0..=18).map(|code| (code, 12_345)).collect();
    let scalars = vec![("intensity".to_owned(), [0.0, 1.0]), ("z".to_owned(), [0.0, 1.0])];
    let statistics =
        Statistics { points: 234_567, gaussians, classes, scalars, normals: true, ..Statistics::default() };
    model.take_in(News::Clouds(vec![statistics; clouds].into())).unwrap();
    model
}

/// Shows a picture of survey coordinates, which have long numbers.
fn show_picture(model: &mut Model) {
    let Some(Task::Show(request)) = model.next_task(Instant::now()) else { return };
    let center = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let perspective = Projection::Perspective { fov_y: 0.7 };
    let camera = Camera::look_at(center - 300.0 * DVec3::Y, center, DVec3::Z, perspective, 0.5, 1000.0).unwrap();
    let bounds = Bounds { min: center - 100.0, max: center + 100.0 };
    let subject = CameraSubject { bounds, radius: 0.1, up: UpAxis::Z, vertical: UpAxis::Z.into() };
    let (begin, wall) = (Instant::now(), Duration::from_millis(5));
    let (passes, timeline) = (Vec::new(), Vec::new());
    let parts = Parts { solid: 123_456, soft: 111_111, median_radius: 0.1, ends: Some([0.0, 1.0]) };
    let field = Some(FieldFacts { histogram: vec![7; crate::statistics::BINS].into(), parts });
    model
        .take_in(News::Picture(Box::new(WindowPicture {
            serial: request.serial,
            pose: request.pose,
            camera,
            subject,
            size: request.scene.image.size,
            pixels: None,
            depths: Vec::new(),
            whole: true,
            lacks_samples: false,
            draft: String::new(),
            accuracy: History::default().accuracy(None),
            method: "soft-concentric",
            profile: FrameProfile { passes, begin, timeline, submitted: wall, total: None, wall, waits: 1 },
            facts: Facts { points: 234_567, ..Facts::default() },
            plan: Vec::new(),
            field,
            held: None,
            legend: None,
        })))
        .unwrap();
}

fn frame(ctx: &Context, model: &mut Model, events: Vec<Event>) -> Vec<ClippedShape> {
    let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(SIZE[0], SIZE[1])));
    ctx.run(RawInput { screen_rect, events, ..RawInput::default() }, |ctx| {
        ui::show(ctx, model);
    })
    .shapes
}

fn click(ctx: &Context, model: &mut Model, control: &str) {
    let [left, top, width, height] = model.controls[control];
    let pos = pos2((left + width.min(height) / 2) as f32, (top + height / 2) as f32);
    let button = |pressed| {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos, button, pressed, modifiers }
    };
    frame(ctx, model, vec![Event::PointerMoved(pos), button(true)]);
    frame(ctx, model, vec![button(false), Event::PointerMoved(pos2(10.0, 10.0))]);
    frame(ctx, model, vec![]);
}

/// The texts in some shapes, each with the part of the window that shows it.
fn texts(shapes: &[ClippedShape]) -> Vec<(Rect, &TextShape)> {
    fn look<'a>(clip: Rect, shape: &'a Shape, found: &mut Vec<(Rect, &'a TextShape)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| look(clip, shape, found)),
            Shape::Text(text) => found.push((clip, text)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    shapes.iter().for_each(|shape| look(shape.clip_rect, &shape.shape, &mut found));
    found.retain(|(_, text)| !text.galley.text().is_empty());
    found
}

/// Texts and controls of the panel without enough room, and texts that are no labels.
fn faults(ctx: &Context, model: &mut Model) -> Vec<String> {
    frame(ctx, model, vec![]);
    show_picture(model);
    frame(ctx, model, vec![]);
    let shapes = frame(ctx, model, vec![]);
    assert_eq!(model.viewport().size[0] as f32, SIZE[0] - WIDTH, "the panel is as wide as its column");
    let panel: Vec<_> = texts(&shapes).into_iter().filter(|(_, text)| text.pos.x >= SIZE[0] - WIDTH).collect();
    assert!(panel.len() > 30, "{} texts", panel.len());
    let mut faults = Vec::new();
    for (clip, text) in panel {
        let (said, rect) = (text.galley.text(), text.visual_bounding_rect());
        // Sentences have a line of their own, at most two levels in, or several.
        let is_sentence = text.galley.rows.len() > 1 || rect.left() < SIZE[0] - WIDTH + 64.0;
        let wrong = [
            (said.contains(['`', '"']), "is written for a scene file"),
            (text.galley.elided, "is cut off"),
            (said.chars().count() > MOST && !is_sentence, "is long"),
            (rect.right() > clip.right().min(SIZE[0]) - 2.0, "goes beyond the panel"),
        ];
        faults.extend(wrong.iter().filter(|(is_so, _)| *is_so).map(|(_, what)| format!("{said:?} {what}")));
    }
    // Dots of boxes are in the picture.
    let controls = model.controls.iter().filter(|(name, _)| !name.contains(".-") && !name.contains(".+"));
    let ends = controls.map(|(name, [left, _, width, _])| (name, left + width));
    faults.extend(ends.filter(|(_, end)| *end > SIZE[0] as i32 - 4).map(|(name, end)| format!("{name} ends at {end}")));
    faults
}

#[test]
fn everything_in_the_panel_has_room() {
    let mut found = BTreeMap::new();
    for (clouds, gaussians) in [(1, false), (1, true), (3, false)] {
        let (ctx, mut model) = (Context::default(), model(clouds, gaussians));
        ui::style(&ctx);
        model.set_method("circles");
        frame(&ctx, &mut model, vec![]);
        show_picture(&mut model);
        frame(&ctx, &mut model, vec![]);
        let folded = ["Classes", "Colors", "Clips", "Shadows"].map(|title| format!("section {title}"));
        let inside = ["cloud.0", "shadows.method", "clip.box+", "clip.slab+", "clip.plane+"].map(str::to_owned);
        for control in folded.iter().chain(&inside) {
            click(&ctx, &mut model, control);
        }
        for name in METHODS {
            model.set_method(name);
            assert_eq!(model.message, None);
            for fault in faults(&ctx, &mut model) {
                found.entry(fault).or_insert_with(|| format!("{name}, {clouds} clouds, Gaussians: {gaussians}"));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// An explanation below a slider would hide the next row while the slider is dragged.
#[test]
fn controls_are_explained_at_rest_and_not_while_they_are_dragged() {
    let (ctx, mut model) = (Context::default(), model(1, false));
    ui::style(&ctx);
    ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    model.set_method("circles");
    frame(&ctx, &mut model, vec![]);
    show_picture(&mut model);
    frame(&ctx, &mut model, vec![]);
    let [left, top, _, height] = model.controls["method.size"];
    let pos = pos2((left + height) as f32, (top + height / 2) as f32);
    let is_explained = |model: &mut Model, events: Vec<Event>| {
        frame(&ctx, model, events);
        let shapes = (0..3).map(|_| frame(&ctx, model, vec![])).last().unwrap();
        texts(&shapes).iter().any(|(_, text)| text.galley.text() == crate::hints::hint("method.size"))
    };
    assert!(is_explained(&mut model, vec![Event::PointerMoved(pos)]), "at rest");
    let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
    let pressed = |pressed| Event::PointerButton { pos, button, pressed, modifiers };
    assert!(!is_explained(&mut model, vec![pressed(true)]), "pressed");
    assert!(!is_explained(&mut model, vec![Event::PointerMoved(pos2(pos.x + 3.0, pos.y))]), "dragged");
}
