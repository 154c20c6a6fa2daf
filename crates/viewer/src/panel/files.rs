//! Opening and saving.

use egui::Ui;

use crate::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.add_enabled_ui(!model.busy, |ui| {
        ui.horizontal_wrapped(|ui| {
            if ui.button("open…").on_hover_text("open a scene, clouds or a camera path (Ctrl+O)").clicked() {
                model.dialog.open();
            }
            if ui
                .button("save picture")
                .on_hover_text(
                    "save the picture and its scene file in the current folder \
                 (F12)",
                )
                .clicked()
            {
                model.save(true);
            }
            if ui.button("save scene").on_hover_text("save the scene file in the current folder (Ctrl+S)").clicked() {
                model.save(false);
            }
            if ui
                .button("save scene as…")
                .on_hover_text("save the scene file under another name (Ctrl+Shift+S)")
                .clicked()
            {
                model.ask_where_to_save();
            }
        });
    });
    ui.weak("drop a scene file, clouds or a camera path here to open them");
}
