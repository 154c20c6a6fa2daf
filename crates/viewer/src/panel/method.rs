//! The method and its settings.

use egui::{ComboBox, Ui};

use super::row::{edit_row, note};
use crate::controls;
use crate::model::Model;
use pellucid_engine::scene::{METHODS, method_keys};

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let method = model.scene().method;
    let mut name = method.name();
    let taken = model.picture().map(|picture| picture.method).filter(|taken| *taken != name);
    ui.horizontal(|ui| {
        let combo = ComboBox::from_id_salt("method").selected_text(name).width(150.0).height(420.0);
        let shown = combo.show_ui(ui, |ui| {
            for other in METHODS {
                ui.selectable_value(&mut name, other, *other);
            }
        });
        note(ui, model, "method.name", &shown.response);
        if let Some(taken) = taken {
            ui.weak(format!("→ {taken}"));
        }
    });
    if name != method.name() {
        model.set_method(name);
    }
    for key in method_keys(method.name()) {
        let dotted = format!("method.{key}");
        if let Some(entry) = controls::method(&method.representative(), key, model.extent())
            && let (Some(edit), _) = edit_row(ui, model, &dotted, &controls::label(key), entry)
        {
            model.change(&controls::method_changes(&method.representative(), key, edit.value()));
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
