//! `stress`: its files, its figures and what it skips.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::{assert_refused, done, folder, has_device, inside};

/// The columns of `stress.csv`.
const COLUMNS: &str = "scene,side,pixels,layers,fragments,method,points,gpu_ms_min,gpu_ms_median,gpu_ms_max,wall_ms_min,\
    wall_ms_median,wall_ms_max,mfragments_per_s,peak_device_bytes,bytes_per_fragment,fragment_bytes,bands,error_max,\
    error_rmse,error_pixels,kind,bound,error_standard_errors,holds,skipped";

/// A quick sweep goes through so many scenes: two kinds, two sizes, six numbers of layers.
const QUICK: usize = 2 * 2 * 6;
/// Exact methods of discs, whose picture is the same; `abuffer` also with lists sorted in place.
const EXACT: usize = 5;

fn read(folder: &TempDir, name: &str) -> String {
    fs::read_to_string(inside(folder, name)).unwrap()
}

fn cells(report: &Value) -> &Vec<Value> {
    report["cells"].as_array().unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

/// Asserts what must hold of every measured cell.
fn assert_cell(cell: &Value) {
    let (layers, pixels) = (number(cell, "layers"), number(cell, "pixels"));
    assert_eq!(pixels, number(cell, "side").powi(2));
    assert_eq!(cell["fragments"], cell["layers"].as_u64().unwrap() * cell["pixels"].as_u64().unwrap());
    // Methods without lists count no fragments.
    let method = cell["method"].as_str().unwrap();
    let lists = method == "linked-list" || method.starts_with("abuffer");
    let counted = if lists { &cell["fragments"] } else { &Value::Null };
    assert_eq!(&cell["counted"], counted, "the device finds exactly the layers: {cell}");
    if cell["workload"] == "stack" {
        assert_eq!(cell["points"], cell["layers"]);
    } else {
        // A ninth of the pixels, and what reaches over the rim.
        let discs = number(cell, "points") / layers;
        assert!(discs >= pixels / 9.0 && discs <= (pixels.sqrt() / 3.0 + 1.0).powi(2), "{cell}");
    }
    for time in ["gpu_ms", "wall_ms"] {
        let [min, median, max] = ["min", "median", "max"].map(|key| number(&cell[time], key));
        assert!(0.0 < min && min <= median && median <= max, "{cell}");
    }
    let rate = number(cell, "fragments") / (1e3 * number(&cell["gpu_ms"], "median"));
    assert!((number(cell, "mfragments_per_s") / rate - 1.0).abs() < 1e-12);
    // A fragment takes 8 bytes, the image 20 for each pixel.
    assert!(number(cell, "bytes_per_fragment") > 8.0, "{cell}");
    // Peeling has regions, but no batches of fragments.
    assert_eq!(number(cell, "bands") >= 1.0, cell["method"] != "peel", "{cell}");
    assert!(cell["passes"].as_array().unwrap().iter().any(|pass| pass["name"] == "project/splats"), "{cell}");
    // Of each layer the product with T, the sum and T itself are rounded; all of them are at most 1.
    let bound = 3.0 * (layers + 1.0) * 2f64.powi(-24);
    let error = &cell["error"];
    assert!(number(error, "max") <= bound && number(error, "rmse") <= number(error, "max"), "{cell}");
    assert_eq!((&error["pixels"], &error["standard_errors"]), (&256.into(), &Value::Null));
    assert_eq!((&cell["kind"], &cell["holds"]), (&"exact".into(), &true.into()));
    // Two products and two sums for each layer, and for the one run of them.
    assert_eq!(number(cell, "bound"), 4.0 * (layers + 1.0) * 2f64.powi(-24));
}

#[test]
fn a_sweep_leaves_tables_figures_and_a_page() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let methods = "--method=abuffer,linked-list,sorted,peel";
    let args =
        ["stress", "--quick", methods, "--max-fragments", "300000", "--frames", "2", "-o", "new/sweep", "--json"];
    // Time for the pixel area on a busy machine, too.
    let args = [&args[..], &["--max-seconds", "100"]].concat();
    let printed: Value = serde_json::from_str(&done(&folder, &args)).unwrap();
    let mut files: Vec<_> =
        fs::read_dir(inside(&folder, "new/sweep")).unwrap().map(|e| e.unwrap().file_name()).collect();
    files.sort();
    let expected =
        ["error.svg", "memory.svg", "report.html", "stress.csv", "stress.json", "throughput.svg", "time.svg"];
    assert_eq!(files, expected);
    assert_eq!(printed, serde_json::from_str::<Value>(&read(&folder, "new/sweep/stress.json")).unwrap());

    cells(&printed).iter().for_each(assert_cell);
    // 64² pixels by 1, 4, 16, 64 layers and 256² by 1, 4.
    assert_eq!(cells(&printed).len(), EXACT * 2 * (4 + 2));
    let skipped = printed["skipped"].as_array().unwrap();
    assert_eq!(cells(&printed).len() + skipped.len(), EXACT * QUICK, "every cell is measured or listed as skipped");
    for cell in skipped {
        let fragments = number(cell, "side").powi(2) * number(cell, "layers");
        assert!(fragments > 300_000.0, "{cell}");
        assert_eq!(cell["reason"], format!("{fragments} fragments, more than the limit of 300000"));
    }
    // Series of four cells have a slope, those of two have none.
    let slopes = printed["slopes"].as_array().unwrap();
    assert!(slopes.len() == EXACT * 2 && slopes.iter().all(|slope| slope["side"] == 64 && slope["exponent"].is_f64()));

    // A disc over the whole image has no edge in it.
    let areas = printed["areas"].as_array().unwrap();
    let stack: Vec<_> = areas.iter().filter(|area| area["workload"] == "stack").collect();
    assert!(!stack.is_empty() && stack.iter().all(|area| number(area, "rmse") < 1e-6), "{areas:?}");
    assert!(areas.iter().any(|area| area["workload"] == "mosaic" && number(area, "rmse") > 1e-3), "{areas:?}");

    assert_csv(&read(&folder, "new/sweep/stress.csv"), &printed);
    let page = read(&folder, "new/sweep/report.html");
    for part in ["src=", "href=", "<link", "<script", "@import", "url("] {
        assert!(!page.contains(part), "the page must not load anything: {part}");
    }
    assert_eq!(page.matches("<svg").count(), 4);
    let device = printed["device"]["name"].as_str().unwrap();
    for part in
        [device, "pixel area: ", "--max-fragments 300000", "4194304 fragments, more than the limit", "abuffer/store"]
    {
        assert!(page.contains(part), "{part} in the page");
    }
}

