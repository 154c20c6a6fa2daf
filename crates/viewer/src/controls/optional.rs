//! Controls of shading, shadows and clouds.

use super::{Control, Entry, Extent, rounded, significant};
use pellucid_engine::prepare::DEFAULT_NEIGHBORS;
use pellucid_engine::scene::{CloudSettings, Light, Setting, Shading, ShadingModel, Shadows};

/// Share of the scene's diagonal that stands for a length nobody gave.
const DEFAULT_DISTANCE: f64 = 0.01;

/// d̃: by default 1% of the scene's diagonal, in world units.
pub fn layer_distance(given: Option<f32>, extent: Extent) -> Entry {
    let default = significant(DEFAULT_DISTANCE * extent.diagonal);
    let control = Control::Powers(significant(1e-5 * extent.diagonal), significant(extent.diagonal));
    let number = |x| Setting::Number(x);
    Entry::optional(control, given.map(rounded), default, number, &format!("1%: {default}"))
}

/// The control of a key of `[shading]`; `None` for `light`, which has its own.
pub fn shading(shading: &Shading, key: &str) -> Option<Entry> {
    let number = |x: f32| Setting::Number(rounded(x));
    let (control, value) = match key {
        "model" => {
            let words: &'static [&'static str] = &["none", "lambert", "phong"];
            let at = match shading.model {
                ShadingModel::None => 0,
                ShadingModel::Lambert => 1,
                ShadingModel::Phong => 2,
            };
            (Control::Choice(words), Setting::Word((*words.get(at)?).to_owned()))
        }
        "ambient" => (Control::Slider(0.0, 1.0), number(shading.ambient)),
        "diffuse" => (Control::Slider(0.0, 1.0), number(shading.diffuse)),
        "specular" => (Control::Slider(0.0, 1.0), number(shading.specular)),
        "shininess" => (Control::Powers(1.0, 1000.0), number(shading.shininess)),
        _ => return None,
    };
    Some(Entry::always((control, value)))
}

/// The control of a key of `[shadows]`; `None` for `method`, which is the table's switch.
pub fn shadows(shadows: &Shadows, light: Light, key: &str, extent: Extent) -> Option<Entry> {
    let around_direction = matches!(light, Light::Direction(_));
    let radius = if around_direction {
        Control::Slider(0.0, 45.0)
    } else {
        Control::Powers(0.0, significant(0.25 * extent.diagonal))
    };
    let (control, value) = match key {
        "samples" => (Control::Count(1, 256), Setting::Integer(shadows.samples)),
        "light_radius" => (radius, Setting::Number(rounded(shadows.light_radius))),
        "resolution" => (Control::Count(16, 8192), Setting::Integer(shadows.resolution)),
        "min_layer_distance" => return Some(layer_distance(shadows.min_layer_distance, extent)),
        _ => return None,
    };
    Some(Entry::always((control, value)))
}

/// The control of a key of a `[[cloud]]`, of those that the panel has. `own_radii`: whether the file has radii, and K that it was
/// prepared with.
pub fn cloud(
    cloud: &CloudSettings,
    key: &str,
    own_radii: bool,
    prepared: Option<usize>,
    extent: Extent,
) -> Option<Entry> {
    let number = |x| Setting::Number(x);
    Some(match key {
        "opacity" => Entry::always((Control::Slider(0.0, 1.0), Setting::Number(rounded(cloud.opacity)))),
        "radius_factor" => Entry::always((Control::Slider(0.0, 4.0), Setting::Number(rounded(cloud.radius_factor)))),
        "color" => {
            let color = cloud.color.map(|color| color.to_array().map(rounded).to_vec());
            Entry::optional(Control::Color, color, vec![1.0; 3], Setting::Numbers, "the file's")
        }
        "radius" => {
            let start = significant(0.003 * extent.diagonal);
            let control = Control::Powers(significant(1e-5 * extent.diagonal), significant(0.1 * extent.diagonal));
            let without = if own_radii { "the file's" } else { "estimated" };
            Entry::optional(control, cloud.radius.map(rounded), start, number, without)
        }
        "neighbors" => {
            let default = prepared.unwrap_or(DEFAULT_NEIGHBORS);
            let count = |k: usize| Setting::Integer(u32::try_from(k).unwrap_or(u32::MAX));
            Entry::optional(Control::Count(1, 256), cloud.neighbors, default, count, &default.to_string())
        }
        _ => return None,
    })
}
