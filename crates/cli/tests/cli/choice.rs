//! `render --max-error` and `--budget`: errors are what was promised, figures are kept, pictures say how they were
//! chosen.

use std::fs;

use pellucid_core::metrics::rmse;
use pellucid_io::output::read_image;
use serde_json::Value;
use tempfile::TempDir;

use super::render::exr;
use crate::{assert_refused, builtin, device, done, folder, has_device, inside, pellucid};

/// Renders to `name` with a cache of the folder's own; what was said.
fn render(folder: &TempDir, scene: &str, name: &str, options: &[&str]) -> String {
    let device = device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]);
    let args = [&["render", scene, "--size", "64x48", "-o", name, "-v"], options].concat();
    let cache = inside(folder, "cache");
    let output = pellucid(folder, &args).args(device).env("PELLUCID_CACHE_DIR", cache).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && output.stdout.is_empty(), "{args:?}: {said}");
    said
}

fn choice(folder: &TempDir, name: &str) -> Value {
    let (_, metadata) = exr(&inside(folder, name));
    let choice: Value = serde_json::from_str(&metadata["pellucid:choice"]).unwrap();
    assert_eq!(choice["method"].as_str(), Some(metadata["pellucid:method"].as_str()));
    choice
}

/// RMSE of two pictures.
fn error(folder: &TempDir, a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(|name| read_image(&inside(folder, name)).unwrap());
    rmse(&a.pixels, &b.pixels)
}

fn is_new(said: &str) -> bool {
    assert!(said.contains("frames rendered for it now: "), "{said}");
    !said.contains("frames rendered for it now: 0\n")
}

/// Lists that `sorted` and `abuffer` round differently.
#[test]
fn a_scene_has_the_same_method_and_bytes_whatever_the_cache_holds() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "volume", &["points=30000", "layers=400"]);
    let options = ["--method", "auto"];
    render(&folder, &scene, "fresh.exr", &options);
    render(&folder, &scene, "used.exr", &options);
    // Times of all methods on this device and scene.
    render(&folder, &scene, "chosen.exr", &[&options[..], &["--budget", "1000"]].concat());
    let said = render(&folder, &scene, "measured.exr", &options);
    assert!(said.contains("method sorted: 30000 of 30000 points are transparent"), "{said}");
    let [fresh, others @ ..] = ["fresh.exr", "used.exr", "measured.exr"].map(|name| fs::read(inside(&folder, name)));
    let fresh = fresh.unwrap();
    assert!(others.into_iter().all(|other| other.unwrap() == fresh));
    let (_, metadata) = exr(&inside(&folder, "fresh.exr"));
    assert!(metadata["pellucid:method"].contains("sorted") && !metadata.contains_key("pellucid:choice"));
}

#[test]
fn soft_spheres_have_a_choice_too() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=1500"]);
    let soft = ["--set", "method.name=soft-express", "--set", "cloud.*.field=distance-to-axis"];
    let with = |options: &[&'static str]| [&soft[..], options].concat();
    render(&folder, &scene, "exact.exr", &[&soft[2..], &["--method", "soft-base"]].concat());
    render(&folder, &scene, "chosen.exr", &with(&["--max-error", "0"]));
    assert_eq!(
        (&choice(&folder, "chosen.exr")["method"], error(&folder, "exact.exr", "chosen.exr")),
        (&"soft-base".into(), 0.0)
    );
    render(&folder, &scene, "chosen.exr", &with(&["--max-error", "0.1"]));
    assert!(error(&folder, "exact.exr", "chosen.exr") <= 0.1);
}

