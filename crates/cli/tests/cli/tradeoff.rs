//! `tradeoff`: its files, its front, and what an interrupted run leaves.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::{assert_refused, builtin, device, done, folder, has_device, inside, pellucid, run};

const PARTIAL: &str = "report/tradeoff.partial.json";

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn json(folder: &TempDir, name: &str) -> Option<Value> {
    serde_json::from_slice(&fs::read(inside(folder, name)).ok()?).ok()
}

/// Flat discs in a few layers.
fn tori(folder: &TempDir) -> String {
    builtin(folder, "tori", &["points=1500"])
}

/// A quick look with time for everything, on a busy machine, too.
const QUICK: [&str; 6] = ["-o", "report", "--quick", "--time", "900", "--json"];

fn args(scene: &str) -> Vec<&str> {
    let flat = ["--set", "method.shape=flat", "--set", "method.falloff=flat"];
    [&["tradeoff", scene, "--size", "48x32"], &QUICK[..], &flat].concat()
}

fn assert_row(folder: &TempDir, row: &Value) {
    let errors = &row["errors"];
    let exact = ["abuffer", "linked-list", "sorted"].contains(&text(row, "method"))
        || (text(row, "method"), text(row, "setting")) == ("peel", "");
    assert_eq!(number(errors, "rmse") < 1e-6, exact, "{row}");
    assert!(!exact || number(errors, "max") < 1e-5 && number(errors, "ssim") > 0.999_999, "{row}");
    for time in ["gpu_ms", "wall_ms"] {
        let [min, median, max] = ["min", "median", "max"].map(|key| number(&row[time], key));
        assert!(0.0 < min && min <= median && median <= max, "{row}");
    }
    assert_eq!(row["frames"], 3, "{row}");
    assert!(number(row, "peak_device_bytes") > 0.0 && !row["passes"].as_array().unwrap().is_empty());
    assert_eq!(row["stochastic"], text(row, "method") == "stochastic");
    if let Some(repeats) = row["repeats"].as_object() {
        let [seeds, noise, floor] = ["seeds", "noise", "bias_floor"].map(|key| repeats[key].as_f64().unwrap());
        assert!(seeds >= 2.0 && noise > 0.0 && (floor - noise / seeds.sqrt()).abs() < 1e-9 * noise, "{row}");
    }
    assert_eq!(row["repeats"].is_object(), row["stochastic"] == true);
    for key in ["picture", "difference"] {
        let picture = pellucid_io::output::read_image(&inside(folder, &format!("report/{}", text(row, key)))).unwrap();
        assert_eq!((picture.width, picture.height), (48, 32));
    }
}

/// Asserts that the front is what no row beats.
fn assert_front(rows: &[Value]) {
    let place = |row: &Value| (number(&row["gpu_ms"], "median"), number(&row["errors"], "rmse"));
    for row in rows {
        let (ms, rmse) = place(row);
        let beats = |other: &Value| {
            let (other_ms, other_rmse) = place(other);
            other_ms <= ms && other_rmse <= rmse && (other_ms < ms || other_rmse < rmse)
        };
        assert_eq!(row["front"], !rows.iter().any(beats), "{row}");
    }
}

#[test]
fn a_report_holds_every_setting_once() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let report: Value = serde_json::from_str(&done(&folder, &args(&scene))).unwrap();
    assert_eq!(Some(&report), json(&folder, "report/tradeoff.json").as_ref());
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains(text(&report, "device")) && page.contains("<svg"));
    assert!(!inside(&folder, PARTIAL).exists(), "nothing is left to go on with");

    let rows = report["rows"].as_array().unwrap();
    rows.iter().for_each(|row| assert_row(&folder, row));
    assert_front(rows);
    let key = |value: &Value| (text(value, "method").to_owned(), text(value, "setting").to_owned());
    let skipped = report["skipped"].as_array().unwrap();
    assert!(skipped.iter().all(|skipped| !text(skipped, "reason").is_empty()));
    let mut keys: Vec<_> = rows.iter().chain(skipped).map(key).collect();
    let count = keys.len();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), count, "each setting once");
    let names = [
        "abuffer",
        "linked-list",
        "sorted",
        "peel",
        "stochastic",
        "hybrid",
        "mlab",
        "moments",
        "wavelet",
        "weighted",
        "average",
        "unsorted",
    ];
    for name in names.iter().chain(&["points", "squares", "circles"]) {
        assert!(keys.iter().any(|(method, _)| method == name), "{name} is measured or listed as skipped: {keys:?}");
    }
    let reference = &report["reference"];
    assert_eq!(reference["checked_pixels"], 256);
    assert!(number(reference, "largest_error") < 1e-5, "{reference}");
    assert!(number(&report, "fragments") > 500.0 && number(&report, "points") > 1000.0, "{report}");
    assert_eq!(report["sittings"], 1);

    let mut table = csv::Reader::from_path(inside(&folder, "report/tradeoff.csv")).unwrap();
    let lines: Vec<BTreeMap<String, String>> = table.deserialize().map(Result::unwrap).collect();
    assert_eq!(lines.len(), rows.len() + skipped.len());
    for (line, row) in lines.iter().zip(rows) {
        assert_eq!((line["method"].clone(), line["setting"].clone()), key(row));
        let is = |column: &str, value: f64| (line[column].parse::<f64>().unwrap() - value).abs() <= 1e-12 * value;
        assert!(is("gpu_ms_median", number(&row["gpu_ms"], "median")) && is("rmse", number(&row["errors"], "rmse")));
    }
}

