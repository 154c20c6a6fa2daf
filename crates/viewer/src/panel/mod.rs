//! The panel beside the picture: the method and its settings, the field, clouds with their classes and colors, clips,
//! shading, shadows, camera, files.

mod camera;
mod classes;
mod clips;
mod clouds;
mod colors;
mod field;
mod files;
mod method;
mod opacity;
mod path;
mod picture;
mod row;
mod shading;

pub use row::note;

use egui::{Color32, Label, RichText, ScrollArea, Ui};

use super::model::Model;
use pellucid_scene::{ShadingModel, ViewName};

/// Width of the panel in points.
pub const WIDTH: f32 = 330.0;

/// Width of its sliders in points.
const SLIDER: f32 = 120.0;

/// The views along the axes and the isometric one, with their words, in the order of the keys 1 to 7.
pub const VIEWS: &[(ViewName, &str, &str)] = ViewName::ALL.split_at(7).0;

/// Draws the panel; changes go to the model at once.
pub fn show(ui: &mut Ui, model: &mut Model) {
    model.controls.clear();
    ui.spacing_mut().slider_width = SLIDER;
    ui.add_space(4.0);
    ui.add(Label::new(RichText::new(&model.name).heading()).truncate()).on_hover_text(&model.name);
    // In a part of their own, so that controls below keep their identity, and a drag goes on, when messages come and
    // go.
    ui.scope(|ui| {
        message(ui, model);
        saved(ui, model);
    });
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        section(ui, model, "Method", true, method::show);
        if model.scene().method.needs_field() {
            section(ui, model, "Solid and soft", true, field::show);
        }
        section(ui, model, "Clouds", true, clouds::show);
        if model.statistics().iter().any(|statistics| !statistics.classes.is_empty()) {
            section(ui, model, "Classes", false, classes::show);
        }
        model.shows.colors = section(ui, model, "Colors", false, colors::show);
        model.shows.clips = section(ui, model, "Clips", false, clips::show);
        let (shaded, lit) = (model.scene().shading.model != ShadingModel::None, model.is_given("shadows"));
        section(ui, model, "Shading", shaded, shading::show);
        if shading::has_shadows(model.scene()) {
            section(ui, model, "Shadows", lit, shading::shadows);
        }
        section(ui, model, "Picture", true, picture::show);
        section(ui, model, "Camera", true, camera::show);
        section(ui, model, "Path", true, path::show);
        section(ui, model, "Files", true, files::show);
    });
}

/// A part of the panel that can be folded. Returns true if it is unfolded.
fn section(ui: &mut Ui, model: &mut Model, title: &str, open: bool, content: fn(&mut Ui, &mut Model)) -> bool {
    let header = egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open);
    let shown = header.show(ui, |ui| content(ui, model));
    note(model, &format!("section {title}"), shown.header_response);
    shown.body_returned.is_some()
}

fn message(ui: &mut Ui, model: &Model) {
    let told = |(text, _): &&(String, bool)| model.saved.as_ref().is_none_or(|saved| !saved.says(text));
    match model.message.as_ref().filter(told) {
        Some((text, true)) => ui.colored_label(Color32::from_rgb(255, 120, 110), text),
        Some((text, false)) => ui.weak(text),
        None if model.saved.is_some() => return,
        None => ui.weak("F1 shows the keys"),
    };
}

/// The files that were saved last, and a button that dismisses them.
fn saved(ui: &mut Ui, model: &mut Model) {
    let Some(saved) = &model.saved else { return };
    let small = |text: String| RichText::new(text).size(11.0);
    let lines = saved.files.iter().enumerate().map(|(i, file)| {
        let file = file.display();
        if i == 0 { format!("saved {file}") } else { format!("and {file}") }
    });
    let dismissed = ui.horizontal_top(|ui| {
        let dismissed = ui.small_button("×").on_hover_text("dismiss this message; the files stay");
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            lines.chain(saved.command.clone()).for_each(|line| drop(ui.add(Label::new(small(line)).wrap())));
        });
        dismissed.clicked()
    });
    if dismissed.inner {
        model.dismiss_saved();
    }
}

#[cfg(test)]
mod tests;
