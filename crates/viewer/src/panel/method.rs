//! The method and its settings.

use egui::{ComboBox, RichText, Ui};

use super::row::{Edit, edit_row, note};
use crate::controls;
use crate::model::Model;
use pellucid_scene::{MethodChoice, Purpose, gaussian_keys, method_keys};

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let method = model.scene().method;
    let (mut name, auto) = (method.name(), MethodChoice::default().name());
    let taken = model.picture().map(|picture| picture.method).filter(|taken| *taken != name);
    ui.horizontal(|ui| {
        let combo = ComboBox::from_id_salt("method").selected_text(name).width(150.0).height(640.0);
        let shown = combo.show_ui(ui, |ui| {
            ui.selectable_value(&mut name, auto, auto).on_hover_text("the exact method that suits the scene");
            for purpose in Purpose::ALL {
                ui.add_space(4.0);
                ui.label(RichText::new(purpose.title()).weak().size(11.0));
                for other in purpose.methods() {
                    ui.selectable_value(&mut name, other.name(), other.name()).on_hover_text(other.about());
                }
            }
        });
        note(model, "method.name", shown.response);
        if let Some(taken) = taken {
            ui.weak(format!("here {taken}"));
        }
    });
    if name != method.name() {
        model.set_method(name);
    }
    // Without Gaussians they are keys without effect, and there are many of them.
    let gaussians = model.statistics().iter().any(|statistics| statistics.gaussians);
    let shown = |key: &&str| gaussians || !gaussian_keys().contains(key);
    for key in method_keys(method.name()).into_iter().filter(shown) {
        let dotted = format!("method.{key}");
        if let Some(entry) = controls::method(&method.representative(), key, model.extent())
            && let (Some(edit), _) = edit_row(ui, model, &dotted, &controls::label(key), entry)
        {
            let changes = |value| controls::method_changes(&method.representative(), key, value);
            match edit {
                Edit::Set(value) => model.change(&changes(Some(value))),
                Edit::Remove => model.change(&changes(None)),
                Edit::Reset => model.reset_method(key),
            }
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
