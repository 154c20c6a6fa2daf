//! The path of key frames: keys of the present camera, and running along them.

use egui::{DragValue, ScrollArea, Slider, SliderClamping, Ui};

use super::row::note;
use crate::model::Model;
use crate::route::Route;

/// Height of the list of keys in points.
const LIST: f32 = 132.0;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    edit(ui, model);
    if model.route.keys().is_empty() {
        ui.weak("press K to add the current camera as a key; the camera moves between keys");
    } else {
        list(ui, model);
        timing(ui, model);
        run(ui, model);
    }
    files(ui, model);
}

/// Name, text, whether it can be clicked, hint and action of a button.
type Button<'a> = (&'a str, &'a str, bool, &'a str, fn(&mut Model));

/// Buttons in a row, which are there for tests to find, too.
fn buttons(ui: &mut Ui, model: &mut Model, all: &[Button<'_>]) {
    for (name, text, enabled, hint, act) in all {
        let response = ui.add_enabled(*enabled, egui::Button::new(*text)).on_hover_text(*hint);
        if note(model, &format!("path.{name}"), response).clicked() {
            act(model);
        }
    }
}

fn edit(ui: &mut Ui, model: &mut Model) {
    let selected = model.route.selected();
    let (is_selected, count) = (selected.is_some(), model.route.keys().len());
    let [is_first, is_last] = [Some(0), count.checked_sub(1)].map(|at| selected == at);
    let all: [Button<'_>; 5] = [
        ("add", "add key", true, "add the current camera after the selected key (K)", Model::add_key),
        ("replace", "replace", is_selected, "replace the selected key with the current camera", Model::replace_key),
        ("delete", "delete", is_selected, "the selected key", Model::delete_key),
        ("up", "⏶", is_selected && !is_first, "move the selected key earlier", |model| model.shift_key(true)),
        ("down", "⏷", is_selected && !is_last, "move the selected key later", |model| model.shift_key(false)),
    ];
    ui.horizontal(|ui| buttons(ui, model, &all));
}

/// The keys; one that is clicked is selected and shown.
fn list(ui: &mut Ui, model: &mut Model) {
    let (count, height) = (model.route.keys().len(), ui.spacing().interact_size.y);
    let area = ScrollArea::vertical().id_salt("keys of the path").max_height(LIST).auto_shrink([false, true]);
    area.show_rows(ui, height, count, |ui, rows| {
        for at in rows {
            ui.horizontal(|ui| row(ui, model, at));
        }
    });
}

fn row(ui: &mut Ui, model: &mut Model, at: usize) {
    let Some(key) = model.route.keys().get(at) else { return };
    let [x, y, z] = key.eye;
    let time = key.time;
    let is_selected = model.route.selected() == Some(at);
    let response = ui.selectable_label(is_selected, format!("{:>3}", at + 1));
    let response = response.on_hover_text(format!("eye at {x:.3}, {y:.3}, {z:.3}"));
    if note(model, &format!("path.key.{}", at + 1), response).clicked() {
        model.go_to_key(at);
    }
    match time {
        Some(mut seconds) => {
            let time_of = |at: usize| model.route.keys().get(at).and_then(|key| key.time);
            let least = at.checked_sub(1).and_then(time_of).map_or(f64::NEG_INFINITY, |time| time + 1e-3);
            let most = time_of(at + 1).map_or(f64::INFINITY, |time| time - 1e-3);
            let range = least.min(seconds)..=most.max(seconds);
            if ui.add(DragValue::new(&mut seconds).range(range).speed(0.05).suffix(" s").max_decimals(3)).changed() {
                model.change_route(|route, defaults| route.set_time(at, seconds, defaults));
            }
        }
        None => {
            ui.weak(format!("eye {x:.2}, {y:.2}, {z:.2}"));
        }
    }
}

fn timing(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        let mut closed = model.route.is_closed();
        if ui.checkbox(&mut closed, "loop").on_hover_text("return from the last key to the first").changed() {
            model.change_route(|route, defaults| route.set_closed(closed, defaults));
        }
        let mut timed = model.route.is_timed();
        if ui.checkbox(&mut timed, "times").on_hover_text("give each key a time in seconds").changed() {
            model.change_route(|route, defaults| route.set_timed(timed, defaults));
        }
        if !timed {
            let mut pace = model.route.pace();
            let drag = DragValue::new(&mut pace).range(0.05..=600.0).speed(0.05).suffix(" s").max_decimals(2);
            if ui.add(drag).on_hover_text("from key to key").changed() {
                model.edit_route(|route| route.set_pace(pace));
            }
        }
        let mut rate = model.route.rate();
        let drag = DragValue::new(&mut rate).range(1..=240).speed(0.2).suffix(" fps");
        if ui.add(drag).on_hover_text("frames per second of the film").changed() {
            model.edit_route(|route| route.set_rate(rate));
        }
        ui.weak(format!("{} frames", model.route.frames()));
    });
}

fn run(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        let text = if model.route.is_playing() { "⏸ stop" } else { "▶ play" };
        let hint = "play the path (Space); any camera movement stops it";
        buttons(ui, model, &[("play", text, true, hint, Model::play)]);
        let (mut position, duration) = (model.route.position(), model.route.duration());
        // Only what a hand does is rounded: a slider that rounds what it shows would stop the camera.
        let slider = Slider::new(&mut position, 0.0..=duration.max(f64::MIN_POSITIVE)).clamping(SliderClamping::Edits);
        let slider = slider.max_decimals(2).suffix(" s");
        if note(model, "path.position", ui.add_enabled(duration > 0.0, slider)).changed() {
            model.seek(position);
        }
    });
}

fn files(ui: &mut Ui, model: &mut Model) {
    let any = !model.route.keys().is_empty();
    let turn = "Fill the path with a full turn of the current camera about its pivot: a key every 22.5°.\n`pellucid \
             render --turntable` turns around the middle of the scene instead, and keeps all of it in every frame.";
    let save = "save the path and its scene in the current folder (Ctrl+K); the message shows how to render it";
    let all: [Button<'_>; 3] = [
        ("turntable", "turntable", true, turn, Model::fill_turntable),
        ("save", "save path", any && !model.busy, save, Model::save_path),
        ("clear", "clear", any, "remove all keys", |model| model.edit_route(Route::clear)),
    ];
    ui.horizontal(|ui| buttons(ui, model, &all));
}
