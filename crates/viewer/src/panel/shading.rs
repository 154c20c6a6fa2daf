//! Shading and its light, and shadows.

use egui::Ui;
use glam::DVec3;

use super::row::{choice_row, name, note, row, vector};
use crate::controls;
use crate::model::Model;
use pellucid_core::cloud::UpAxis;
use pellucid_scene::{Change, Light, Scene, Setting, ShadingModel, Shadows, Vertical, View};

/// Azimuth and elevation of a light that had no direction: left of the front, half-way up.
const FROM: [f64; 2] = [-50.0, 45.0];

/// Straight from above a direction has no azimuth, so that the slider stops just before.
const STEEPEST: f64 = 89.9;

/// Draws the section on shading.
pub fn show(ui: &mut Ui, model: &mut Model) {
    let shading = model.scene().shading;
    let of_model: &[&str] = match shading.model {
        ShadingModel::None => &["model"],
        ShadingModel::Lambert | ShadingModel::Auto => &["model", "ambient", "diffuse"],
        ShadingModel::Phong => &["model", "ambient", "diffuse", "specular", "shininess"],
    };
    let of_depth: &[&str] = match (shading.edl.edl, model.scene().method.may_take_edl()) {
        (true, _) => &["edl", "edl_strength", "edl_radius"],
        (false, true) => &["edl"],
        (false, false) => &[],
    };
    for key in of_model.iter().chain(of_depth) {
        let entry = controls::find(shading.keys(), key).and_then(|key| controls::entry(&key, model.extent()));
        row(ui, model, &format!("shading.{key}"), key, entry);
    }
    if shading.model != ShadingModel::None {
        light(ui, model, shading.light);
    }
}

fn light(ui: &mut Ui, model: &mut Model, light: Light) {
    let words = ["headlight", "direction", "position"];
    let word = match light {
        Light::Headlight => "headlight",
        Light::Direction(_) => "direction",
        Light::Position(_) => "position",
    };
    // The radius is an angle or a length: it belongs to the kind of light.
    let opened = model.opened_scene().shading.light;
    let same = std::mem::discriminant(&opened) == std::mem::discriminant(&light);
    let keys: &[&str] = if same { &["shading.light"] } else { &["shading.light", "shadows.light_radius"] };
    if let Some(word) = choice_row(ui, model, keys, "light", word, &words) {
        set_light(model, light, other_kind(model, light, word));
        return;
    }
    // It may have been reset just now.
    if light != model.scene().shading.light {
        return;
    }
    match light {
        Light::Headlight => {}
        Light::Direction(direction) => along(ui, model, direction),
        Light::Position(position) => {
            let speed = 0.002 * model.extent().diagonal;
            if let Some(position) = vector(ui, model, "shading.light.position", position.to_array(), speed) {
                set_light(model, light, Light::Position(position.into()));
            }
        }
    }
}

fn set_light(model: &mut Model, before: Light, light: Light) {
    model.change(&controls::light_changes(before, light));
}

/// A light of another kind that shines from the same side.
fn other_kind(model: &Model, light: Light, word: &str) -> Light {
    let center = model.picture().map_or(DVec3::ZERO, |picture| picture.subject.bounds.center());
    let up = vertical(model);
    let along = match light {
        Light::Direction(direction) => direction.normalize_or(-DVec3::Z),
        Light::Position(position) => (center - position).normalize_or(-DVec3::Z),
        Light::Headlight => direction(FROM, up),
    };
    let short = |v: DVec3, digits: f64| (v * digits).round() / digits;
    match word {
        "direction" => Light::Direction(short(along, 1e6)),
        "position" => Light::Position(short(center - model.extent().diagonal * along, 1e3)),
        _ => Light::Headlight,
    }
}

/// Returns the reference of elevations: the scene's vertical.
pub fn vertical(model: &Model) -> Vertical {
    let known = model.picture().map(|picture| picture.subject.vertical);
    known.unwrap_or_else(|| model.scene().camera.vertical(UpAxis::Z))
}

