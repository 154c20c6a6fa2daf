//! The clouds: how much each hides, and, unfolded, its radii and field.

use egui::collapsing_header::CollapsingState;
use egui::{ScrollArea, Ui};

use super::row::{name as row_name, note, row};
use super::{field, opacity};
use crate::controls;
use crate::counts::grouped;
use crate::model::Model;
use crate::statistics::Statistics;
use pellucid_core::cloud::field::Field;
use pellucid_scene::{CloudSettings, Method, Primitive, Scene};

/// Clouds that are listed among the other controls; longer lists scroll on their own.
const MANY: usize = 15;
const ROOM: f32 = 330.0;

/// Draws the section.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let method = model.scene().method.representative();
    let blended = are_blended(model.scene());
    let clouds = model.scene().clouds.clone();
    match &clouds[..] {
        [one] if blended => {
            opacity::one(ui, model, 0, one, "opacity");
        }
        _ if blended => opacity::all(ui, model, &clouds),
        _ => {}
    }
    if let Some(first) = clouds.first().filter(|_| method.needs_radii()) {
        let entry = controls::cloud(first, "radius_factor", false, None, model.extent());
        row(ui, model, "cloud.*.radius_factor", "radius ×", entry);
    }
    if clouds.len() <= MANY {
        list(ui, model, blended && clouds.len() > 1);
    } else {
        let some = ScrollArea::vertical().id_salt("clouds").max_height(ROOM).auto_shrink([false, true]);
        some.show(ui, |ui| list(ui, model, blended && clouds.len() > 1));
    }
}

/// True if the method shows what is behind points by their opacities.
pub fn are_blended(scene: &Scene) -> bool {
    let method = scene.method.representative();
    method.discs().is_some() || method.is_dealt() || matches!(method, Method::PeelLayers(_))
}

/// Lists the clouds: opacity if `faint`, and name, which unfolds the cloud.
fn list(ui: &mut Ui, model: &mut Model, faint: bool) {
    let (clouds, statistics) = (model.scene().clouds.clone(), model.statistics());
    for (i, settings) in clouds.iter().enumerate() {
        let id = ui.make_persistent_id(("cloud", i));
        let state = CollapsingState::load_with_default_open(ui.ctx(), id, false);
        let mut clicked = false;
        let mut header = state.show_header(ui, |ui| {
            let name = name(settings, i);
            ui.spacing_mut().slider_width = super::SLIDER - 20.0;
            clicked = if faint {
                opacity::one(ui, model, i, settings, &name)
            } else {
                let response = row_name(ui, "", &name).on_hover_text(settings.path.display().to_string());
                note(model, &format!("cloud.{i}"), response).clicked()
            };
        });
        if clicked {
            header.toggle();
        }
        header.body(|ui| details(ui, model, i, settings, statistics.get(i)));
    }
}

/// The display name of a cloud.
pub fn name(settings: &CloudSettings, i: usize) -> String {
    let stem = settings.path.file_stem();
    stem.map_or_else(|| format!("cloud {i}"), |stem| stem.to_string_lossy().into_owned())
}

/// A cloud's settings other than its opacity.
fn details(ui: &mut Ui, model: &mut Model, i: usize, settings: &CloudSettings, statistics: Option<&Statistics>) {
    let method = model.scene().method;
    let unknown = Statistics::default();
    let statistics = statistics.unwrap_or(&unknown);
    ui.weak(facts(statistics));
    let field = statistics.field(settings);
    let estimated = method.needs_radii() && settings.radius.is_none() && !statistics.own_radii;
    let uncertain = method.needs_field() && field == Field::Uncertainty;
    let around = estimated || uncertain;
    let as_gaussians = statistics.gaussians && settings.primitive == Primitive::Gaussians && method.is_made_of_discs();
    let keys = [
        ("primitive", statistics.gaussians),
        ("sh_degree", as_gaussians),
        ("radius", method.needs_radii() && !as_gaussians),
        ("neighbors", around && !as_gaussians),
        ("radius_cap", around && !as_gaussians),
        ("outliers", true),
    ];
    if method.representative().discs().is_some() && !as_gaussians {
        opacity::surface(ui, model, i, settings);
    }
    let prepared = statistics.prepared.as_ref().map(|(neighbors, _)| *neighbors);
    for (key, _) in keys.into_iter().filter(|(_, shown)| *shown) {
        let entry = controls::cloud(settings, key, statistics.own_radii, prepared, model.extent());
        row(ui, model, &format!("cloud.{i}.{key}"), &controls::label(key), entry);
    }
    // A single cloud has its own section for this.
    if method.needs_field() && model.scene().clouds.len() > 1 {
        field::chooser(ui, model, &i.to_string(), &[i]);
    }
}

fn facts(statistics: &Statistics) -> String {
    let has = [
        ("Gaussians", statistics.gaussians),
        ("colors", statistics.colors),
        ("normals", statistics.normals),
        ("radii", statistics.own_radii),
    ];
    let has = has.into_iter().filter(|(_, has)| *has).map(|(name, _)| name);
    let scalars = statistics
        .scalars
        .iter()
        .map(|(name, _)| name.as_str())
        .filter(|name| !["x", "y", "z", "radius"].contains(name));
    let has: Vec<_> = has.chain(scalars).collect();
    let points = grouped(statistics.points as u64);
    if has.is_empty() { format!("{points} points") } else { format!("{points} points; {}", has.join(", ")) }
}
