//! The panel beside the picture: the method and its settings, clouds, camera, files.

use egui::{Color32, ComboBox, RichText, ScrollArea, Slider, Ui};

use super::controls::{self, Control};
use super::model::Model;
use super::navigate::Navigator;
use crate::scene::{METHODS, Setting, View, ViewName, method_keys};

/// Width of the panel in points.
pub const WIDTH: f32 = 330.0;

/// The named views, in the order of the keys 1 to 7.
pub const VIEWS: [(ViewName, &str); 7] = [
    (ViewName::Front, "front"),
    (ViewName::Back, "back"),
    (ViewName::Left, "left"),
    (ViewName::Right, "right"),
    (ViewName::Top, "top"),
    (ViewName::Bottom, "bottom"),
    (ViewName::Iso, "iso"),
];

/// Draws the panel; what is changed goes to the model at once.
pub fn show(ui: &mut Ui, model: &mut Model) {
    model.controls.clear();
    ui.spacing_mut().slider_width = 130.0;
    ui.add_space(4.0);
    ui.heading(&model.name);
    message(ui, model);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        section(ui, "Method", |ui| method(ui, model));
        section(ui, "Clouds", |ui| clouds(ui, model));
        section(ui, "Picture", |ui| picture(ui, model));
        section(ui, "Camera", |ui| camera(ui, model));
        section(ui, "Files", |ui| files(ui, model));
    });
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, content);
}

fn message(ui: &mut Ui, model: &Model) {
    match &model.message {
        Some((text, true)) => ui.colored_label(Color32::from_rgb(255, 120, 110), text),
        Some((text, false)) => ui.weak(text),
        None => ui.weak("F1 shows the keys"),
    };
}

fn method(ui: &mut Ui, model: &mut Model) {
    let method = model.scene().method;
    let mut name = method.name();
    let taken = model.picture().map(|picture| picture.method).filter(|taken| *taken != name);
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("method").selected_text(name).width(150.0).height(420.0).show_ui(ui, |ui| {
            for other in METHODS {
                ui.selectable_value(&mut name, other, *other);
            }
        });
        if let Some(taken) = taken {
            ui.weak(format!("→ {taken}"));
        }
    });
    if name != method.name() {
        model.set("method.name", Setting::Word(name.to_owned()));
    }
    for key in method_keys(method.name()) {
        if let Some((control, value)) = controls::control(&method, key) {
            row(ui, model, &format!("method.{key}"), &controls::label(key), control, value);
        }
    }
    let warnings = model.scene().warnings.clone();
    if !warnings.is_empty() {
        ui.collapsing(format!("{} without effect", warnings.len()), |ui| {
            warnings.iter().for_each(|warning| {
                ui.weak(warning);
            });
        });
    }
}

fn clouds(ui: &mut Ui, model: &mut Model) {
    let blended = model.scene().method.discs().is_some()
        || model.scene().method.is_dealt()
        || matches!(model.scene().method, crate::scene::Method::Auto(_) | crate::scene::Method::PeelLayers(_));
    let rows: Vec<_> = model.scene().clouds.iter().map(|cloud| (cloud.path.clone(), cloud.opacity)).collect();
    if blended {
        ui.weak("opacity");
        for (i, (path, opacity)) in rows.iter().enumerate() {
            let name =
                path.file_stem().map_or_else(|| format!("cloud {i}"), |stem| stem.to_string_lossy().into_owned());
            let value = Setting::Number(controls::rounded(*opacity));
            row(ui, model, &format!("cloud.{i}.opacity"), &name, Control::Slider(0.0, 1.0), value);
        }
    }
    if model.scene().method.needs_radii()
        && let Some(factor) = model.scene().clouds.first().map(|cloud| controls::rounded(cloud.radius_factor))
    {
        let control = Control::Slider(0.0, 4.0);
        row(ui, model, "cloud.*.radius_factor", "radius ×", control, Setting::Number(factor));
    }
}

