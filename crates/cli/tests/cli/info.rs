//! `info`: what a picture could use.

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{folder, inside, pellucid, run};

/// A grid of ground with distance 0.5 at height 0, of leaves at 4 and of roofs at 2.
fn scan(folder: &TempDir, name: &str) {
    let layer = |z: f64| (0..400).map(move |i| DVec3::new(0.5 * f64::from(i % 20), 0.5 * f64::from(i / 20), z));
    let cloud = Cloud {
        positions: [0.0, 4.0, 2.0].into_iter().flat_map(layer).chain([DVec3::new(0.25, 0.0, 4.0)]).collect(),
        classification: Some([[2; 400], [5; 400], [6; 400]].concat().into_iter().chain([5]).collect()),
        intensity: Some((0..1201).map(|i| i as f32).collect()),
        ..Cloud::default()
    };
    pellucid_io::ply::write(&inside(folder, name), &cloud).unwrap();
}

#[test]
fn info_proposes_a_picture_without_a_device() {
    let folder = folder();
    scan(&folder, "my scan.ply");
    let output = pellucid(&folder, &["info", "my scan.ply"]).env("VK_DRIVER_FILES", "/nowhere.json").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{text}");
    for part in [
        "\n  attributes  classification, intensity 0 to 1200\n",
        "\n  classes       2 ground              400  33.3%  ████████\n",
        "\n                5 high-vegetation     401  33.4%  ████████\n",
        "\n  intensity   12 ",
        "\n  spacing     0.5 (",
        "\n  layers      ",
        "\n  try         pellucid render 'my scan.ply' --preset canopy\n",
    ] {
        assert!(text.contains(part), "{part:?}: {text}");
    }
}

#[test]
fn info_as_json_has_the_same_numbers() {
    let folder = folder();
    scan(&folder, "a.ply");
    let (_, text, _) = run(&folder, &["info", "--json", "a.ply"]);
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["spacing"], json!(0.5));
    assert!(value["layers"].as_f64().unwrap() > 1.0, "{text}");
    assert_eq!(value["ranges"]["intensity"], json!([0.0, 1200.0]));
    // Percentiles 1 and 99 of 0 to 1200 are 12 and 1188: 1177 values.
    let intensity = &value["histograms"]["intensity"];
    let counts: Vec<u64> =
        intensity["counts"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).collect();
    assert_eq!((&intensity["min"], &intensity["max"]), (&json!(12.0), &json!(1188.0)));
    assert_eq!((counts.len(), counts.iter().sum::<u64>()), (16, 1177));
    // PLY: Y is up, 20 rows.
    assert_eq!(value["histograms"]["height"]["max"], json!(9.5));
    assert_eq!(value["command"], json!("pellucid render a.ply --preset canopy"));
}
