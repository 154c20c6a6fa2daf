//! The picture: what is behind it, how it is blended, and what is over it.

use egui::Ui;

use super::row::row;
use crate::controls::{Control, Entry, Presence, rounded};
use crate::model::Model;
use pellucid_engine::scene::{ColorSpace, Setting};

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let image = model.scene().image;
    let background = Setting::Numbers(image.background.to_array().map(rounded).to_vec());
    let always = |control, value| Entry { control, value, presence: Presence::Always };
    row(ui, model, "image.background", "background", always(Control::Color, background));
    let word = match image.color {
        ColorSpace::Linear => "linear",
        ColorSpace::Encoded => "encoded",
    };
    let choice = always(Control::Choice(&["linear", "encoded"]), Setting::Word(word.to_owned()));
    row(ui, model, "image.color", "blended in", choice);
    ui.checkbox(&mut model.shows.passes, "times of the passes (T)");
    if let Some(picture) = model.picture() {
        let [width, height] = picture.size;
        let points = picture.facts.points;
        ui.weak(format!("{width} × {height} pixels, {points} points"));
    }
}
