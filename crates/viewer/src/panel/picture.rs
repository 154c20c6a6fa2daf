//! The picture: its background, its blending, and its overlays.

use egui::Ui;

use super::row::row;
use crate::controls;
use crate::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let image = model.scene().image;
    for (key, label) in [("background", "background"), ("color", "blended in")] {
        if let Some(entry) = controls::find(image.keys(), key).and_then(|key| controls::entry(&key, model.extent())) {
            row(ui, model, &format!("image.{key}"), label, entry);
        }
    }
    ui.checkbox(&mut model.shows.passes, "times of the passes (T)");
    if let Some(picture) = model.picture() {
        let [width, height] = picture.size;
        let points = picture.facts.points;
        ui.weak(format!("{width} × {height} pixels, {points} points"));
    }
}
