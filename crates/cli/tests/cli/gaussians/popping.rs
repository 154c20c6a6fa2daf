//! Popping along a path, of Gaussians and of discs.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::splats;
use crate::{assert_refused, builtin, done, folder, has_device, inside};

type Line = BTreeMap<String, String>;

fn lines(folder: &TempDir, name: &str) -> Vec<Line> {
    csv::Reader::from_path(inside(folder, name)).unwrap().deserialize().map(Result::unwrap).collect()
}

fn numbers(lines: &[Line], column: &str) -> Vec<Option<f64>> {
    lines.iter().map(|line| line[column].parse().ok()).collect()
}

fn curve<'a>(report: &'a Value, method: &str, setting: &str) -> &'a Value {
    let curves = report["popping"]["curves"].as_array().unwrap();
    let is_it = |curve: &&Value| curve["method"] == method && curve["setting"] == setting;
    curves.iter().find(is_it).unwrap_or_else(|| panic!("{method} {setting} in {curves:?}"))
}

#[test]
fn centers_pop_and_exact_methods_do_not() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = splats::write(&folder);
    let start = ["tradeoff", &scene, "-q", "--size", "48x36", "-o", "report", "--quick", "--time", "900", "--json"];
    let only = ["--only", "sorted", "--only", "linked-list", "--only", "weighted"];
    let args = [&start[..], &only, &["--turntable", "--frames", "5"]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    assert_eq!((&report["popping"]["exact"], &report["popping"]["frames"]), (&"abuffer order=pixel".into(), &5.into()));
    let figures = |curve: &Value| ["mean_rmse", "worst_rmse", "mean_flip"].map(|key| curve[key].as_f64().unwrap());
    // The same image by other means.
    assert!(figures(curve(&report, "linked-list", "")).iter().all(|figure| *figure < 1e-5), "{report}");
    for (method, setting) in [("sorted", "method.order=center"), ("sorted", "method.order=distance"), ("weighted", "")]
    {
        let [mean, worst, flip] = figures(curve(&report, method, setting));
        assert!(mean > 1e-3 && worst >= mean && flip > 1e-4, "{method} {setting}: {mean} {worst} {flip}");
    }
    let table = lines(&folder, "report/popping.csv");
    assert_eq!(table.len(), 4 * 5);
    assert_eq!(numbers(&table[..5], "popping_rmse")[0], None, "nothing is before the first frame");
    assert!(numbers(&table[1..5], "popping_flip").iter().all(Option::is_some), "{table:?}");
    for name in ["popping.svg", "popping-flip.svg"] {
        assert!(
            fs::read_to_string(inside(&folder, &format!("report/{name}"))).unwrap().contains("sorted order=center")
        );
    }
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("<h2>Popping</h2>") && page.contains("does not pop"));
}

/// Methods that fade with depth and methods that keep a few layers are followed like the others, each with its
/// defaults.
#[test]
fn approximations_are_followed_along_a_path_of_discs() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=1500"]);
    let start = ["tradeoff", &scene, "-q", "--size", "48x32", "-o", "report", "--quick", "--time", "900", "--json"];
    let methods = ["moments", "wavelet", "mlab", "abuffer"];
    let only = methods.map(|method| ["--only", method]).concat();
    let args = [&start[..], &only, &["--opacity", "0.4", "--turntable", "--frames", "4"]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    let curves = report["popping"]["curves"].as_array().unwrap();
    assert_eq!((curves.len(), &report["popping"]["refused"]), (4, &Value::Array(Vec::new())));
    for method in methods {
        let curve = curve(&report, method, "");
        let errors: Vec<f64> =
            curve["frames"].as_array().unwrap().iter().map(|frame| frame["error"].as_f64().unwrap()).collect();
        let changes = curve["mean_rmse"].as_f64().unwrap();
        assert_eq!(errors.len(), 4);
        // The error of another frame is another one, of what has an error.
        let has_error = method != "abuffer";
        assert!((errors.iter().all(|e| *e > 1e-6) && changes > 1e-6) == has_error, "{method}: {errors:?} {changes}");
    }
    assert_eq!(lines(&folder, "report/popping.csv").len(), 4 * 4);
}

