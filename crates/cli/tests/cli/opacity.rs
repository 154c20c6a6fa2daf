//! `--see-through`, and what is said about pictures that are empty or opaque.

use serde_json::Value;

use super::render::exr;
use crate::{assert_refused, builtin, device, folder, has_device, inside, run};

/// Arguments of a small picture of the built-in scene `tori`.
fn tori<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["render", scene, "--size", "96x72"], more].concat()
}

/// Runs a command that succeeds; standard error.
fn said(folder: &tempfile::TempDir, args: &[&str]) -> String {
    let device = device();
    let own: Vec<&str> = device.iter().flat_map(|device| ["--device", device.as_str()]).collect();
    let (status, stdout, stderr) = run(folder, &[args, &own].concat());
    assert_eq!((status, stdout.as_str()), (0, ""), "{stderr}");
    stderr
}

#[test]
fn the_opacity_found_is_printed_and_gives_the_same_picture() {
    if !has_device() {
        return;
    }
    let folder = folder();
    builtin(&folder, "tori", &["points=3000"]);
    // A cloud without an opacity of its own.
    let scene = "tori/outer.ply";
    for method in ["auto", "abuffer", "stochastic"] {
        let found = said(
            &folder,
            &tori(scene, &["--view", "iso", "--method", method, "--see-through", "0.5", "-o", "found.exr"]),
        );
        let line = found.lines().find_map(|line| line.strip_prefix("see-through 0.5: opacity "));
        let mut words = line.expect(&found).split([' ', ',']);
        let opacity = words.next().unwrap();
        // Sparse points are kept apart.
        let factor = words.skip_while(|word| *word != "radius_factor").nth(1).unwrap();
        let factor = format!("cloud.0.radius_factor={factor}");
        let (channels, metadata) = exr(&inside(&folder, "found.exr"));
        let kept: Value = serde_json::from_str(&metadata["pellucid:see-through"]).unwrap();
        let median = kept["transmittance"].as_f64().unwrap();
        assert!((median - 0.5).abs() <= 0.005, "{kept}");
        // The median of the picture itself.
        let mut alphas: Vec<f32> = channels["A"].iter().copied().filter(|a| *a > 0.0).collect();
        alphas.sort_by(f32::total_cmp);
        let middle = f64::from(alphas[(alphas.len() - 1) / 2]) / 2.0 + f64::from(alphas[alphas.len() / 2]) / 2.0;
        assert!((1.0 - middle - median).abs() < 1e-6, "{middle}, {kept}");
        let same = ["--like", "found.exr", "--method", method];
        let given = [&same[..], &["--opacity", opacity, "--set", &factor, "-o", "given.exr"]].concat();
        said(&folder, &tori(scene, &given));
        let (given, _) = exr(&inside(&folder, "given.exr"));
        assert!(channels == given, "{method}: --opacity {opacity} gives the same picture");
    }
}

#[test]
fn empty_and_opaque_pictures_are_told() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=3000"]);
    let with = |more: &[&str]| said(&folder, &tori(&scene, &[more, &["-o", "a.png"]].concat()));
    assert_eq!(with(&["--opacity", "0"]), "warning: the picture is empty: all points have opacity 0\n");
    let away = ["--set", "camera.eye=[1000, 0, 0]", "--set", "camera.target=[2000, 0, 0]"];
    assert!(with(&away).ends_with("warning: the picture is empty: no point is in view\n"));
    let slab = with(&["--opacity", "0.9", "--radius", "0.5"]);
    assert!(slab.starts_with("nearly every covered pixel looks opaque; opacity 0."), "{slab}");
    assert!(slab.contains("--see-through 0.5 finds it"), "{slab}");
    let faint = with(&["--opacity", "1e-5"]);
    assert!(faint.starts_with("nearly every covered pixel looks empty; opacity 0."), "{faint}");
    // Nothing is said where all is as it was asked for.
    assert_eq!(with(&["--opacity", "1"]), "");
    assert!(!with(&["--method", "points", "--opacity", "0.9"]).contains("nearly every"));
}

#[test]
fn see_through_is_refused_for_methods_without_opacity() {
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=300"]);
    for method in ["circles", "points", "soft-base"] {
        let part = format!("--see-through 0.5: the opacity of points has no effect with method {method}");
        assert_refused(&folder, &["render", &scene, "--method", method, "--see-through", "0.5"], 2, &[&part]);
    }
    assert_refused(&folder, &["render", &scene, "--see-through", "1.5"], 2, &["expected a share from 0 to 1"]);
    assert_refused(&folder, &["render", &scene, "--see-through", "0.5", "--opacity", "1"], 2, &["--opacity"]);
}
