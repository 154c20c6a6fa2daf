//! Methods of soft points: what is said of how many points are soft.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::{device, folder, has_device, inside, run};

/// A scene of four points whose field is 0.125, 0.25, 0.375 and 0.5.
fn scene() -> TempDir {
    let folder = folder();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  property float radius\nproperty float doubt\nend_header\n";
    let points = [0.125, 0.25, 0.375, 0.5].map(|doubt| format!("{} 0 0 0.5 {doubt}\n", 4.0 * doubt));
    fs::write(inside(&folder, "four.ply"), format!("{header}{}", points.concat())).unwrap();
    let text = "[camera]\neye = [1, 0, 5]\ntarget = [1, 0, 0]\n[[cloud]]\npath = \"four.ply\"\nfield = \"doubt\"\n";
    fs::write(inside(&folder, "scene.toml"), text).unwrap();
    folder
}

/// Runs a command on a small picture of the scene; standard output and standard error.
fn said(folder: &TempDir, args: &[&str]) -> (String, String) {
    let device = device();
    let own: Vec<&str> = device.iter().flat_map(|device| ["--device", device.as_str()]).collect();
    let (status, stdout, stderr) = run(folder, &[args, &["--size", "24x16"], &own].concat());
    assert_eq!(status, 0, "{stderr}");
    (stdout, stderr)
}

const SOFT: [&str; 4] = ["soft-base", "soft-concentric", "soft-express", "one-layer"];

#[test]
fn a_soft_method_without_soft_points_tells_count_threshold_and_the_ends_of_the_field() {
    if !has_device() {
        return;
    }
    let folder = scene();
    let wanted = "0 of 4 points are soft, so that all are drawn solid: none has a field F above method.threshold = 0.5; F goes \
                  from 0.125 to 0.5; a threshold below 0.5 makes some soft";
    for method in SOFT {
        let (_, render) = said(&folder, &["render", "scene.toml", "--method", method, "-o", "a.png"]);
        assert_eq!(render.matches(wanted).count(), 1, "{method}: {render}");
        let (plan, warned) = said(&folder, &["plan", "scene.toml", "--method", method]);
        assert_eq!((plan.matches(wanted).count(), warned.matches(wanted).count()), (1, 1), "{method}: {plan}{warned}");
    }
    let (_, other) = said(&folder, &["render", "scene.toml", "--method", "splats", "-o", "a.png"]);
    assert!(!other.contains("points are soft"), "{other}");
}

#[test]
fn a_verbose_picture_tells_how_many_points_are_soft() {
    if !has_device() {
        return;
    }
    let folder = scene();
    for method in SOFT {
        let quarter = ["--method", method, "--set", "method.threshold=0.25"];
        let (_, plain) = said(&folder, &[&["render", "scene.toml", "-o", "a.png"], &quarter[..]].concat());
        assert!(!plain.contains("soft"), "{method}: {plain}");
        let (_, verbose) = said(&folder, &[&["render", "-v", "scene.toml", "-o", "a.png"], &quarter[..]].concat());
        let wanted = "2 of 4 points are soft (F above 0.25; F goes from 0.125 to 0.5)";
        assert_eq!(verbose.matches(wanted).count(), 1, "{method}: {verbose}");
    }
}

#[test]
fn models_are_not_judged_where_nothing_is_soft() {
    if !has_device() {
        return;
    }
    let folder = scene();
    let args = ["tradeoff", "scene.toml", "--method", "soft-base", "--quick", "--time", "20", "--json", "-o", "report"];
    let (stdout, stderr) = said(&folder, &args);
    assert!(stderr.contains("0 of 4 points are soft"), "{stderr}");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let findings = report["findings"].as_array().unwrap();
    assert_eq!(findings.len(), 5, "{report}");
    for finding in findings {
        let measured = finding["measured"].as_str().unwrap();
        assert!(finding["holds"].is_null() && measured.starts_with("nothing was soft: 0 of 4"), "{finding}");
    }
}