#[test]
fn a_quick_look_leaves_out_what_does_not_fit() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let args = ["tradeoff", &scene, "--size", "48x32", "-o", "report", "--quick", "--time", "0.001", "--json"];
    let (code, stdout, stderr) = run(&folder, &args);
    assert_eq!(code, 0, "{stderr}");
    let report: Value = serde_json::from_str(&stdout).unwrap();
    let rows = report["rows"].as_array().unwrap();
    // The first setting is measured whatever the time, so that there is a report.
    assert_eq!(rows.iter().map(|row| text(row, "method")).collect::<Vec<_>>(), ["abuffer"], "{rows:?}");
    assert_eq!((&rows[0]["frames"], &rows[0]["front"]), (&1.into(), &true.into()));
    let (late, others): (Vec<&Value>, Vec<&Value>) =
        report["skipped"].as_array().unwrap().iter().partition(|skipped| skipped["for_time"] == true);
    for method in [
        "linked-list",
        "sorted",
        "peel",
        "stochastic",
        "hybrid",
        "mlab",
        "moments",
        "wavelet",
        "weighted",
        "average",
        "unsorted",
    ] {
        assert!(late.iter().any(|skipped| text(skipped, "method") == method), "{method}: {late:?}");
    }
    assert!(late.iter().all(|skipped| text(skipped, "reason").contains(" s are left of 0.001 s")), "{late:?}");
    assert!(others.iter().any(|skipped| text(skipped, "method") == "splats"), "another image: {others:?}");
    let told = format!("{} setting(s) left out for lack of time (--time): ", late.len());
    assert!(stderr.contains(&told) && stderr.contains("linked-list, sorted, peel layers=1"), "{stderr}");
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains(&format!("{} settings were left out because of the time", late.len())));
}

#[test]
fn only_some_methods_and_opaque_points() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    // Opaque: circles draws the same image.
    let options = ["--opacity", "1", "--only", "circles", "--only", "peel", "--seed", "3"];
    let report: Value = serde_json::from_str(&done(&folder, &[args(&scene), options.to_vec()].concat())).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| ["circles", "peel"].contains(&text(row, "method"))), "{rows:?}");
    let circles = rows.iter().find(|row| row["method"] == "circles").unwrap();
    assert!(number(&circles["errors"], "rmse") < 1e-6, "{circles}");
}

