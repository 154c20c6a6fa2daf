//! Opening and saving.

use egui::Ui;

use crate::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    ui.add_enabled_ui(!model.busy, |ui| {
        ui.horizontal_wrapped(|ui| {
            let mut clicked = |text: &str, hint: &str| ui.button(text).on_hover_text(hint).clicked();
            if clicked("open…", "open a scene, clouds or a camera path (Ctrl+O)") {
                model.dialog.open();
            }
            if clicked("save picture", "save the picture and its scene file in the current folder (F12)") {
                model.save(true);
            }
            if clicked("save scene", "save the scene file in the current folder (Ctrl+S)") {
                model.save(false);
            }
            if clicked("save scene as…", "save the scene file under another name (Ctrl+Shift+S)") {
                model.ask_where_to_save();
            }
        });
    });
    ui.weak("drop a scene file, clouds or a camera path here to open them");
}
