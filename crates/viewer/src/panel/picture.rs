//! The picture: its background, its blending, and its overlays.

use egui::Ui;

use super::row::row;
use crate::controls::{self, KeyControl, Presence};
use crate::model::{Model, Passes};
use pellucid_core::color::ColorSpace;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let image = model.scene().image;
    for (key, label) in [("background", "background"), ("samples", "samples"), ("color", "blended in")] {
        let mut entry = controls::find(image.keys(), key).and_then(|key| controls::entry(&key, model.extent()));
        if let (Some(KeyControl { presence: Presence::Optional { without, on: false }, .. }), "color") =
            (&mut entry, key)
        {
            color_space(model).clone_into(without);
        }
        row(ui, model, &format!("image.{key}"), label, entry);
    }
    ui.horizontal(|ui| {
        ui.label("times (T)").on_hover_text("show the time of each pass over the picture");
        for (passes, text) in [(Passes::Hidden, "none"), (Passes::Total, "in all"), (Passes::List, "each pass")] {
            ui.selectable_value(&mut model.shows.passes, passes, text);
        }
    });
    let hint = "show a legend of the colors, and a scale bar with an orthographic camera; `pellucid render --legend` draws \
         it into a picture";
    ui.checkbox(&mut model.shows.legend, "legend").on_hover_text(hint);
    if model.picture().is_some_and(|picture| picture.held.is_some()) {
        let mut everything = model.draws_everything();
        let hint = "also draw points closer than a pixel to others; takes minutes for a large cloud";
        if ui.checkbox(&mut everything, "every point at rest").on_hover_text(hint).changed() {
            model.draw_everything(everything);
        }
    }
    if let Some(picture) = model.picture() {
        let [width, height] = picture.size;
        let points = picture.facts.points;
        ui.weak(format!("{width} × {height} pixels, {points} points"));
    }
}

/// The word for the space in which colors are blended if the scene doesn't say: its clouds decide.
fn color_space(model: &Model) -> &'static str {
    let (mut scene, statistics) = (model.scene().clone(), model.statistics());
    scene.settle_for(|cloud| statistics.get(cloud)?.blend_space);
    match scene.image.color_space() {
        ColorSpace::Linear => "linear",
        ColorSpace::Encoded => "encoded",
    }
}
