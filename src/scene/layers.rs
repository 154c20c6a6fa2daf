//! What is said of the distance of layers.

use super::settings::Scene;
use crate::points::Points;
use crate::prepare::layer_distance;

/// Says if the default of `method.min_layer_distance`, where that is in force, differs from what the points' spacing suggests
/// ([`layer_distance::suggest`]) by a factor of more than 3.
pub fn note_of_layers(scene: &Scene, points: &Points) -> Option<String> {
    scene.method.filters().filter(|filters| filters.min_layer_distance.is_none())?;
    let default = 0.01 * points.bounds()?.diagonal();
    let suggested = layer_distance::suggest(points)?;
    let is_near = (suggested / 3.0..=suggested * 3.0).contains(&default);
    let (default, suggested) = (two_digits(default), two_digits(suggested));
    let says = "method.min_layer_distance is 1% of the scene's diagonal";
    (!is_near).then(|| format!("{says}, {default}; the points' spacing suggests {suggested}"))
}

/// A positive number to two significant digits.
fn two_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    if (1e-4..1e6).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::two_digits;

    #[test]
    fn numbers_are_short() {
        for (value, wanted) in
            [(0.034_41, "0.034"), (1234.5, "1200"), (0.999, "1"), (3.14e-7, "3.1e-7"), (2.55e9, "2.5e9")]
        {
            assert_eq!(two_digits(value), wanted);
        }
    }
}
