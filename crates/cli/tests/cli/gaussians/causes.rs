//! The table of causes of `tradeoff`.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::splats;
use crate::{done, folder, has_device, inside};

/// The report of a quick look with time for everything.
fn report(folder: &TempDir, more: &[&str]) -> Value {
    let scene = splats::write(folder);
    let args = ["tradeoff", &scene, "-q", "--size", "48x36", "-o", "report", "--quick", "--time", "900", "--json"];
    serde_json::from_str(&done(folder, &[&args[..], more].concat())).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn cause<'a>(report: &'a Value, setting: &str, against: &str) -> &'a Value {
    let found =
        report["causes"].as_array().unwrap().iter().find(|c| c["setting"] == setting && c["against"] == against);
    found.unwrap_or_else(|| panic!("{setting} in {}", report["causes"]))
}

#[test]
fn errors_of_gaussians_by_cause() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let report = report(&folder, &["--only", "abuffer", "--only", "sorted"]);
    let causes = report["causes"].as_array().unwrap();
    let settings: Vec<_> =
        causes.iter().map(|cause| cause["setting"].as_str().unwrap().replace("method.", "")).collect();
    let all = [
        "",
        "order=center",
        "order=distance",
        "alpha_min=1e-6",
        "alpha_max=1",
        "stop=1e-4",
        "kernel=ray",
        "kernel=ellipsoid",
        "kernel=ray",
        "dilation=0",
        "antialias=true",
        "name=hybrid",
        "name=hybrid core_alpha_min=0.05",
        "cloud.*.sh_degree=0",
        "image.samples=1",
        "image.samples=4",
        "image.samples=16",
    ];
    assert_eq!(settings, all);
    // The exact image is itself, and so is that of a core as long as any list. Everything else is not.
    for key in ["rmse", "flip", "max", "above_1_255"] {
        assert_eq!(number(&causes[0], key), 0.0, "{key}");
    }
    let core = cause(&report, "method.name=hybrid", "");
    assert_eq!(number(core, "max"), 0.0, "{core}");
    // Of an early end there is as much as there are pixels with so little light left.
    let others = causes[1..].iter().filter(|cause| cause["setting"] != "method.name=hybrid");
    let (ends, others): (Vec<_>, Vec<_>) = others.partition(|cause| cause["setting"] == "method.stop=1e-4");
    assert!(others.iter().all(|cause| number(cause, "rmse") > 1e-6 && number(cause, "max") > 1e-4), "{causes:#?}");
    assert!(ends.len() == 1 && number(ends[0], "max") < 0.05, "{ends:?}");
    assert!(causes.iter().all(|cause| number(cause, "gpu_ms") > 0.0 && number(cause, "times") > 0.0), "{causes:#?}");
    // `sorted` orders centers: another way to the same image.
    let sorted = report["rows"].as_array().unwrap().iter().find(|row| row["method"] == "sorted").unwrap();
    let (a, b) = (number(&sorted["errors"], "rmse"), number(cause(&report, "method.order=center", ""), "rmse"));
    assert!((a - b).abs() < 1e-5 && b > 1e-3, "{a} and {b}");

    let mut table = csv::Reader::from_path(inside(&folder, "report/causes.csv")).unwrap();
    let lines: Vec<BTreeMap<String, String>> = table.deserialize().map(Result::unwrap).collect();
    assert_eq!(lines.len(), causes.len());
    for (line, cause) in lines.iter().zip(causes) {
        assert_eq!(line["rmse"].parse::<f64>().unwrap(), number(cause, "rmse"), "{line:?}");
        assert!(line["meaning"].ends_with('.') && inside(&folder, &format!("report/{}", line["difference"])).is_file());
    }
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("Error by cause") && page.contains("frozen Jacobian"));
}

#[test]
fn settings_that_a_projection_makes_equal_have_no_error() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let flat = ["--only", "abuffer", "--set", "camera.height=2", "--set", "method.dilation=0"];
    let report = report(&folder, &flat);
    // The projection along parallel rays is exact, and so the two kernels are one.
    let ray = cause(&report, "method.kernel=ray", "");
    assert!(number(ray, "rmse") < 1e-5 && number(ray, "above_1_255") == 0.0, "{ray}");
    // Distances along parallel rays are depths.
    let [center, distance] = ["center", "distance"].map(|order| cause(&report, &format!("method.order={order}"), ""));
    assert_eq!((&center["rmse"], &center["max"]), (&distance["rmse"], &distance["max"]));
    assert!(number(center, "rmse") > 1e-3, "{center}");
}

#[test]
fn causes_are_told_and_only_where_they_are_asked_for() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = splats::write(&folder);
    let start = ["tradeoff", &scene, "-q", "--size", "24x18", "-o", "report", "--quick", "--time", "900"];
    let told = done(&folder, &[&start[..], &["--only", "abuffer"]].concat());
    assert!(told.contains("by cause: ") && told.contains("cut of faint rims"), "{told}");
    let told = done(&folder, &[&start[..], &["--only", "weighted"]].concat());
    assert!(!told.contains("by cause"), "{told}");
    let points = done(&folder, &[&start[..], &["--only", "abuffer", "--set", "cloud.*.primitive=points"]].concat());
    assert!(!points.contains("by cause"), "{points}");
}
