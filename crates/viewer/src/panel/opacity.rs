//! Opacity of the clouds: one slider for all, one for each.

use egui::Ui;

use super::row::{edit_row, note, row};
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
    entry(cloud, model).is_some_and(|(key, entry)| row(ui, model, &format!("cloud.{i}.{key}"), label, Some(entry)))
}

/// Shows a slider for all clouds, each by its own key; while they differ it shows their mean.
pub fn all(ui: &mut Ui, model: &mut Model, clouds: &[CloudSettings]) {
    let Some((key, mut entry)) = clouds.first().and_then(|first| entry(first, model)) else { return };
    let values: Vec<f32> = clouds.iter().map(|cloud| controls::opacity(cloud).1).collect();
    let alike = values.iter().all(|value| Some(value) == values.first());
    let (label, value) = if alike {
        ("opacity of all", values.first().copied().map_or(1.0, rounded))
    } else {
        let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64;
        ("opacity (mean)", controls::thousandths(mean))
    };
    entry.value = Setting::Number(value);
    if let (Some(edit), _) = edit_row(ui, model, &format!("cloud.*.{key}"), label, entry) {
        model.change(&controls::opacities(clouds, edit.as_ref()));
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
    fn each_cloud_has_the_opacity_by_the_key_it_had() {
        let text = "[[cloud]]\npath = 'a.ply'\nsurface_opacity = 0.5\n[[cloud]]\npath = 'b.ply'";
        let mut document = Document::from_toml(text, "s.toml".as_ref(), &Overrides::default()).unwrap();
        let scene = document.scene().unwrap();
        let scene = document.change(&controls::opacities(&scene.clouds, Some(&Setting::Number(0.25)))).unwrap();
        let [first, second] = &scene.clouds[..] else { panic!("two clouds") };
        assert_eq!((first.surface_opacity, first.opacity), (Some(0.25), 1.0));
        assert_eq!((second.surface_opacity, second.opacity), (None, 0.25));
        for wanted in [("opacity", 0.25), ("surface_opacity", 0.25)] {
            let cloud = document.scene().unwrap().clouds[0].clone();
            let (key, value) = controls::opacity(&cloud);
            let scene = document.change(&by_the_other_key(0, key, value)).unwrap();
            assert_eq!(controls::opacity(&scene.clouds[0]), wanted);
        }
    }
}
