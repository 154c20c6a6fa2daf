//! `spbr` and `spbr-simplified` from the command line.

use std::fs;

use pellucid_io::output::read_image;
use serde_json::Value;

use super::render::exr;
use crate::{assert_refused_with_device, builtin, done, folder, has_device, inside, run};

/// Scene setting that gives about 540 points over each pixel of 24 × 24, and fewer than one copy of each in 100
/// ensembles.
const DENSE: &str = "points=200000";

fn mean_alpha(channels: &std::collections::BTreeMap<String, Vec<f32>>) -> f64 {
    // The square fills the middle: 2 of 2.5 units. Some pixels inside of it.
    let inner = (0..24 * 24).filter(|i| (5..19).contains(&(i % 24)) && (5..19).contains(&(i / 24)));
    inner.map(|i| f64::from(channels["A"][i])).sum::<f64>() / 196.0
}

#[test]
fn a_plane_has_its_opacity_and_the_same_bytes_again() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &[DENSE]);
    let args = ["render", &plane, "--size", "24x24", "--method", "spbr", "--aov"];
    let render = |name: &str, more: &[&str]| {
        assert_eq!(done(&folder, &[&args[..], &["-o", name], more].concat()), "");
        fs::read(inside(&folder, name)).unwrap()
    };
    assert!(render("a.exr", &[]) == render("b.exr", &[]), "the same EXR");
    let (channels, metadata) = exr(&inside(&folder, "a.exr"));
    assert_eq!(metadata["pellucid:method"], "spbr");
    let alpha = mean_alpha(&channels);
    // sqrt(0.25 / 100 / 196) is 0.0036; the density is within a percent, as which opacities are 0.0035 off.
    assert!((alpha - 0.5).abs() < 0.016, "{alpha}");
    let error = channels["stderr.R"][12 * 24 + 12];
    assert!((error - 0.05).abs() < 0.02, "{error}");
    // 9.6 MB of points through less memory than that.
    assert!(render("m.exr", &["--memory-budget", "4MiB"]) == render("b.exr", &[]), "within a budget");
    // Another seed shuffles points into other ensembles.
    assert!(render("c.exr", &["--seed", "1"]) != render("b.exr", &[]));
    // A file in another order does not.
    let cloud =
        pellucid_io::load(&inside(&folder, "plane/plane.ply"), &pellucid_core::progress::Progress::hidden()).unwrap();
    let mut backward = cloud.clone();
    backward.positions.reverse();
    pellucid_io::ply::write(&inside(&folder, "plane/plane.ply"), &backward).unwrap();
    assert!(render("d.exr", &[]) == render("b.exr", &[]));
    // 200 000 points in 1000 ensembles, once each: 540 over a pixel make 1 − e^(−0.54).
    done(
        &folder,
        &[
            "render",
            &plane,
            "--size",
            "24x24",
            "--method",
            "spbr-simplified",
            "-o",
            "s.exr",
            "--set",
            "method.ensembles=1000",
            "--set",
            "method.brightness=1",
        ],
    );
    let alpha = mean_alpha(&exr(&inside(&folder, "s.exr")).0);
    let wanted = 1.0 - (-50_000.0 * (2.5f64 / 24.0).powi(2) / 1000.0).exp();
    assert!((alpha - wanted).abs() < 0.006, "{alpha}, {wanted}");
}

#[test]
fn plan_and_profile_know_ensembles() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &["points=5000"]);
    let args = [plane.as_str(), "--size", "24x24", "--set", "method.ensembles=10", "--opacity", "0.2"];
    for method in ["spbr", "spbr-simplified"] {
        let with = |command: &str, more: &[&str]| {
            done(&folder, &[&[command], &args[..], &["--method", method], more].concat())
        };
        let plan: Value = serde_json::from_str(&with("plan", &["--json"])).unwrap();
        let on = |step: &&Value| step["on"] == true && step["name"].as_str().unwrap().starts_with("spbr/");
        assert!(plan.as_array().unwrap().iter().filter(on).count() >= 2, "{plan:#}");
        let profile: Value = serde_json::from_str(&with("profile", &["--json", "--frames", "1"])).unwrap();
        let passes = profile["frames"][0]["passes"].as_array().unwrap();
        assert!(passes.iter().any(|pass| pass["name"].as_str().unwrap().starts_with("spbr/")), "{profile:#}");
    }
}