#[test]
fn the_models_of_soft_spheres() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let soft =
        ["--method", "soft-concentric", "--set", "method.threshold=0.4", "--set", "cloud.*.field=distance-to-axis"];
    // Quiet: the scene's shape and falloff have no effect.
    let args = [&["tradeoff", &scene, "-q", "--size", "48x32"], &QUICK[..]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &[&args[..], &soft].concat())).unwrap();
    assert!(text(&report["reference"], "method").contains("float64"), "{report}");
    let list = |key: &str| report[key].as_array().unwrap().clone();
    let key = |entry: &Value| format!("{} {}", text(entry, "method"), text(entry, "setting"));
    let paper = "soft-base method.layout=paper";
    let (packed, rows): (Vec<Value>, Vec<Value>) = list("rows").into_iter().partition(|row| key(row) == paper);
    let skipped: Vec<String> = list("skipped").iter().map(key).collect();
    assert!(packed.len() == 1, "{report}");
    assert!(skipped.contains(&"one-layer ".into()) && skipped.contains(&"splats ".into()), "{skipped:?}");
    let expected = [
        "soft-base ",
        "soft-concentric method.shells=1",
        "soft-concentric method.shells=4",
        "soft-concentric method.shells=adaptive",
        "soft-concentric method.shells=1 method.equalize=false",
        "soft-concentric method.shells=4 method.equalize=false",
        "soft-concentric method.shells=adaptive method.equalize=false",
        "soft-express ",
    ];
    assert_eq!(rows.iter().map(key).collect::<Vec<_>>(), expected);
    let rmse = |row: &Value| number(&row["errors"], "rmse");
    // The models differ; the exact one is the reference apart from rounding.
    assert!(rmse(&rows[0]) < 2e-5, "{report}");
    assert!(packed.iter().chain(&rows[1..]).all(|row| rmse(row) > rmse(&rows[0]) && rmse(row) < 0.3), "{report}");
    // Shells take room, and so does what the paper stores; a presorted order takes none.
    assert!(number(&packed[0], "fragment_bytes") > number(&rows[0], "fragment_bytes"), "{report}");
    let lists: Vec<f64> = rows.iter().map(|row| number(row, "fragment_bytes")).collect();
    assert!(lists[2] > lists[1] && lists[7] == 0.0, "{lists:?}");
    assert_eq!(list("findings").len(), 5, "{report}");
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("Section 5.2") && page.contains("in float64"));
}