/// A direction by its angles, and by its numbers.
fn along(ui: &mut Ui, model: &mut Model, travels: DVec3) {
    let up = vertical(model);
    let angles = angles(travels, up);
    let mut turned = angles;
    let rows = [("azimuth", 180.0, 0), ("elevation", STEEPEST, 1)];
    for (label, most, i) in rows {
        let key = format!("shading.light.{label}");
        let slider = egui::Slider::new(&mut turned[i], -most..=most).fixed_decimals(1).suffix("°");
        ui.horizontal(|ui| {
            let response = ui.add(slider.clamping(egui::SliderClamping::Edits).update_while_editing(false));
            note(model, &key, response);
            name(ui, &key, label);
        });
    }
    let numbers = vector(ui, model, "shading.light.direction", travels.to_array(), 0.005);
    let light = if turned != angles {
        Some(direction(turned, up))
    } else {
        // A vector without a direction is ignored, as happens while all three numbers are being typed.
        numbers.map(DVec3::from).filter(|v| v.try_normalize().is_some())
    };
    if let Some(light) = light {
        set_light(model, Light::Direction(travels), Light::Direction(light));
    }
}

/// The direction, to 6 decimals, of light from an azimuth and an elevation in degrees, as [`View`] counts them.
fn direction([azimuth, elevation]: [f64; 2], up: Vertical) -> DVec3 {
    let view = View { azimuth: Some(azimuth), elevation: Some(elevation), name: None };
    (view.axes(up).0 * 1e6).round() / 1e6
}

/// Azimuth, from −180 to 180, and elevation in degrees from where light along a direction comes.
fn angles(travels: DVec3, vertical: Vertical) -> [f64; 2] {
    let from = -travels.normalize_or_zero();
    let [x, y] = [from.dot(vertical.right()), from.dot(vertical.front())];
    // A vertical direction has no azimuth, and the sign of a zero would make it 180.
    let azimuth = if [x, y] == [0.0; 2] { 0.0 } else { x.atan2(y).to_degrees() };
    [azimuth, from.dot(vertical.up()).clamp(-1.0, 1.0).asin().to_degrees()]
}

/// True if the scene has a section on shadows.
pub fn has_shadows(scene: &Scene) -> bool {
    scene.method.may_take_shadows()
}

/// Draws the section on shadows.
pub fn shadows(ui: &mut Ui, model: &mut Model) {
    let mut on = model.is_given("shadows");
    let response = note(model, "shadows.method", ui.checkbox(&mut on, "cast shadows"));
    // Shadows that were switched off return with the same settings.
    let id = egui::Id::new("shadows, switched off");
    if response.changed() && on {
        let kept: Option<(Shadows, Light)> = ui.data(|data| data.get_temp(id));
        model.change(&cast(kept, model.scene().shading.light));
    } else if response.changed() {
        if let Some(shadows) = model.scene().shadows {
            ui.data_mut(|data| data.insert_temp(id, (shadows, model.scene().shading.light)));
        }
        model.set("shadows", None);
    }
    if !on {
        return;
    }
    let shading = model.scene().shading;
    if shading.model == ShadingModel::None {
        ui.weak("no shadows: shading has no model");
    } else if shading.light == Light::Headlight {
        ui.weak("no shadows: a headlight casts none; give the light a direction or a position");
    }
    let shadows = model.scene().shadows.unwrap_or_default();
    let Shadows { light_radius, .. } = shadows;
    let keys: &[&str] = match model.scene().shadows {
        // Until they are cast, the scene doesn't say what they are like.
        None => &[],
        Some(_) if light_radius > 0.0 => {
            &["light_radius", "samples", "resolution", "fill", "occlusion", "min_layer_distance"]
        }
        Some(_) => &["light_radius", "resolution", "fill", "occlusion", "min_layer_distance"],
    };
    for key in keys {
        let entry = controls::shadows(&shadows, shading.light, key, model.extent());
        row(ui, model, &format!("shadows.{key}"), &controls::label(key), entry);
    }
}