#[test]
fn too_few_points_for_an_opacity_are_said() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &["points=2000"]);
    let said = |options: &[&str]| {
        let args = [&["render", &plane, "--size", "96x96", "--method", "spbr", "-o", "x.png"], options].concat();
        let (code, stdout, stderr) = run(&folder, &args);
        assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
        stderr
    };
    // 0.34 points over a pixel, of which 0.69 are wanted for a half.
    let few = said(&["--set", "method.ensembles=10"]);
    assert!(few.contains("opacity 0.500 needs 2.") && few.contains("plane.ply"), "{few}");
    let copies = said(&["--opacity", "0.15"]);
    assert!(copies.contains("copies of each point"), "{copies}");
    assert_eq!(said(&["--opacity", "1"]), "");
    assert_eq!(said(&["--opacity", "0.02"]), "");
    assert_eq!(said(&["--opacity", "0.15", "-q"]), "");
}

#[test]
fn as_many_ensembles_as_an_error_needs() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &[DENSE]);
    let render = |most: &str, name: &str| {
        let args = ["render", &plane, "--size", "24x24", "--method", "spbr", "-o", name, "--max-error", most];
        let (code, _, said) = run(&folder, &args);
        assert_eq!(code, 0, "{said}");
        let (_, metadata) = exr(&inside(&folder, name));
        let choice: Value = serde_json::from_str(&metadata["pellucid:choice"]).unwrap();
        assert_eq!(choice["method"], "spbr");
        assert!(choice["rmse"].as_f64().unwrap() <= most.parse::<f64>().unwrap(), "{choice}");
        let setting = choice["setting"].as_str().unwrap().to_owned();
        setting.strip_prefix("method.ensembles=").unwrap().parse::<u32>().unwrap()
    };
    let (few, many) = (render("0.2", "few.exr"), render("0.05", "many.exr"));
    // Sixteen times as many, apart from the ladder's steps of two.
    assert!((8..=32).contains(&(many / few)), "{few} {many}");
    // Nobody else draws the image of the simplified method.
    let simplified =
        ["render", &plane, "--method", "spbr-simplified", "--max-error", "0.1", "--size", "24x24", "-o", "s.exr"];
    let (code, _, said) = run(&folder, &simplified);
    assert!(code == 0 && said.contains("no effect with method spbr-simplified"), "{said}");
}

#[test]
fn the_error_falls_as_one_over_the_root_of_ensembles() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &[DENSE]);
    let args = [
        "tradeoff", &plane, "--size", "24x24", "--method", "spbr", "--quick", "--time", "900", "--json", "-o", "report",
    ];
    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    let rows = report["rows"].as_array().unwrap();
    let of = |row: &Value, path: &str| {
        row.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} of {row}"))
    };
    let errors: Vec<f64> = rows.iter().map(|row| of(row, "/errors/rmse")).collect();
    assert_eq!(
        rows.iter().map(|row| row["setting"].as_str().unwrap()).collect::<Vec<_>>(),
        ["method.ensembles=1", "method.ensembles=10", "method.ensembles=100"]
    );
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((ratio / 10f64.sqrt() - 1.0).abs() < 0.15, "{errors:?}");
    }
    for row in rows {
        // The difference of the mean over seeds from the reference is noise.
        assert!(of(row, "/repeats/bias") < 1.5 * of(row, "/repeats/bias_floor"), "{row}");
    }
    let slope = of(&report["convergence"][0], "/rmse/exponent");
    assert!((slope + 0.5).abs() < 0.06, "{}", report["convergence"]);
    assert!(report["reference"]["method"].as_str().unwrap().contains("float64"), "{}", report["reference"]);
    let picture = read_image(&inside(&folder, "report/reference.png")).unwrap();
    assert_eq!((picture.width, picture.height), (24, 24));
    let simplified = ["tradeoff", &plane, "--method", "spbr-simplified", "-o", "other"];
    assert_refused_with_device(&folder, &simplified, 2, &["spbr-simplified", "--method spbr numbers of ensembles"]);
}
