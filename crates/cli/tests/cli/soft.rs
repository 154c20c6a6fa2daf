//! Methods of soft points: what is said of how many points are soft.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::render::exr;
use crate::{builtin, device, folder, has_device, inside, run};

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
    let args = ["tradeoff", "scene.toml", "--method", "soft-base", "--quick", "--time", "20", "--json", "-o", "r"];
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

/// A of the models of one sphere of radius 1 and softness 1/2, at the distance d of the ray from its center; `flat` is
/// the distance of the center from where the ray crosses its plane.
fn alphas(d: f64, flat: f64) -> [f64; 4] {
    let half = (1.0 - d * d).max(0.0).sqrt();
    // Eq. 7 over the whole chord.
    let falling = half - if d > 0.0 { d * d * (half / d).asinh() } else { 0.0 };
    // Eq. 15, Eq. 13, Eq. 19.
    let shells = [half * (1.0 - d), half];
    let disc = if flat < 1.0 { 0.25 * ((std::f64::consts::PI * flat).cos() + 1.0) } else { 0.0 };
    let covered = |depth: f64| if d < 1.0 { 1.0 - (-depth).exp2() } else { 0.0 };
    [covered(falling), covered(shells[0]), covered(shells[1]), disc]
}

#[test]
fn the_built_in_sphere_is_soft_and_has_the_opacity_of_each_model() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "spheres", &["count=1"]);
    let models: [&[&str]; 4] = [
        &["--method", "soft-base"],
        &["--method", "soft-concentric", "--set", "method.shells=1"],
        &["--method", "soft-concentric", "--set", "method.shells=1", "--set", "method.equalize=false"],
        &["--method", "soft-express"],
    ];
    let device = device();
    let own: Vec<&str> = device.iter().flat_map(|device| ["--device", device.as_str()]).collect();
    for (model, method) in models.into_iter().enumerate() {
        let args = [&["render", &scene, "--size", "129x129", "-o", "a.exr"], method, &own].concat();
        let (status, _, stderr) = run(&folder, &args);
        assert_eq!((status, stderr.as_str()), (0, ""), "nothing is said, since all is soft");
        let (channels, _) = exr(&inside(&folder, "a.exr"));
        // From the middle pixel to the right; the eye is 5 away, and 35 degrees are seen.
        let slope = 17.5f64.to_radians().tan() / 64.5;
        for x in 0..=64u32 {
            let flat = 5.0 * slope * f64::from(x);
            let d = flat / (1.0 + (slope * f64::from(x)).powi(2)).sqrt();
            let (found, wanted) = (channels["A"][64 * 129 + 64 + x as usize], alphas(d, flat)[model]);
            // A disc of more than a pixel ends where its rim is, and the rays of other models near it are rounded.
            assert!((f64::from(found) - wanted).abs() < 2e-5, "{method:?}, {x}: {found} and not {wanted}");
        }
    }
}

#[test]
fn the_models_of_two_built_in_spheres_differ() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "spheres", &[]);
    let device = device();
    let own: Vec<&str> = device.iter().flat_map(|device| ["--device", device.as_str()]).collect();
    let picture = |method: &str| {
        let args = [&["render", &scene, "--size", "64x64", "-o", "a.exr", "--method", method], &own[..]].concat();
        assert_eq!(run(&folder, &args).0, 0);
        exr(&inside(&folder, "a.exr")).0["A"].clone()
    };
    let [base, shells, discs] = ["soft-base", "soft-concentric", "soft-express"].map(picture);
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!([apart(&base, &shells), apart(&base, &discs), apart(&shells, &discs)].iter().all(|most| *most > 0.05));
}