#[test]
fn ensembles_of_planes_against_alpha_blending() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let sets = ["planes=2", "points=20000", "size=32", "opacity=0.4", "back=0.6"];
    let scene = builtin(&folder, "planes", &sets);
    let report = |more: &[&str]| -> Value {
        let args = [&["tradeoff", &scene, "-q"], &QUICK[..]].concat();
        serde_json::from_str(&done(&folder, &[&args[..], more].concat())).unwrap()
    };
    let found = report(&[]);
    let analytic = &found["analytic"];
    let list = |key: &str| analytic[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    // Opacities are float32 in the scene.
    assert!(list("opacities").iter().zip([0.4, 0.6]).all(|(a, b)| (a - b).abs() < 1e-6), "{analytic}");
    // 20 000 points on (2 / 1.8 · 32)² pixels.
    assert!(list("points_per_pixel").iter().all(|m| (m / 15.8 - 1.0).abs() < 0.05), "{analytic}");
    let [red, blue] =
        [[230.0f32, 60.0, 50.0], [60.0, 180.0, 75.0]].map(|c| c.map(|v| pellucid_core::color::decode_srgb(v / 255.0)));
    for (channel, color) in list("color").into_iter().enumerate() {
        let blended = f64::from(0.4 * red[channel] + 0.6 * 0.6 * blue[channel]);
        assert!((color - blended).abs() < 1e-5, "{channel}: {color} and not {blended}");
    }
    // The floor of 1024 pixels, to a linear order in the points.
    let [floor, expected] = ["floor", "expected_floor"].map(|key| number(analytic, key));
    assert!((floor / expected - 1.0).abs() < 0.15, "{analytic}");
    let rows = found["rows"].as_array().unwrap();
    let errors: Vec<[f64; 2]> =
        rows.iter().map(|row| [number(row, "rmse_analytic"), number(&row["errors"], "rmse")]).collect();
    // 1, 10 and 100 ensembles: half-way down by noise, then by points.
    assert!(errors[1][0] < 0.36 * errors[0][0] && errors[2][0] < 1.3 * expected, "{errors:?}");
    assert!(errors[2][1] < 0.8 * errors[2][0], "the reference has the same points: {errors:?}");
    assert!((number(&analytic["slope"], "exponent") + 0.5).abs() < 0.05, "{analytic}");
    let finding = found["findings"].as_array().unwrap().last().unwrap();
    assert!(text(finding, "measured").contains("alpha blending") && finding["holds"] == true, "{finding}");
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("Against alpha blending") && page.contains("expected of that"));
    let table = fs::read_to_string(inside(&folder, "report/tradeoff.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains(",rmse,rmse_analytic,"));
    // Where a rim is in the image, or colors are blended as they are stored, there is no such color.
    for other in [&["--set", "camera.height=2.2"][..], &["--set", "image.color=encoded"]] {
        let found = report(&[other, &["--seed", "4"]].concat());
        assert!(found["analytic"].is_null() && found["rows"][0]["rmse_analytic"].is_null(), "{other:?}");
    }
}

#[test]
#[ignore = "long: a comparison of all opaque methods"]
fn opaque_points_against_the_surfaces_they_stand_for() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = builtin(&folder, "tori", &["points=12000"]);
    let start = [&["tradeoff", &scene, "-q", "--size", "64x48"], &QUICK[..]].concat();
    let args = [&start[..], &["--method", "cone", "--set", "method.shape=circle"]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    assert_eq!(Some(&report), json(&folder, "report/tradeoff.json").as_ref());
    let reference = text(&report["reference"], "method");
    assert!(reference.contains("splats of all points with 4 × 4 samples"), "{reference}");
    let surveyed = &report["surveyed"];
    // Rings of points are cut to whole numbers.
    let all = number(&report, "points");
    assert_eq!(surveyed["clouds"], serde_json::json!([[1, all as u64], [16, (all / 16.0).ceil() as u64]]));
    let inside = number(surveyed, "silhouette");
    assert!((300.0..2500.0).contains(&inside), "{surveyed}");

    let rows = report["rows"].as_array().unwrap();
    assert_front(rows);
    let row = |method: &str, size: f64, thinning: u64| {
        let is_it = |row: &&Value| {
            row["method"] == method
                && row["thinning"] == thinning
                && row["step"].get(1).is_none_or(|step| *step == size)
        };
        rows.iter().find(is_it).unwrap_or_else(|| panic!("{method} {size} {thinning}"))
    };
    let [holes, rmse] = [|row: &Value| number(row, "holes"), |row: &Value| number(&row["errors"], "rmse")];
    for method in ["squares", "circles", "paraboloid", "cone", "hqs", "splats"] {
        let [none, one] = [0.0, 1.0].map(|size| row(method, size, 16));
        // 750 points don't cover some thousand pixels; with radii of their own they do, except for the pixels that
        // chance leaves open.
        assert!(holes(none) > 0.3 && holes(one) < 0.03, "{method}: {none} {one}");
        assert!(rmse(one) < rmse(none), "{method}: {none} {one}");
        assert!(holes(row(method, 1.0, 1)) < 0.001, "{method}");
    }
    assert_eq!(holes(row("points", 0.0, 16)), holes(row("circles", 0.0, 16)));
    assert!(rmse(row("splats", 1.0, 1)) < rmse(row("circles", 2.0, 1)));
    assert!(rows.iter().all(|row| row["repeats"].is_null() && row["stochastic"] == false));
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.len() == 3 && text(&findings[1], "claim").contains("size factor of 1"), "{findings:?}");
    let page = fs::read_to_string(inside_report(&folder, "report.html")).unwrap();
    assert!(page.contains("Size of splats") && page.contains("% holes") && !page.contains("Bias and noise"));
    let table = fs::read_to_string(inside_report(&folder, "tradeoff.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains(",step,thinning,") && table.contains(",holes,"));

    // The seed says which points are left out, and radii are there though the method asks for none.
    let other = ["--only", "circles", "--seed", "2", "--method", "points"];
    let again: Value = serde_json::from_str(&done(&folder, &[&start[..], &other].concat())).unwrap();
    let same = |thinning: u64| {
        let of = |report: &Value| {
            let is_it =
                |row: &&Value| row["thinning"] == thinning && row["step"][1] == 1.0 && row["method"] == "circles";
            report["rows"].as_array().unwrap().iter().find(is_it).unwrap()["errors"].clone()
        };
        of(&report) == of(&again)
    };
    assert!(same(1) && !same(16), "{again}");
    assert!(report["shaded"].is_null() && again["shaded"].is_null());

    // Soft shadows have a ladder of their own.
    let light =
        ["--set", "shading.light=[0.5, 0.3, -1]", "--set", "shadows.light_radius=8", "--set", "shadows.resolution=64"];
    // Little time, so that the reference has few samples.
    let start = ["tradeoff", &scene, "-q", "--size", "64x48", "-o", "report", "--quick", "--json", "--time", "5"];
    let args = [&start[..], &["--only", "points", "--method", "points"], &light].concat();
    let shaded: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    let shaded = &shaded["shaded"];
    assert_eq!(shaded["method"], "points");
    assert!(number(shaded, "reference_samples") >= 100.0, "{shaded}");
    let steps = shaded["steps"].as_array().unwrap();
    assert_eq!(steps.iter().map(|step| number(step, "samples")).collect::<Vec<_>>(), [1.0, 5.0]);
    assert!(number(&steps[0], "rmse") > number(&steps[1], "rmse") && number(&steps[1], "rmse") > 0.0, "{shaded}");
    assert!(steps.iter().all(|step| number(&step["ms"], "min") > 0.0), "{shaded}");
    let table = fs::read_to_string(inside_report(&folder, "tradeoff.csv")).unwrap();
    assert!(table.contains("points,shadows.samples=5,shadows.samples,5.0,"), "{table}");
}

fn inside_report(folder: &TempDir, name: &str) -> std::path::PathBuf {
    inside(folder, &format!("report/{name}"))
}

/// Starts a comparison and ends it once `settings` of them are stored.
fn interrupt(folder: &TempDir, args: &[&str], settings: usize) -> Value {
    let command = pellucid(folder, args);
    let mut child = Command::new(command.get_program())
        .args(command.get_args())
        .args(device().map_or_else(Vec::new, |device| vec!["--device".to_owned(), device]))
        .envs(command.get_envs().filter_map(|(key, value)| Some((key, value?))))
        .current_dir(folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let stored = loop {
        assert!(start.elapsed() < Duration::from_secs(300), "nothing is stored");
        let stored = json(folder, PARTIAL);
        let count = stored.as_ref().map_or(0, |stored| stored["settings"].as_object().unwrap().len());
        if count >= settings {
            break stored.unwrap();
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
        std::thread::sleep(Duration::from_millis(2));
    };
    child.kill().unwrap();
    child.wait().unwrap();
    stored
}

#[test]
fn an_interrupted_run_goes_on() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let args = args(&scene);
    let stored = interrupt(&folder, &args, 3);
    let pictures: Vec<&str> =
        stored["settings"].as_object().unwrap().values().map(|setting| text(&setting["row"], "picture")).collect();
    let modified = |name: &&str| fs::metadata(inside(&folder, &format!("report/{name}"))).unwrap().modified().unwrap();
    let before: Vec<_> = pictures.iter().map(modified).collect();
    assert!(!inside(&folder, "report/report.html").exists());

    let report: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    assert_eq!(report["sittings"], 2);
    assert_eq!(pictures.iter().map(modified).collect::<Vec<_>>(), before, "not rendered for their errors again");
    let rows = report["rows"].as_array().unwrap();
    rows.iter().for_each(|row| assert_row(&folder, row));
    assert_front(rows);
    for (key, setting) in stored["settings"].as_object().unwrap() {
        let row = rows.iter().find(|row| format!("{} {}", text(row, "method"), text(row, "setting")).trim_end() == key);
        assert_eq!(row.unwrap()["errors"], setting["row"]["errors"], "{key}");
    }
    assert!(!inside(&folder, PARTIAL).exists());
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    assert!(page.contains("in 2 runs"));

    // Results left by another scene are not used for this one.
    interrupt(&folder, &args, 3);
    let other = [&args[..], &["--seed", "9"]].concat();
    let report: Value = serde_json::from_str(&done(&folder, &other)).unwrap();
    assert_eq!(report["sittings"], 1);
}

#[test]
fn wrong_requests_are_refused_before_any_work() {
    let folder = folder();
    let scene = tori(&folder);
    fs::write(inside(&folder, "file"), "").unwrap();
    assert_refused(&folder, &["tradeoff", &scene, "-o", "file"], 1, &["file"]);
    assert_refused(&folder, &["tradeoff", &scene], 2, &["--output"]);
    assert_refused(&folder, &["tradeoff", &scene, "-o", "new", "--only", "auto"], 2, &["auto", "abuffer", "splats"]);
    assert_refused(&folder, &["tradeoff", &scene, "-o", "new", "--time", "0"], 2, &["seconds above 0"]);
    let other = ["tradeoff", &scene, "-q", "-o", "new", "--method", "one-layer"];
    assert_refused(&folder, &other, 2, &["no other method draws the same image as one-layer", "--method circles"]);
}

/// The exact picture with so many samples in a pixel, and its RMSE against the one with 64.
fn sampled(folder: &TempDir, scene: &str, samples: &str) -> f64 {
    let flat = ["--set", "method.shape=flat", "--set", "method.falloff=flat", "--method", "abuffer"];
    let picture = |count: &str| {
        let name = format!("of-{count}.exr");
        done(
            folder,
            &[&["render", scene, "-q", "--size", "48x32", "-o", &name, "--samples", count], &flat[..]].concat(),
        );
        pellucid_io::output::read_image(&inside(folder, &name)).unwrap()
    };
    pellucid_core::metrics::rmse(&picture("64").pixels, &picture(samples).pixels)
}

#[test]
fn the_pixel_area_is_a_cause_with_the_error_of_few_samples() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let only = ["--only", "abuffer", "--only", "weighted", "-q"];
    let report: Value = serde_json::from_str(&done(&folder, &[&args(&scene)[..], &only].concat())).unwrap();
    assert_eq!((&report["against"], &report["reference"]["samples"]), (&"center".into(), &1.into()));
    let causes = report["causes"].as_array().unwrap();
    let key = |cause: &Value| ["cause", "setting", "against"].map(|key| text(cause, key).to_owned());
    let expected =
        ["1", "4", "16"].map(|n| ["pixel area".into(), format!("image.samples={n}"), "image.samples=64".into()]);
    assert_eq!(causes.iter().map(key).collect::<Vec<_>>(), expected);
    let mut last = f64::INFINITY;
    for (cause, samples) in causes.iter().zip(["1", "4", "16"]) {
        let rmse = sampled(&folder, &scene, samples);
        assert!((number(cause, "rmse") - rmse).abs() < 1e-9 && rmse > 1e-3 && rmse < last, "{cause} for {rmse}");
        assert!(inside(&folder, &format!("report/{}", text(cause, "difference"))).is_file());
        last = rmse;
    }
    assert_eq!(number(&causes[0], "times"), 1.0);
    let area = &report["area"];
    assert_eq!((text(area, "method"), number(area, "samples"), number(area, "against")), ("abuffer", 1.0, 64.0));
    assert_eq!(area["rmse"], causes[0]["rmse"]);
    let page = fs::read_to_string(inside(&folder, "report/report.html")).unwrap();
    let line = "pixel area: abuffer with 1 sample in a pixel has RMSE";
    assert!(page.contains(line) && page.contains("Error by cause"));
    let csv = fs::read_to_string(inside(&folder, "report/causes.csv")).unwrap();
    assert_eq!(csv.lines().filter(|line| line.starts_with("pixel area,image.samples=")).count(), 3, "{csv}");

    // The scene's own samples are a row, and the line is theirs. Without the exact method there is only the line.
    let own = ["--only", "weighted", "--samples", "2", "-q"];
    let quiet: Vec<&str> = args(&scene).into_iter().filter(|arg| *arg != "--json").collect();
    let told = done(&folder, &[&quiet[..], &own].concat());
    assert!(told.contains("pixel area: abuffer with 2 samples in a pixel has RMSE"), "{told}");
    assert!(!told.contains("image.samples"), "{told}");
}

#[test]
fn against_the_area_every_method_has_samples_and_none_is_exact() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let scene = tori(&folder);
    let only = ["--against", "area", "--only", "abuffer", "--only", "weighted", "--only", "peel", "-q"];
    let report: Value = serde_json::from_str(&done(&folder, &[&args(&scene)[..], &only].concat())).unwrap();
    assert_eq!((&report["against"], &report["reference"]["samples"]), (&"area".into(), &64.into()));
    let reference = &report["reference"];
    assert!(
        text(reference, "method").starts_with("abuffer with 64 samples") && number(reference, "largest_error") < 1e-5
    );
    assert_eq!(reference["checked_pixels"], 256);
    let rows = report["rows"].as_array().unwrap();
    assert_front(rows);
    let row = |method: &str, setting: &str| {
        let found = rows.iter().find(|row| (text(row, "method"), text(row, "setting")) == (method, setting));
        found.unwrap_or_else(|| panic!("{method} {setting} in {rows:#?}"))
    };
    let error = |method: &str, setting: &str| number(&row(method, setting)["errors"], "rmse");
    for samples in ["1", "4", "16"] {
        let setting = format!("image.samples={samples}");
        let rmse = sampled(&folder, &scene, samples);
        assert!((error("abuffer", &setting) - rmse).abs() < 1e-9, "{samples}: {rmse}");
        // All layers are the exact picture too, and one layer leaves something out.
        assert!((error("peel", &setting) - rmse).abs() < 1e-6);
        assert!(error("peel", &format!("method.layers=1 {setting}")) > rmse);
        assert!(error("weighted", &setting) > 1e-3);
        assert_eq!(row("abuffer", &setting)["step"][0], "image.samples");
    }
    let causes = report["causes"].as_array().unwrap();
    assert_eq!(causes[0]["rmse"], row("abuffer", "image.samples=1")["errors"]["rmse"]);
}