/// Asserts that a table says what the JSON document says.
fn assert_csv(text: &str, report: &Value) {
    let mut table = csv::Reader::from_reader(text.as_bytes());
    assert_eq!(table.headers().unwrap().iter().collect::<Vec<_>>().join(","), COLUMNS);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let skipped = report["skipped"].as_array().unwrap();
    assert_eq!(rows.len(), cells(report).len() + skipped.len());
    for (row, cell) in rows.iter().zip(cells(report)) {
        let parsed = |column: usize| row[column].parse::<f64>().unwrap();
        assert_eq!(parsed(2) * parsed(3), parsed(4), "pixels · layers = fragments: {row:?}");
        assert_eq!((&row[0], parsed(3)), (cell["workload"].as_str().unwrap(), number(cell, "layers")));
        // The parser of JSON may be off by the last bit.
        let is = |column: usize, value: f64| (parsed(column) - value).abs() <= 1e-12 * value;
        assert!(is(8, number(&cell["gpu_ms"], "median")) && is(18, number(&cell["error"], "max")), "{row:?}, {cell}");
        assert_eq!(&row[25], "");
    }
    for (row, cell) in rows[cells(report).len()..].iter().zip(skipped) {
        assert_eq!((&row[8], &row[25]), ("", cell["reason"].as_str().unwrap()));
    }
}

#[test]
fn a_method_is_cut_off_where_its_own_times_predict_too_long_a_frame() {
    if !has_device() {
        return;
    }
    let folder = folder();
    // Nothing is known before the first cell of each series; after it everything takes too long.
    let args = ["stress", "--quick", "--method", "linked-list", "--frames", "1", "--max-seconds", "1e-9"];
    let text = done(&folder, &args);
    assert!(text.contains("4 cells measured, 20 skipped") && text.contains("pellucid-stress/report.html"), "{text}");
    let report: Value = serde_json::from_str(&read(&folder, "pellucid-stress/stress.json")).unwrap();
    assert!(cells(&report).iter().all(|cell| cell["layers"] == 1));
    let by_time = |cell: &&Value| cell["reason"].as_str().unwrap().contains("more than the limit of 0.000000001 s");
    // The others have more fragments than a quick sweep allows.
    assert_eq!(report["skipped"].as_array().unwrap().iter().filter(by_time).count(), 2 * (4 + 2));
}

#[test]
fn wrong_requests_are_refused_before_any_work() {
    let folder = folder();
    fs::write(inside(&folder, "file"), "").unwrap();
    assert_refused(&folder, &["stress", "-o", "file"], 1, &["file"]);
    // Their pictures have no such layers.
    assert_refused(&folder, &["stress", "--method", "abuffer,spbr"], 2, &["spbr", "abuffer"]);
    assert_refused(&folder, &["stress", "--method", "circles"], 2, &["circles", "abuffer"]);
    assert_refused(&folder, &["stress", "--max-seconds", "0"], 2, &["seconds above 0"]);
    assert_refused(&folder, &["stress", "--frames", "0"], 2, &["--frames"]);
}
