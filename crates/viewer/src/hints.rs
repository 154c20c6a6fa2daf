//! Descriptions of scene-file keys, for parts that are drawn without a [`KeyControl`](super::controls::KeyControl) of
//! their own.

use pellucid_scene::{self as scene, Method};

/// The description of a dotted key; clouds are named by number or `*`. Empty for unknown keys.
pub fn hint(key: &str) -> &'static str {
    let (table, name) = key.split_once('.').unwrap_or(("", key));
    let keys = match table {
        "method" => Method::all().iter().flat_map(Method::keys).collect(),
        _ => scene::tables()
            .into_iter()
            .find(|known| known.path.split('.').next() == Some(table))
            .map_or(vec![], |t| t.keys),
    };
    let name =
        if matches!(table, "cloud" | "clip") { name.split_once('.').map_or(name, |(_, name)| name) } else { name };
    let found = keys.into_iter().find(|key| key.name == name).map(|key| key.about);
    found.or_else(|| of_light(key)).unwrap_or_default()
}

/// Parts of a light that have controls of their own.
fn of_light(key: &str) -> Option<&'static str> {
    Some(match key {
        "shading.light.direction" => "Direction in which the light travels.",
        "shading.light.position" => "Position of the light, in world units.",
        "shading.light.azimuth" => "Direction of the light, in degrees around the vertical, from the front.",
        "shading.light.elevation" => "Height of the light, in degrees above the horizon.",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_explained_in_a_short_sentence() {
        let methods = Method::all();
        let methods = methods.iter().flat_map(Method::keys).map(|key| format!("method.{}", key.name));
        let tables = scene::tables()
            .into_iter()
            .flat_map(|table| table.keys.into_iter().map(move |key| format!("{}.{}", table.path, key.name)));
        for key in methods.chain(tables).chain(["cloud.12.opacity".to_owned()]) {
            let hint = hint(&key);
            assert!(hint.ends_with('.') && hint.len() < 130, "{key}: {hint:?}");
        }
        assert_eq!((hint("method.nonsense"), hint("cloud.0.nonsense"), hint("camera")), ("", "", ""));
    }
}
