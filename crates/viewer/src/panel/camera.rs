//! Standard views and the projection.

use egui::Ui;

use super::VIEWS;
use crate::model::Model;
use crate::navigate::Navigator;
use pellucid_scene::View;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.horizontal_wrapped(|ui| {
        for (name, text, _) in VIEWS {
            if ui.button(*text).clicked() {
                model.look_from(View { name: Some(*name), ..View::default() });
            }
        }
    });
    ui.horizontal(|ui| {
        if ui.button("all").on_hover_text("everything, from the front's right and above (Home)").clicked() {
            model.look_from(View::default());
        }
        let mut flat = model.is_orthographic();
        if ui.checkbox(&mut flat, "orthographic (P)").clicked() {
            model.navigate(Navigator::toggle_projection);
        }
    });
}
