//! The clouds: how much each hides, and how large its points are.

use egui::Ui;

use super::row::row;
use crate::scene::{Method, Setting};
use crate::viewer::controls::{self, Control};
use crate::viewer::model::Model;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let blended = model.scene().method.discs().is_some()
        || model.scene().method.is_dealt()
        || matches!(model.scene().method, Method::Auto(_) | Method::PeelLayers(_));
    let rows: Vec<_> = model.scene().clouds.iter().map(|cloud| (cloud.path.clone(), cloud.opacity)).collect();
    if blended {
        ui.weak("opacity");
        for (i, (path, opacity)) in rows.iter().enumerate() {
            let name =
                path.file_stem().map_or_else(|| format!("cloud {i}"), |stem| stem.to_string_lossy().into_owned());
            let value = Setting::Number(controls::rounded(*opacity));
            row(ui, model, &format!("cloud.{i}.opacity"), &name, Control::Slider(0.0, 1.0), value);
        }
    }
    if model.scene().method.needs_radii()
        && let Some(factor) = model.scene().clouds.first().map(|cloud| controls::rounded(cloud.radius_factor))
    {
        let control = Control::Slider(0.0, 4.0);
        row(ui, model, "cloud.*.radius_factor", "radius ×", control, Setting::Number(factor));
    }
}
