//! Controls of clouds.

use super::{ControlExtent, KeyControl, Presence, entry, find};
use pellucid_scene::prepare::DEFAULT_NEIGHBORS;
use pellucid_scene::{CloudSettings, Setting};

/// The control of a key of a `[[cloud]]`, for keys in the panel. `own_radii`: true if the file has radii, and the K
/// that it was prepared with.
pub fn cloud(
    cloud: &CloudSettings,
    key: &str,
    own_radii: bool,
    prepared: Option<usize>,
    extent: ControlExtent,
) -> Option<KeyControl> {
    let key = find(cloud.keys(), key)?;
    let mut entry = entry(&key, extent)?;
    if let Presence::Optional { on, without } = &mut entry.presence {
        match key.name {
            "color" => cloud.coloring.color_by.word().clone_into(without),
            "radius_cap" => (if prepared.is_some() { "the file's" } else { "4" }).clone_into(without),
            "radius" => (if own_radii { "the file's" } else { "estimated" }).clone_into(without),
            "neighbors" => {
                let default = prepared.unwrap_or(DEFAULT_NEIGHBORS);
                *without = default.to_string();
                if !*on {
                    entry.value = Setting::Integer(u32::try_from(default).unwrap_or(u32::MAX));
                }
            }
            _ => {}
        }
    }
    Some(entry)
}

/// The key that decides how faint a cloud is, and its value.
pub fn opacity(cloud: &CloudSettings) -> (&'static str, f32) {
    cloud.surface_opacity.map_or(("opacity", cloud.opacity), |opacity| ("surface_opacity", opacity))
}
