//! Opening and saving.

use egui::Ui;

use crate::viewer::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
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
