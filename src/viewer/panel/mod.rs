//! The panel beside the picture: the method and its settings, clouds, camera, files.

mod camera;
mod clouds;
mod files;
mod method;
mod path;
mod picture;
mod row;

use egui::{Color32, RichText, ScrollArea, Ui};

use super::model::Model;
use crate::scene::ViewName;

/// Width of the panel in points.
pub const WIDTH: f32 = 330.0;

/// The named views, in the order of the keys 1 to 7.
pub const VIEWS: [(ViewName, &str); 7] = [
    (ViewName::Front, "front"),
    (ViewName::Back, "back"),
    (ViewName::Left, "left"),
    (ViewName::Right, "right"),
    (ViewName::Top, "top"),
    (ViewName::Bottom, "bottom"),
    (ViewName::Iso, "iso"),
];

/// Draws the panel; what is changed goes to the model at once.
pub fn show(ui: &mut Ui, model: &mut Model) {
    model.controls.clear();
    ui.spacing_mut().slider_width = 130.0;
    ui.add_space(4.0);
    ui.heading(&model.name);
    message(ui, model);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        section(ui, "Method", |ui| method::show(ui, model));
        section(ui, "Clouds", |ui| clouds::show(ui, model));
        section(ui, "Picture", |ui| picture::show(ui, model));
        section(ui, "Camera", |ui| camera::show(ui, model));
        section(ui, "Path", |ui| path::show(ui, model));
        section(ui, "Files", |ui| files::show(ui, model));
    });
}

fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show(ui, content);
}

fn message(ui: &mut Ui, model: &Model) {
    match &model.message {
        Some((text, true)) => ui.colored_label(Color32::from_rgb(255, 120, 110), text),
        Some((text, false)) => ui.weak(text),
        None => ui.weak("F1 shows the keys"),
    };
}