#[test]
fn a_rendered_path_tells_how_it_pops() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=1500"]);
    let start = ["render", &scene, "-q", "--size", "48x32", "--turntable", "--frames", "4", "-o", "f_%d.exr"];
    let weighted = [&start[..], &["--method", "weighted", "--popping", "a.csv"]].concat();
    done(&folder, &weighted);
    let first = lines(&folder, "a.csv");
    assert_eq!(first.iter().map(|line| line["frame"].as_str()).collect::<Vec<_>>(), ["0", "1", "2", "3"]);
    let changes = numbers(&first, "popping_rmse");
    assert!(changes[0].is_none() && changes[1..].iter().all(|change| change.unwrap() > 1e-4), "{changes:?}");
    // Frames that are there stay, and tell the same.
    let before = fs::metadata(inside(&folder, "f_0.exr")).unwrap().modified().unwrap();
    fs::remove_file(inside(&folder, "a.csv")).unwrap();
    done(&folder, &weighted);
    assert_eq!(lines(&folder, "a.csv"), first);
    assert_eq!(fs::metadata(inside(&folder, "f_0.exr")).unwrap().modified().unwrap(), before);
    // The exact method against itself.
    done(&folder, &[&start[..], &["--overwrite", "--method", "abuffer", "--popping", "b.csv"]].concat());
    let same = lines(&folder, "b.csv");
    assert!(numbers(&same[1..], "popping_rmse").iter().chain(&numbers(&same, "error_rmse")).all(|e| *e == Some(0.0)));
}

/// Circles of the sign change their order as the camera turns, and the report says so.
#[test]
fn opaque_points_are_followed_against_their_surfaces() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "sign", &["points=4000"]);
    let key = |x: f64| serde_json::json!({"eye": [x, -0.4, 2.3], "target": [0.07, 0.02, 0.0]});
    let path = serde_json::json!({"version": 1, "keys": [key(0.7), key(0.4)]});
    fs::write(inside(&folder, "path.json"), path.to_string()).unwrap();
    let start = ["tradeoff", &scene, "-q", "--size", "60x40", "-o", "report", "--quick", "--time", "900", "--json"];
    let methods = ["points", "squares", "circles", "paraboloid", "hqs"];
    let only = methods.map(|method| ["--only", method]).concat();
    let args = [&start[..], &only, &["--method", "points", "--path", "path.json", "--frames", "8"]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    assert_eq!(report["popping"]["exact"], "splats with 4 × 4 samples in a pixel");
    let figure = |method: &str, key: &str| curve(&report, method, "")[key].as_f64().unwrap();
    for method in methods {
        assert!(figure(method, "mean_rmse") > 1e-3 && figure(method, "rolled_rmse") > 1e-3, "{report}");
    }
    assert!(figure("circles", "mean_rmse") > figure("paraboloid", "mean_rmse"), "{report}");
    let findings = report["findings"].as_array().unwrap();
    let finding = findings.iter().find(|finding| finding["claim"].as_str().unwrap().contains("flicker")).unwrap();
    assert!(finding["measured"].as_str().unwrap().contains("circles ") && finding["holds"].is_boolean(), "{finding}");
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("rolls about its own axis"));
}

#[test]
fn popping_without_a_path_or_an_exact_method_is_refused() {
    let folder = folder();
    let scene = splats::write(&folder);
    let tradeoff = ["tradeoff", &scene, "-q", "-o", "report"];
    let with = |more: &[&'static str]| [&tradeoff[..], more].concat();
    assert_refused(&folder, &with(&["--frames", "3"]), 2, &["--frames 3 needs --path or --turntable"]);
    assert_refused(&folder, &with(&["--turntable"]), 2, &["--turntable needs the number of its frames"]);
    let filtered = with(&["--turntable", "--frames", "3", "--method", "peel-layers"]);
    assert_refused(&folder, &filtered, 2, &[", not of peel-layers"]);
    assert_refused(&folder, &["render", &scene, "--popping", "a.csv"], 2, &["--popping needs --path or --turntable"]);
}
