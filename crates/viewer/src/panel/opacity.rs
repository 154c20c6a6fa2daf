//! Opacity of the clouds: one slider for all, one for each.

use egui::Ui;

use super::row::{Edit, edit_row_with, note};
use crate::controls::{self, KeyControl, Presence};
use crate::model::Model;
use pellucid_scene::{Change, CloudSettings, Setting, rounded};

/// The control of the key that decides how faint a cloud is, and the key.
fn entry(cloud: &CloudSettings, model: &Model) -> Option<(&'static str, KeyControl)> {
    let (key, _) = controls::opacity(cloud);
    let mut entry = controls::cloud(cloud, key, false, None, model.extent())?;
    // Of the two keys this is the one that is there.
    entry.presence = Presence::Always;
    Some((key, entry))
}

/// The slider of one cloud. Returns true if its label was clicked.
pub fn one(ui: &mut Ui, model: &mut Model, i: usize, cloud: &CloudSettings, label: &str) -> bool {
    let Some((key, entry)) = entry(cloud, model) else { return false };
    let both = ["opacity", "surface_opacity"].map(|key| format!("cloud.{i}.{key}"));
    let (key, is_changed) = (format!("cloud.{i}.{key}"), both.iter().any(|key| model.is_changed(key)));
    let (edit, clicked) = edit_row_with(ui, model, &key, label, entry, is_changed);
    match edit {
        Some(Edit::Set(value)) => model.set(&key, value),
        Some(Edit::Remove | Edit::Reset) => model.reset(&both),
        None => {}
    }
    clicked
}

/// Shows a slider for all clouds, each by its own key, and their classes; while the clouds differ it shows their mean.
pub fn all(ui: &mut Ui, model: &mut Model, clouds: &[CloudSettings]) {
    let Some((key, mut entry)) = clouds.first().and_then(|first| entry(first, model)) else { return };
    let (mean, are_equal) = controls::mean_opacity(clouds);
    let label = if are_equal { "opacity of all" } else { "opacity (mean)" };
    entry.value = Setting::Number(controls::thousandths(mean));
    let keys = controls::opacity_keys(clouds, &model.opened_scene().clouds);
    let is_changed = keys.iter().any(|key| model.is_changed(key));
    match edit_row_with(ui, model, &format!("cloud.*.{key}"), label, entry, is_changed).0 {
        Some(Edit::Set(Setting::Number(mean))) => model.set_mean_opacity(mean),
        Some(Edit::Reset) => model.reset(&keys),
        _ => {}
    }
}

/// Shows the choice between the opacity of discs and that of the surface that they lie on.
pub fn surface(ui: &mut Ui, model: &mut Model, i: usize, cloud: &CloudSettings) {
    let (key, value) = controls::opacity(cloud);
    let mut on = key == "surface_opacity";
    let response = ui.checkbox(&mut on, "opacity of the surface");
    let response = note(model, &format!("cloud.{i}.surface_opacity?"), response).on_hover_text(
        "Overlapping discs hide more than each one alone. If checked, the opacity is that of the surface the discs lie on \
         (surface_opacity).",
    );
    if response.changed() {
        model.change(&by_the_other_key(i, key, value));
    }
}

/// The changes by which the other key has the value.
fn by_the_other_key(i: usize, key: &str, value: f32) -> Vec<Change> {
    let other = if key == "opacity" { "surface_opacity" } else { "opacity" };
    let value = Setting::Number(rounded(value));
    vec![(format!("cloud.{i}.{key}"), None), (format!("cloud.{i}.{other}"), Some(value))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Document, Overrides};

    #[test]
    fn the_opacity_stays_when_the_other_key_has_it() {
        let text = "[[cloud]]\npath = 'a.ply'\nsurface_opacity = 0.25";
        let mut document = Document::from_toml(text, "s.toml".as_ref(), &Overrides::default()).unwrap();
        for wanted in [("opacity", 0.25), ("surface_opacity", 0.25)] {
            let cloud = document.scene().unwrap().clouds[0].clone();
            let (key, value) = controls::opacity(&cloud);
            let scene = document.change(&by_the_other_key(0, key, value)).unwrap();
            assert_eq!(controls::opacity(&scene.clouds[0]), wanted);
        }
    }
}