/// The changes that cast shadows, as they were under a light. Its radius is no use under a light of another kind.
fn cast(kept: Option<(Shadows, Light)>, light: Light) -> Vec<Change> {
    let (mut shadows, before) = kept.unwrap_or((Shadows::default(), light));
    if std::mem::discriminant(&before) != std::mem::discriminant(&light) {
        shadows.light_radius = 0.0;
    }
    let keys = shadows.keys().into_iter().zip(Shadows::default().keys());
    let given = keys.filter(|(key, default)| key.value != default.value).map(|(key, _)| (key.name, key.value));
    let method = ("method", Some(Setting::from("texture")));
    std::iter::once(method).chain(given).map(|(key, value)| (format!("shadows.{key}"), value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{CameraSettings, Document, Iterations, MapResolution, Overrides};

    #[test]
    fn angles_and_directions_are_the_same_light() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        for up in axes.map(|axis| Vertical::nearest(axis).unwrap()) {
            for azimuth in [-180.0f64, -90.0, -33.3, 0.0, 45.0, 179.9] {
                for elevation in [-STEEPEST, -30.0, 0.0, 60.1, STEEPEST] {
                    let [a, e] = angles(direction([azimuth, elevation], up), up);
                    // 6 decimals over the cosine of 89.9 degrees are 3·10⁻⁴, or 0.02 degrees.
                    let turn = (a - azimuth).rem_euclid(360.0);
                    assert!(
                        turn.min(360.0 - turn) < 0.04 && (e - elevation).abs() < 0.04,
                        "{a} {e}, {azimuth} {elevation}"
                    );
                }
            }
        }
        // From above and behind the front's left: it travels down, to the front's right.
        let light = direction(FROM, UpAxis::Z.into());
        assert!(light.x > 0.0 && light.y > 0.0 && light.z < 0.0, "{light}");
        assert_eq!(angles(-DVec3::Z, UpAxis::Z.into()), [0.0, 90.0]);
        // Where -Y is up, light from above travels along +Y.
        assert_eq!(angles(DVec3::Y, UpAxis::NegativeY.into()), [0.0, 90.0]);
    }

    #[test]
    fn elevations_refer_to_the_vertical_of_the_camera_or_of_the_clouds() {
        let vertical = |up, of_clouds| CameraSettings { up, ..CameraSettings::default() }.vertical(of_clouds);
        let up = |up: Option<DVec3>, of_clouds| vertical(up, of_clouds).up();
        for clouds in [UpAxis::Y, UpAxis::Z, UpAxis::NegativeY] {
            assert_eq!(up(None, clouds), clouds.direction());
            assert_eq!(up(Some(DVec3::new(1.0, 1.0, 0.0)), clouds), clouds.direction(), "between two axes");
            assert_eq!(up(Some(DVec3::new(0.1, -2.0, 0.5)), clouds), DVec3::NEG_Y);
            assert_eq!(up(Some(DVec3::new(3.0, 0.0, 1.0)), clouds), DVec3::X);
        }
        assert_eq!(vertical(Some(DVec3::X), UpAxis::Z).index(), 0);
        assert_eq!(vertical(None, UpAxis::NegativeY).index(), 1);
    }

    #[test]
    fn shadows_come_back_as_they_were() {
        let text =
            "[[cloud]]\npath = 'a.ply'\n[method]\nname = 'points'\n[shading]\nmodel = 'lambert'\nlight = [0, 0, -1]\n";
        let light = Light::Direction(-DVec3::Z);
        let soft = Shadows {
            samples: 16,
            light_radius: 12.5,
            resolution: MapResolution::Pixels(300),
            fill: Iterations::Auto,
            occlusion: Iterations::Count(3),
            min_layer_distance: Some(0.25),
        };
        for (kept, light, wanted) in [
            (None, light, Shadows::default()),
            (Some((soft, light)), light, soft),
            (Some((soft, Light::Position(DVec3::Z))), light, Shadows { light_radius: 0.0, ..soft }),
        ] {
            let mut document = Document::from_toml(text, "s.toml".as_ref(), &Overrides::default()).unwrap();
            assert_eq!(document.change(&cast(kept, light)).unwrap().shadows, Some(wanted));
        }
    }
}
