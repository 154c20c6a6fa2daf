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

/// The figures of Tanaka et al. 2016, Table 1, of a plane with 50 000 points on each unit of area. Its density is
/// estimated to a percent.
#[test]
fn k_of_a_plane_is_n_l_over_n_raw_in_memory_and_from_a_store() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &[DENSE]);
    done(&folder, &["prepare", "plane/plane.ply", "-o", "store/"]);
    let text = fs::read_to_string(inside(&folder, &plane)).unwrap();
    fs::write(inside(&folder, "stored.toml"), text.replace("plane.ply", "store")).unwrap();
    let figures = |scene: &str, method: &str, size: &str, more: &[&str]| -> Value {
        let args = ["profile", scene, "--method", method, "--size", size, "--json", "--frames", "1"];
        let profile: Value = serde_json::from_str(&done(&folder, &[&args[..], more].concat())).unwrap();
        let clouds = profile["ensembles"]["clouds"].as_array().unwrap();
        assert_eq!((&profile["ensembles"]["L"], clouds.len()), (&Value::from(100), 1), "{profile}");
        assert_eq!(clouds[0]["points"], 200_000);
        clouds[0].clone()
    };
    let assert_near = |cloud: &Value, key: &str, wanted: f64| {
        let found = cloud[key].as_f64().unwrap_or_else(|| panic!("{key} of {cloud}"));
        assert!((found / wanted - 1.0).abs() < 0.01, "{key}: {found} for {wanted}");
    };
    for scene in [plane.as_str(), "stored.toml"] {
        for (pixels, alpha) in [(24, 0.5f64), (100, 0.9)] {
            let size = format!("{pixels}x{pixels}");
            let cloud = figures(scene, "spbr", &size, &["--opacity", &alpha.to_string()]);
            // The picture is 2.5 units high.
            let n_raw = 50_000.0 * (2.5 / f64::from(pixels)).powi(2);
            let k = -100.0 * (1.0 - alpha).ln() / n_raw;
            for (key, wanted) in
                [("n_raw", n_raw), ("k", k), ("adjusted", k * 200_000.0), ("alpha", alpha), ("asked", alpha)]
            {
                assert_near(&cloud, key, wanted);
            }
            let name = cloud["cloud"].as_str().unwrap();
            assert!(name.ends_with(if scene == "stored.toml" { "store" } else { "plane.ply" }), "{name}");
        }
        // Every point once: a hundredth of 542.5 points lies on a pixel of an ensemble.
        let cloud = figures(scene, "spbr-simplified", "24x24", &["--set", "method.brightness=1"]);
        assert_near(&cloud, "alpha", 1.0 - (-5.425_347f64).exp());
        assert_eq!((&cloud["adjusted"], &cloud["k"]), (&Value::from(200_000), &Value::from(1.0)));
        assert!(cloud["asked"].is_null());
    }
}

#[test]
fn the_figures_of_table_1_are_told() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let plane = builtin(&folder, "plane", &[DENSE]);
    let args = [plane.as_str(), "--size", "24x24", "--method", "spbr", "--opacity", "0.5"];
    let (code, _, said) = run(&folder, &[&["render", "-v", "-o", "a.png", "--profile", "p.json"], &args[..]].concat());
    assert_eq!(code, 0, "{said}");
    let profile: Value = serde_json::from_str(&fs::read_to_string(inside(&folder, "p.json")).unwrap()).unwrap();
    let line =
        said.lines().find(|line| line.contains("plane.ply: α 0.5, L 100, n_raw 5")).unwrap_or_else(|| panic!("{said}"));
    let k: f64 = line.rsplit_once(", k ").unwrap().1.parse().unwrap();
    assert!((k / profile["ensembles"]["clouds"][0]["k"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{line}");
    assert!(said.contains("adjustment of the numbers of points: "), "{said}");
    let table = done(&folder, &[&["profile", "--frames", "1"], &args[..]].concat());
    let told = line.split_once("plane.ply").unwrap().1;
    assert!(table.contains(told) && table.contains("adjustment of the numbers of points: "), "{table}");
    // A single point has no density, and a method without ensembles no figures.
    let point = builtin(&folder, "plane", &["points=1"]);
    let (_, _, said) = run(&folder, &["render", "-v", &point, "--size", "24x24", "--method", "spbr", "-o", "b.png"]);
    assert!(said.contains("n_raw unknown on a pixel, points 1 adjusted to 100, k 100"), "{said}");
    let (_, _, said) = run(&folder, &["render", "-v", &plane, "--size", "24x24", "--method", "points", "-o", "c.png"]);
    assert!(!said.contains("n_raw"), "{said}");
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
