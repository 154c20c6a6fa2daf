//! Scenes that name their keys keep their bytes from version to version.

use std::path::Path;

use crate::{builtin, done, folder, has_device, inside};

/// Keys whose defaults have changed, as they were when the first pictures were made.
const NAMED: [&str; 5] = [
    "shading.model=\"none\"",
    "cloud.*.color_by=\"rgb\"",
    "cloud.*.radius_cap=0",
    "cloud.*.outliers=\"keep\"",
    // The built-in spheres had no field of their own.
    "cloud.*.field=\"uncertainty\"",
];

/// A scene, its parameter, a method, and the hash of its pixels in commit f3c18b4, before any of these keys existed but
/// the first; those of random methods from when random words began to follow from the places of points.
const PICTURES: [(&str, &str, &str, &str); 10] = [
    ("garden", "points=20000", "abuffer", "adc3965191b06eae"),
    ("garden", "points=20000", "sorted", "d2faeb0d5f061309"),
    ("garden", "points=20000", "stochastic", "dc8a1786047f867a"),
    ("garden", "points=20000", "hybrid", "939e1109219f9584"),
    ("garden", "points=20000", "circles", "4cb8c7edbe869659"),
    ("tori", "points=20000", "linked-list", "610d1dae8f225a42"),
    ("tori", "points=20000", "peel", "610d1dae8f225a42"),
    ("planes", "points=20000", "spbr", "005176e2e069b2d2"),
    ("spheres", "count=40", "soft-concentric", "a100f6b46707d9ac"),
    ("sign", "points=5000", "image-space", "1d413ca6acd1d031"),
];

/// The hash of a picture's samples, as they are in the file.
fn hash(path: &Path) -> String {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut samples).unwrap();
    blake3::hash(&samples).to_hex()[..16].to_owned()
}

#[test]
fn keep_their_bytes() {
    if !has_device() {
        return;
    }
    let mut others = Vec::new();
    for (name, parameter, method, wanted) in PICTURES {
        let folder = folder();
        let scene = builtin(&folder, name, &[parameter]);
        let mut args = vec!["render", &scene, "-q", "--size", "64x48", "--method", method, "-o", "a.png"];
        NAMED.iter().for_each(|key| args.extend(["--set", key]));
        done(&folder, &args);
        let found = hash(&inside(&folder, "a.png"));
        if found != wanted {
            others.push(format!("{name} {method}: {found}"));
        }
    }
    assert!(others.is_empty(), "{others:#?}");
}