#[test]
fn the_error_is_kept_to() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "volume", &["layers=24", "points=3000"]);
    render(&folder, &scene, "exact.exr", &["--method", "abuffer"]);
    for most in ["0", "0.001", "0.02", "0.2"] {
        let said = render(&folder, &scene, "chosen.exr", &["--max-error", most]);
        let choice = choice(&folder, "chosen.exr");
        let limit: f64 = most.parse().unwrap();
        let rmse = error(&folder, "exact.exr", "chosen.exr");
        // Below 1e-6 it is rounding.
        assert!(rmse <= 1.1 * limit.max(1e-6), "{rmse} for {choice}");
        // The figures are those of this picture.
        assert!((choice["rmse"].as_f64().unwrap() - rmse).abs() <= 1e-9 && choice["max_error"] == limit, "{choice}");
        assert!(choice["gpu_ms"].as_f64().unwrap() > 0.0 && choice["budget_ms"].is_null(), "{choice}");
        assert!(said.contains("RMSE") && !said.contains("warning"), "{said}");

        // Rendered again as the choice says.
        let sets: Vec<&str> =
            choice["setting"].as_str().unwrap().split_whitespace().flat_map(|set| ["--set", set]).collect();
        let options = [&["--method", choice["method"].as_str().unwrap()][..], &sets].concat();
        render(&folder, &scene, "again.exr", &options);
        assert_eq!(error(&folder, "chosen.exr", "again.exr"), 0.0, "{options:?}");
    }
    // A background belongs to the error, and an image without one has another.
    render(&folder, &scene, "white.exr", &["--method", "abuffer", "--background", "1,1,1"]);
    render(&folder, &scene, "chosen.exr", &["--max-error", "0.1", "--background", "1,1,1"]);
    assert!(error(&folder, "white.exr", "chosen.exr") <= 0.11);
}

#[test]
fn measurements_are_kept_until_they_are_repeated() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "stack", &["layers=6", "size=64"]);
    let wish = ["--max-error", "0.05"];
    assert!(is_new(&render(&folder, &scene, "a.exr", &wish)));
    assert!(!is_new(&render(&folder, &scene, "b.exr", &wish)), "all is known");
    assert!(fs::read(inside(&folder, "a.exr")).unwrap() == fs::read(inside(&folder, "b.exr")).unwrap());
    assert!(is_new(&render(&folder, &scene, "b.exr", &[&wish[..], &["--recalibrate"]].concat())));
    assert!(is_new(&render(&folder, &scene, "b.exr", &[&wish[..], &["--opacity", "0.3"]].concat())), "another scene");
    // A budget beyond all times is an exact image, one below all of them the fastest and a warning.
    let said = render(&folder, &scene, "b.exr", &["--budget", "1e9"]);
    assert!(choice(&folder, "b.exr")["rmse"].as_f64().unwrap() < 1e-6 && !said.contains("warning"), "{said}");
    let said = render(&folder, &scene, "b.exr", &["--budget", "0"]);
    assert!(said.contains("warning: no setting takes at most 0 ms"), "{said}");
    let said = render(&folder, &scene, "b.exr", &["--budget", "0.0001"]);
    assert!(said.contains("; try about ") && said.contains(" pixels, or 1 of every "), "{said}");
    // The five best are listed, the chosen one first.
    let best = choice(&folder, "b.exr");
    let rows: Vec<&str> = said.lines().skip_while(|line| !line.trim_start().starts_with("setting ")).collect();
    assert!(rows.len() >= 6 && rows[1].trim_start().starts_with(best["method"].as_str().unwrap()), "{said}");
    let said = render(&folder, &scene, "b.exr", &["--budget", "0", "--max-error", "0"]);
    assert!(choice(&folder, "b.exr")["rmse"] == 0.0 && said.contains("warning: no setting with an RMSE"), "{said}");
}

#[test]
fn a_method_that_is_asked_for_keeps_its_settings_to_choose_from() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "stack", &["layers=9", "size=64"]);
    render(&folder, &scene, "a.exr", &["--max-error", "0.0001", "--method", "peel"]);
    let found = choice(&folder, "a.exr");
    assert_eq!(found["method"], "peel");
    assert!(found["rmse"].as_f64().unwrap() < 1e-4, "{found}");
    // Where there is no choice the options change nothing, and say so.
    let said = render(&folder, &scene, "b.exr", &["--max-error", "0.1", "--method", "circles"]);
    assert!(said.contains("warning: --max-error and --budget have no effect with method circles"), "{said}");
    let (_, metadata) = exr(&inside(&folder, "b.exr"));
    assert!(!metadata.contains_key("pellucid:choice"));
    done(&folder, &["render", &scene, "--size", "64x48", "-o", "c.exr", "--method", "circles"]);
    assert!(fs::read(inside(&folder, "b.exr")).unwrap() == fs::read(inside(&folder, "c.exr")).unwrap());
}

