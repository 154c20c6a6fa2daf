//! Side effects of changing a key: keys that exclude it are removed, and numbers stop where they would pass one
//! another.

use pellucid_scene::{Change, Light, Method, Setting, SoftLayout, rounded};

/// The smallest difference of threshold and modulation: a step of their sliders.
const APART: f32 = 0.001;

/// The least modulation above a threshold; 1 if none exists.
pub fn above(threshold: f32) -> f32 {
    (threshold + APART).min(1.0)
}

/// The changes that set or remove a method's key. `softness` and `lambda` replace each other, so do `modulation` and
/// the paper's layout, and `threshold` and `modulation` stop at each other.
pub fn method_changes(method: &Method, key: &str, value: Option<Setting>) -> Vec<Change> {
    let soft = method.soft();
    let modulation = soft.and_then(|soft| soft.modulation);
    let is_paper = soft.is_some_and(|soft| soft.layout == SoftLayout::Paper);
    let out = match (key, &value) {
        ("softness", Some(_)) if soft.is_some() => Some("lambda"),
        ("lambda", Some(_)) => Some("softness"),
        ("modulation", Some(_)) if is_paper => Some("layout"),
        ("layout", Some(Setting::Word(word))) if word == "paper" => Some("modulation"),
        _ => None,
    };
    let value = match (key, value, soft) {
        ("threshold", Some(Setting::Number(t)), _) => {
            let most = modulation.map_or(1.0, |most| (most - APART).max(0.0));
            Some(Setting::Number(t.min(rounded(most))))
        }
        ("modulation", Some(Setting::Number(most)), Some(soft)) => {
            Some(Setting::Number(most.max(rounded(above(soft.threshold)))))
        }
        (_, value, _) => value,
    };
    let out = out.map(|rival| (format!("method.{rival}"), None));
    out.into_iter().chain([(format!("method.{key}"), value)]).collect()
}

/// The key of a method whose value may exclude that of another one.
pub fn rival(key: &str) -> Option<&'static str> {
    Some(match key {
        "softness" => "lambda",
        "lambda" => "softness",
        "layout" | "threshold" => "modulation",
        _ => return None,
    })
}

/// The changes that give the scene another light. The radius of a light is an angle or a length, so that it goes if the
/// light becomes another kind.
pub fn light_changes(before: Light, light: Light) -> Vec<Change> {
    let (key, value) = match light {
        Light::Headlight => ("shading.light", Setting::Word("headlight".to_owned())),
        Light::Direction(direction) => ("shading.light", Setting::Numbers(direction.to_array().to_vec())),
        Light::Position(position) => ("shading.light.position", Setting::Numbers(position.to_array().to_vec())),
    };
    let same = std::mem::discriminant(&before) == std::mem::discriminant(&light);
    let radius = (!same).then(|| ("shadows.light_radius".to_owned(), None));
    let given = [("shading.light".to_owned(), None), (key.to_owned(), Some(value))];
    radius.into_iter().chain(given).collect()
}