fn picture(ui: &mut Ui, model: &mut Model) {
    ui.horizontal(|ui| {
        let mut color = model.scene().image.background.to_array();
        if ui.color_edit_button_rgb(&mut color).changed() {
            let color = color.map(|x| (f64::from(x) * 1e4).round() / 1e4).to_vec();
            model.set("image.background", Setting::Numbers(color));
        }
        ui.label("background");
    });
    ui.checkbox(&mut model.shows.passes, "times of the passes (T)");
    if let Some(picture) = model.picture() {
        let [width, height] = picture.size;
        let points = picture.facts.points;
        ui.weak(format!("{width} × {height} pixels, {points} points"));
    }
}

fn camera(ui: &mut Ui, model: &mut Model) {
    ui.horizontal_wrapped(|ui| {
        for (name, text) in VIEWS {
            if ui.button(text).clicked() {
                model.look_from(View { name: Some(name), ..View::default() });
            }
        }
        if ui.button("all").on_hover_text("everything, from the front's right and above (Home)").clicked() {
            model.look_from(View::default());
        }
    });
    let mut flat = model.is_orthographic();
    if ui.checkbox(&mut flat, "orthographic (P)").clicked() {
        model.navigate(Navigator::toggle_projection);
    }
}

fn files(ui: &mut Ui, model: &mut Model) {
    ui.add_enabled_ui(!model.busy, |ui| {
        ui.horizontal(|ui| {
            if ui.button("save picture").on_hover_text("with its scene file, into the current folder (F12)").clicked() {
                model.save(true);
            }
            if ui.button("save scene").on_hover_text("into the current folder (Ctrl+S)").clicked() {
                model.save(false);
            }
        });
    });
    ui.weak("drop a scene file or clouds here to open them");
}

/// A control with its name; notes where it is.
fn row(ui: &mut Ui, model: &mut Model, key: &str, label: &str, control: Control, value: Setting) {
    let (response, changed) = ui.horizontal(|ui| edit(ui, key, label, control, value)).inner;
    let scale = ui.ctx().pixels_per_point();
    let rect = response.rect;
    let place = [rect.left(), rect.top(), rect.width(), rect.height()].map(|x| (x * scale).round() as i32);
    model.controls.insert(key.to_owned(), place);
    if let Some(changed) = changed {
        model.set(key, changed);
    }
}

fn edit(ui: &mut Ui, key: &str, label: &str, control: Control, value: Setting) -> (egui::Response, Option<Setting>) {
    match (control, value) {
        (Control::Slider(from, to), Setting::Number(mut x)) => {
            let slider =
                Slider::new(&mut x, from..=to).max_decimals(3).step_by(0.001).clamping(egui::SliderClamping::Edits);
            let response = ui.add(slider);
            ui.label(label);
            let changed = response.changed().then_some(Setting::Number(x));
            (response, changed)
        }
        (Control::Count(from, to), Setting::Integer(mut n)) => {
            let slider = Slider::new(&mut n, from..=to).logarithmic(to > 32).clamping(egui::SliderClamping::Edits);
            let response = ui.add(slider);
            ui.label(label);
            let changed = response.changed().then_some(Setting::Integer(n));
            (response, changed)
        }
        (Control::Flag, Setting::Flag(mut flag)) => {
            let response = ui.checkbox(&mut flag, label);
            let changed = response.changed().then_some(Setting::Flag(flag));
            (response, changed)
        }
        (Control::Choice(words), Setting::Word(word)) => {
            let mut chosen = word.as_str();
            let shown = ComboBox::from_id_salt(key).selected_text(chosen).width(100.0).show_ui(ui, |ui| {
                for other in words {
                    ui.selectable_value(&mut chosen, other, *other);
                }
            });
            ui.label(label);
            let changed = (chosen != word).then(|| Setting::Word(chosen.to_owned()));
            (shown.response, changed)
        }
        // A control has the value that belongs to it.
        (_, other) => (ui.weak(format!("{label} {other:?}")), None),
    }
}
