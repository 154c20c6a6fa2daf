//! The picture: what is behind it, and what is over it.

use egui::Ui;

use crate::scene::Setting;
use crate::viewer::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
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
