//! Everything egui draws.

use egui::{CentralPanel, Context, Frame, SidePanel};

use super::dialog::Chosen;
use super::model::Model;
use super::{handles, legend, overlay, panel, pointer};

/// The looks: dark, so that the picture stands out.
pub fn style(ctx: &Context) {
    ctx.set_theme(egui::Theme::Dark);
    // Sections unfold at once: every intermediate step would be drawn beside the picture, on the same device, and move
    // controls that are about to be clicked.
    ctx.all_styles_mut(|style| {
        style.animation_time = 0.0;
        // Lists that open are as long as they need to be, if the window has the room.
        style.spacing.default_area_size.y = 800.0;
    });
    ctx.options_mut(|options| {
        // A second pass would apply the pointer's actions twice.
        options.max_passes = std::num::NonZeroUsize::MIN;
        // A click counts however long the frame between press and release takes.
        options.input_options.max_click_duration = f64::INFINITY;
    });
}

/// Draws everything. Returns true if the window should close.
pub fn show(ctx: &Context, model: &mut Model) -> bool {
    let close = pointer::keys(ctx, model);
    pointer::play(ctx, model);
    if model.shows.panel {
        SidePanel::right("panel").exact_width(panel::WIDTH).resizable(false).show(ctx, |ui| panel::show(ui, model));
    }
    model.explain_colors();
    CentralPanel::default().frame(Frame::NONE).show(ctx, |ui| {
        pointer::picture(ui, model);
        handles::show(ui, model);
    });
    legend::show(ctx, model);
    overlay::show(ctx, model);
    match model.dialog.show(ctx) {
        Some(Chosen::Files(files)) => model.open(files),
        Some(Chosen::Scene(file)) => model.save_as(file),
        None => {}
    }
    close
}
