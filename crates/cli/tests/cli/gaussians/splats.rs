//! A few Gaussians in a file as trainers write it.

use std::fs;

use tempfile::TempDir;

use crate::inside;

/// The properties in their order: center, color, harmonics of degree 1, opacity, extents, rotation.
const PROPERTIES: [&str; 23] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "f_rest_1", "f_rest_2", "f_rest_3", "f_rest_4",
    "f_rest_5", "f_rest_6", "f_rest_7", "f_rest_8", "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
    "rot_2", "rot_3",
];

/// Writes `splats.ply`: thin Gaussians of several colors that cross in the middle, each in another direction, nearly
/// opaque.
pub fn write(folder: &TempDir) -> String {
    let names = PROPERTIES.map(|name| format!("property float {name}\n")).concat();
    let mut bytes = format!("ply\nformat binary_little_endian 1.0\nelement vertex 8\n{names}end_header\n").into_bytes();
    for index in 0..8 {
        let turn = index as f32 * 0.7;
        let center = [0.3 * turn.sin(), 0.25 * (1.7 * turn).cos(), 0.3 * (2.3 * turn).sin()];
        let color = std::array::from_fn::<f32, 3, _>(|channel| if (index >> channel) & 1 == 1 { 1.5 } else { -1.2 });
        let gloss = std::array::from_fn::<f32, 9, _>(|k| 0.3 * (turn + k as f32).sin());
        // Half of them are more opaque than 0.99.
        let opacity = if index % 2 == 0 { 7.0 } else { 0.5 };
        let extents = [0.5f32.ln(), 0.2f32.ln(), 0.04f32.ln()];
        let rotation = [turn.cos(), turn.sin(), 0.4 * (3.0 * turn).sin(), 0.3];
        let values = center.into_iter().chain(color).chain(gloss).chain([opacity]).chain(extents).chain(rotation);
        bytes.extend(values.flat_map(f32::to_le_bytes));
    }
    fs::write(inside(folder, "splats.ply"), bytes).unwrap();
    "splats.ply".to_owned()
}
