//! A control with its name, for a key of the scene file.

use egui::{ComboBox, Response, Slider, Ui};

use crate::scene::Setting;
use crate::viewer::controls::Control;
use crate::viewer::model::Model;

/// A control with its name; notes where it is.
pub fn row(ui: &mut Ui, model: &mut Model, key: &str, label: &str, control: Control, value: Setting) {
    let (response, changed) = ui.horizontal(|ui| edit(ui, key, label, control, value)).inner;
    let scale = ui.ctx().pixels_per_point();
    let rect = response.rect;
    let place = [rect.left(), rect.top(), rect.width(), rect.height()].map(|x| (x * scale).round() as i32);
    model.controls.insert(key.to_owned(), place);
    if let Some(changed) = changed {
        model.set(key, changed);
    }
}

fn edit(ui: &mut Ui, key: &str, label: &str, control: Control, value: Setting) -> (Response, Option<Setting>) {
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
