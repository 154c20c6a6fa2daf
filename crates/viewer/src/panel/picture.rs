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
    let mut legend = model.shows.legend;
    let hint = "what the colors mean, and a scale bar where the camera is orthographic; `render --legend` draws it into a picture";
    if ui.checkbox(&mut legend, "legend").on_hover_text(hint).changed() {
        model.show_legend(legend);
    }
    if let Some(picture) = model.picture() {
        let [width, height] = picture.size;
        let points = picture.facts.points;
        ui.weak(format!("{width} × {height} pixels, {points} points"));
    }
}
