//! Gaussian splats in PLY files: discs of the color, opacity and size that they have on average.

use glam::{DVec3, Vec3};
use pellucid_engine::color::decode_srgb;

use super::load_bytes;

const PROPERTIES: [&str; 21] = [
    "x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "f_rest_1", "f_rest_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "time",
];

fn file(properties: &[&str], rows: &str) -> String {
    let lines: Vec<_> = properties.iter().map(|name| format!("property float {name}\n")).collect();
    let count = rows.lines().count();
    format!("ply\nformat ascii 1.0\nelement vertex {count}\n{}end_header\n{rows}", lines.concat())
}

#[test]
fn splats_become_discs() {
    // The harmonic times ±0.5/0.2820948 is ±0.5; logit 0 is one half; ln 2, ln 4 and ln 8 have the mean ln 4.
    let rows = "1 2 3 0 0 0 1.772453851 -1.772453851 0 9 9 9 0 0.693147181 1.386294361 2.079441542 1 0 0 0 7\n\
                4 5 6 0 0 0 99 -99 0.886226925 9 9 9 -800 0 0 0 1 0 0 0 8\n";
    let cloud = load_bytes("a.ply", file(&PROPERTIES, rows)).unwrap();
    assert_eq!(cloud.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
    // Coefficients of ten digits, and the slope of the decoding is at most 2.3.
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-6, "{a}, not {b}");
    let colors = cloud.colors.unwrap();
    near(colors[0], Vec3::new(1.0, 0.0, decode_srgb(0.5)));
    near(colors[1], Vec3::new(1.0, 0.0, decode_srgb(0.75)));
    assert_eq!(cloud.alphas.unwrap(), [0.5, 0.0]);
    let radii = cloud.radii.unwrap();
    assert!((radii[0] - 8.0).abs() < 1e-5 && radii[1] == 2.0, "{radii:?}");
    assert_eq!(cloud.normals, None, "all zero");
    assert_eq!(cloud.scalars, [("time".to_owned(), vec![7.0, 8.0])]);
    let [warning] = cloud.warnings.as_slice() else { panic!("{:?}", cloud.warnings) };
    assert!(warning.contains("Gaussian splats") && warning.contains("left out"), "{warning}");
}

#[test]
fn other_points_stay_what_they_are() {
    // Without rotations these are the scalars that they are called.
    let properties: Vec<_> = PROPERTIES.into_iter().filter(|name| !name.starts_with("rot_")).collect();
    let row = "1 2 3 0 0 1 4 5 6 9 9 9 0.25 10 11 12 7\n";
    let cloud = load_bytes("a.ply", file(&properties, row)).unwrap();
    assert_eq!((cloud.colors, cloud.alphas, cloud.radii, cloud.warnings.len()), (None, None, None, 0));
    assert_eq!((cloud.normals.unwrap(), cloud.scalars.len()), (vec![Vec3::Z], 11));
}