#[test]
fn wishes_that_are_no_numbers_are_refused() {
    let folder = folder();
    for option in ["--max-error", "--budget"] {
        for value in ["-1", "much", "nan"] {
            let wish = format!("{option}={value}");
            assert_refused(&folder, &["render", &wish], 2, &[option]);
        }
    }
}

#[test]
fn against_the_area_the_error_of_the_samples_counts() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "volume", &["layers=3", "points=400"]);
    render(&folder, &scene, "area.exr", &["--method", "abuffer", "--samples", "64"]);
    render(&folder, &scene, "four.exr", &["--method", "abuffer", "--samples", "4"]);
    render(&folder, &scene, "one.exr", &["--method", "abuffer"]);
    let [four, one] = ["four.exr", "one.exr"].map(|name| error(&folder, "area.exr", name));
    assert!(four < 0.7 * one, "{four} and {one}");
    // Between the two: one sample is too few, four are enough.
    let most = format!("{}", 1.01 * four);
    let asked = ["--against", "area", "--max-error", &most];
    let said = render(&folder, &scene, "chosen.exr", &asked);
    assert!(is_new(&said) && said.contains("image.samples=") && said.contains("pixel area: "), "{said}");
    let chosen = choice(&folder, "chosen.exr");
    let rmse = error(&folder, "area.exr", "chosen.exr");
    assert!(rmse <= 1.01 * four && (chosen["rmse"].as_f64().unwrap() - rmse).abs() <= 1e-9, "{rmse} for {chosen}");
    let samples = chosen["samples"].as_u64().unwrap();
    assert!((2..=4).contains(&samples) && chosen["against"] == "area", "{chosen}");
    // Rendered again as the choice says.
    let sets: Vec<&str> =
        chosen["setting"].as_str().unwrap().split_whitespace().flat_map(|set| ["--set", set]).collect();
    render(&folder, &scene, "again.exr", &[&["--method", chosen["method"].as_str().unwrap()][..], &sets].concat());
    assert_eq!(error(&folder, "chosen.exr", "again.exr"), 0.0);
    // The same again measures nothing; against the center nothing of it counts.
    assert!(!is_new(&render(&folder, &scene, "same.exr", &asked)));
    let center = render(&folder, &scene, "center.exr", &["--max-error", &most]);
    assert!(is_new(&center) && !center.contains("image.samples"), "{center}");
    let metadata = choice(&folder, "center.exr");
    assert!(metadata["samples"].is_null() && metadata["against"].is_null(), "{metadata}");
    assert!(!is_new(&render(&folder, &scene, "same.exr", &asked)));
    // Nothing but the reference itself has no error: the least one found is said.
    let said = render(&folder, &scene, "least.exr", &["--against", "area", "--max-error", "0"]);
    assert!(said.contains("no setting has an RMSE of at most 0; the most accurate one is used"), "{said}");
    let least = choice(&folder, "least.exr");
    assert_eq!(least["samples"], 32, "{least}");
    assert!(error(&folder, "area.exr", "least.exr") < four);
}

#[test]
fn the_picture_to_measure_against_is_center_or_area_and_needs_a_limit() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "volume", &["layers=3", "points=400"]);
    assert_refused(&folder, &["render", &scene, "--against", "edge", "--max-error", "0.1"], 2, &["center, area"]);
    let said = render(&folder, &scene, "plain.exr", &["--against", "area"]);
    assert!(said.contains("--against has no effect without --max-error or --budget"), "{said}");
    let said = render(&folder, &scene, "four.exr", &["--method", "abuffer", "--samples", "4"]);
    assert!(said.contains("pixel area: abuffer with 4 samples in a pixel has RMSE"), "{said}");
}
