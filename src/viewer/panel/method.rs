//! The method and its settings.

use egui::{ComboBox, Ui};

use super::row::row;
use crate::scene::{METHODS, Setting, method_keys};
use crate::viewer::controls;
use crate::viewer::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
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
