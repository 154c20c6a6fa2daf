//! `pellucid compare`: pictures, profiles, and what fails.

use std::fs;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::{assert_refused, folder, inside, run, write_picture};

#[test]
fn pictures_are_measured_and_their_difference_drawn() {
    let folder = folder();
    write_picture(&folder.path().join("a.exr"), 2, 0.0);
    write_picture(&folder.path().join("b.exr"), 2, 0.5);
    let (code, json, stderr) = run(&folder, &["compare", "a.exr", "b.exr", "--json", "-o", "d.png"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let value: Value = serde_json::from_str(&json).unwrap();
    let keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys, ["rmse", "nmse", "psnr", "ssim", "flip", "max", "above_1_255"]);
    // One channel of twelve differs by 0.5.
    assert!((value["rmse"].as_f64().unwrap() - (0.25f64 / 12.0).sqrt()).abs() < 1e-12);
    assert_eq!(value["max"], serde_json::json!({ "value": 0.5, "x": 1, "y": 0 }));
    assert_eq!(value["above_1_255"], 0.25);
    // A black reference has no size to relate an error to.
    assert_eq!(value["nmse"], Value::Null);
    // Windows of one pixel; of twelve values one differs: C₁ / (0.5² + C₁).
    let ssim = (11.0 + 1e-4 / 0.2501) / 12.0;
    assert!((value["ssim"].as_f64().unwrap() - ssim).abs() < 1e-12, "{json}");
    assert!((0.1..1.0).contains(&value["flip"].as_f64().unwrap()), "{json}");
    let difference = pellucid_io::output::read_image(&folder.path().join("d.png")).unwrap();
    assert_eq!(difference.pixels[..2], [[0.0; 3], [1.0, 0.0, 0.0]]);

    let (_, json, _) = run(&folder, &["compare", "a.exr", "a.exr", "--json"]);
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&value["rmse"], &value["nmse"], &value["psnr"]), (&0.0.into(), &0.0.into(), &Value::Null));
    assert_eq!((&value["ssim"], &value["flip"]), (&1.0.into(), &0.0.into()));
    let (_, text, _) = run(&folder, &["compare", "a.exr", "b.exr"]);
    assert!(text.contains("max          0.500000000 at (1, 0)"), "{text}");
    let names: Vec<_> = text.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(names, keys, "a line for each");
}

#[test]
fn beyond_a_limit_and_only_there_it_fails() {
    let folder = folder();
    write_picture(&folder.path().join("a.exr"), 2, 0.0);
    write_picture(&folder.path().join("b.exr"), 2, 0.5);
    let above = |limit: &str| run(&folder, &["compare", "a.exr", "b.exr", "--fail-above", limit]);
    let below = |limit: &str| run(&folder, &["compare", "a.exr", "b.exr", "--fail-below", limit]);
    // RMSE 0.1443, PSNR 16.8, SSIM 0.9167, FLIP below 1, largest 0.5, one pixel of four.
    for (passes, fails) in [
        ("nmse=inf", "nmse=1e9"),
        ("ssim=0.92", "ssim=0.91"),
        ("flip=1", "flip=0.1"),
        ("rmse=0.145", "rmse=0.144"),
        ("psnr=17", "psnr=16"),
        ("max=0.5", "max=0.49"),
        ("above_1_255=0.25", "above_1_255=0.2"),
    ] {
        assert_eq!(above(passes).0, 0, "{passes}");
        let (code, stdout, stderr) = above(fails);
        assert_eq!(code, 1, "{fails}");
        assert!(stderr.starts_with("error: ") && stderr.contains("above the allowed"), "{stderr}");
        assert!(stdout.contains("rmse"), "the figures are printed all the same");
    }
    for (passes, fails) in [("psnr=16", "psnr=17"), ("ssim=0.91", "ssim=0.92")] {
        assert_eq!(below(passes).0, 0, "{passes}");
        let (code, _, stderr) = below(fails);
        assert!(code == 1 && stderr.contains("below the allowed"), "{fails}: {stderr}");
    }
    let same = ["compare", "a.exr", "a.exr", "--fail-above", "rmse=0", "--fail-above", "flip=0"];
    let best = ["--fail-below", "ssim=1", "--fail-below", "psnr=1e9"];
    assert_eq!(run(&folder, &[&same[..], &best].concat()).0, 0, "nothing is closer than equal");
    let both = ["compare", "a.exr", "b.exr", "--fail-above", "max=1", "--fail-above", "rmse=0"];
    assert_eq!(run(&folder, &both).0, 1, "any limit counts");
}

#[test]
fn incomparable_files_are_refused() {
    let folder = folder();
    write_picture(&folder.path().join("a.png"), 2, 0.0);
    write_picture(&folder.path().join("wide.png"), 3, 0.0);
    fs::write(folder.path().join("p.json"), "{}").unwrap();
    fs::write(folder.path().join("broken.png"), "no png").unwrap();
    assert_refused(&folder, &["compare", "a.png", "wide.png"], 1, &["a.png has 2 × 2", "wide.png has 3 × 2"]);
    assert_refused(&folder, &["compare", "a.png", "no.png"], 1, &["no.png"]);
    assert_refused(&folder, &["compare", "a.png", "broken.png"], 1, &["broken.png"]);
    assert_refused(&folder, &["compare", "a.png", "a.tif"], 2, &["a.tif", "unknown image format"]);
    assert_refused(&folder, &["compare", "a.png", "p.json"], 2, &["two pictures or two profiles"]);
    assert_refused(&folder, &["compare", "p.json", "p.json"], 1, &["p.json", "not a profile"]);
    let limit = |limit: &'static str| ["compare", "a.png", "a.png", "--fail-above", limit];
    assert_refused(&folder, &limit("nonsense=1"), 2, &["unknown metric", "rmse"]);
    let below = ["compare", "a.png", "a.png", "--fail-below", "nonsense=1"];
    assert_refused(&folder, &below, 2, &["--fail-below nonsense: unknown metric", "flip"]);
    assert_refused(&folder, &["compare", "a.png", "a.png", "--anyway"], 2, &["--anyway", "profiles"]);
    let slower = ["compare", "a.png", "a.png", "--fail-slower", "1.5"];
    assert_refused(&folder, &slower, 2, &["pictures have no passes"]);
    assert_refused(&folder, &limit("rmse"), 2, &["METRIC=VALUE"]);
    assert_refused(&folder, &limit("rmse=nan"), 2, &["METRIC=VALUE"]);
    assert_refused(&folder, &["compare", "a.png", "a.png", "-o", "d.exr"], 2, &["d.exr"]);
}

#[test]
fn a_gate_for_ci_passes_rounding_and_stops_a_change() {
    let folder = folder();
    write_picture(&inside(&folder, "reference.exr"), 40, 0.5);
    // One value of 240 off by 1e-5, which is 6.5e-7 of the mean square's root; and by 0.01, which is 6.5e-4.
    write_picture(&inside(&folder, "rounded.exr"), 40, 0.50001);
    write_picture(&inside(&folder, "changed.exr"), 40, 0.51);
    let gate = |picture| run(&folder, &["compare", "reference.exr", picture, "--fail-above", "rmse=1e-4"]);
    assert_eq!((gate("reference.exr").0, gate("rounded.exr").0, gate("changed.exr").0), (0, 0, 1));
    assert!(gate("changed.exr").2.starts_with("error: rmse is 0.0006"), "{}", gate("changed.exr").2);
    assert_eq!(gate("rounded.exr").2, "");
}

/// Writes a profile with these times of `x/count`, `x/blend` and `x/tiny` per frame, in milliseconds.
fn write_profile(folder: &TempDir, name: &str, frames: &[[f64; 3]]) {
    let frame = |times: &[f64; 3]| {
        let pass = |(name, ms)| json!({ "name": name, "gpu_ms": ms, "invocations": 1, "bytes": null });
        let passes: Vec<_> = ["x/count", "x/blend", "x/tiny"].into_iter().zip(times).map(pass).collect();
        let sum: f64 = times.iter().sum();
        json!({ "gpu_ms": sum, "wall_ms": sum + 1.0, "passes": passes })
    };
    let profile = json!({ "version": 1, "frames": frames.iter().map(frame).collect::<Vec<_>>() });
    fs::write(inside(folder, name), profile.to_string()).unwrap();
}

/// `x/count` takes 10 ms ± 0.2, `x/blend` 20 ms ± 3, `x/tiny` 5 µs.
const BASE: [[f64; 3]; 7] = [
    [10.0, 20.0, 0.005],
    [10.1, 22.5, 0.005],
    [9.9, 17.8, 0.005],
    [10.0, 19.0, 0.005],
    [10.2, 23.0, 0.005],
    [9.8, 17.0, 0.005],
    [10.1, 21.0, 0.005],
];

/// `x/count` and `x/tiny` 1.5 times as long, `x/blend` with other noise, whose median is 1.5 ms larger.
const HEAD: [[f64; 3]; 7] = [
    [15.1, 21.5, 0.0075],
    [14.9, 18.0, 0.0075],
    [15.0, 22.5, 0.0075],
    [15.2, 23.0, 0.0075],
    [14.8, 17.5, 0.0075],
    [15.0, 21.8, 0.0075],
    [15.1, 19.5, 0.0075],
];

#[test]
fn a_slower_pass_is_told_from_noise() {
    let folder = folder();
    write_profile(&folder, "a.json", &BASE);
    write_profile(&folder, "b.json", &HEAD);
    let compare = |a: &str, b: &str, more: &[&str]| run(&folder, &[&["compare", a, b], more].concat());
    let (code, json, stderr) = compare("a.json", "b.json", &["--json"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let value: Value = serde_json::from_str(&json).unwrap();
    let keys: Vec<_> = value["frame"].as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys, ["name", "a_ms", "b_ms", "ratio", "interval", "share", "verdict"]);
    let [count, blend, tiny] = [0, 1, 2].map(|i| &value["passes"][i]);
    // Medians 10 and 15; of seven times the least and the greatest enclose the median.
    assert_eq!((&count["name"], &count["verdict"]), (&"x/count".into(), &"slower".into()));
    assert_eq!((&count["ratio"], &count["interval"]), (&1.5.into(), &json!([14.8 / 10.2, 15.2 / 9.8])));
    // Medians 20 and 21.5, 7.5% apart.
    assert_eq!((&blend["verdict"], &blend["ratio"]), (&"same".into(), &1.075.into()));
    assert_eq!((&tiny["verdict"], &tiny["ratio"]), (&"slower".into(), &1.5.into()));
    assert!(tiny["share"].as_f64().unwrap() < 0.01 && count["share"].as_f64().unwrap() > 0.3);

    let (_, text, _) = compare("a.json", "b.json", &[]);
    let row =
        |name: &str| text.lines().find(|line| line.contains(name)).unwrap().split_whitespace().collect::<Vec<_>>();
    assert_eq!(row("x/count")[4..], ["1.500", "1.451–1.551", "slower"]);
    assert_eq!((row("x/blend")[6], row("x/tiny")[6]), ("same", "(slower)"));
    assert!(text.contains("in parentheses: less than 1% of the frame"), "{text}");

    let (_, json, _) = compare("b.json", "a.json", &["--json"]);
    let back: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&back["passes"][0]["verdict"], &back["passes"][1]["verdict"]), (&"faster".into(), &"same".into()));
}

#[test]
fn a_slower_pass_fails_beyond_the_noise_only() {
    let folder = folder();
    write_profile(&folder, "a.json", &BASE);
    write_profile(&folder, "b.json", &HEAD);
    let gate = |a: &str, b: &str, limit: &str| run(&folder, &["compare", a, b, "--fail-slower", limit]);
    let (code, stdout, stderr) = gate("a.json", "b.json", "1.3");
    assert_eq!(code, 1, "{stderr}");
    // Neither x/blend, which may be 23.0/17.0 = 1.35 times as slow, nor x/tiny, which is short.
    assert_eq!(stderr, "error: x/count is 1.451 to 1.551 times as slow, above the allowed 1.3\n");
    assert!(stdout.contains("x/blend"), "the table is printed all the same");
    // 1.451 is not surely more.
    for (limit, expected) in [("1.45", 1), ("1.46", 0), ("x/tiny=1.4", 1), ("x/tiny=1.6", 0), ("x/blend=1", 0)] {
        assert_eq!(gate("a.json", "b.json", limit).0, expected, "{limit}");
    }
    assert_eq!((gate("a.json", "a.json", "1").0, gate("b.json", "a.json", "1").0), (0, 0));
    let broken = |limit: &str, part: &str| {
        assert_refused(&folder, &["compare", "a.json", "b.json", "--fail-slower", limit], 2, &[part]);
    };
    broken("much", "expected RATIO or PASS=RATIO");
    broken("x/count=nan", "expected RATIO or PASS=RATIO");
    broken("x/none=1.5", "--fail-slower x/none=1.5: no pass has this name");
}

#[test]
fn a_single_frame_tells_no_noise() {
    let folder = folder();
    write_profile(&folder, "a.json", &BASE[..1]);
    write_profile(&folder, "b.json", &HEAD[..1]);
    write_profile(&folder, "many.json", &HEAD);
    for b in ["b.json", "many.json"] {
        let (code, text, stderr) = run(&folder, &["compare", "a.json", b]);
        assert_eq!((code, stderr.as_str()), (0, ""));
        let counts = if b == "b.json" { "1 of A and 1 of B" } else { "1 of A and 7 of B" };
        assert!(text.contains("no noise estimate") && text.contains(counts), "{text}");
        assert!(!text.contains("slower") && !text.contains("same"), "{text}");
        let (_, json, _) = run(&folder, &["compare", "a.json", b, "--json"]);
        let value: Value = serde_json::from_str(&json).unwrap();
        for row in value["passes"].as_array().unwrap().iter().chain([&value["frame"]]) {
            assert!(row["verdict"].is_null() && row["interval"].is_null() && row["ratio"].is_number(), "{row}");
        }
        // A gate that can't tell must not look as if it had.
        for limit in ["1.5", "x/count=9"] {
            let args = ["compare", "a.json", b, "--fail-slower", limit];
            assert_refused(&folder, &args, 2, &["no noise estimate", "5 frames", counts]);
        }
    }
}

#[test]
fn profiles_of_different_work_are_not_compared_unless_asked_for() {
    let folder = folder();
    let write = |name: &str, points: u64, pixels: u64, method: &str, device: &str| {
        let frame = json!({ "gpu_ms": 4, "wall_ms": 5, "passes": [] });
        let scene = json!({ "points": points, "pixels": pixels, "fragments": 0 });
        let mut profile = json!({ "version": 1, "device": { "name": device }, "scene": scene, "frames": [frame] });
        if !method.is_empty() {
            profile["method"] = method.into();
        }
        fs::write(inside(&folder, name), profile.to_string()).unwrap();
    };
    write("a.json", 500, 307_200, "abuffer", "llvmpipe");
    write("same.json", 500, 307_200, "abuffer", "llvmpipe");
    write("points.json", 20, 307_200, "abuffer", "llvmpipe");
    write("pixels.json", 500, 1_228_800, "abuffer", "llvmpipe");
    write("method.json", 500, 307_200, "linked-list", "llvmpipe");
    write("device.json", 500, 307_200, "abuffer", "another");
    write("all.json", 20, 4, "peel", "another");
    write("old.json", 500, 307_200, "", "llvmpipe");
    let with_steady = |name: &str, steady: Value| {
        let text = fs::read_to_string(inside(&folder, "a.json")).unwrap();
        let mut profile: Value = serde_json::from_str(&text).unwrap();
        profile["steady"] = steady;
        fs::write(inside(&folder, name), profile.to_string()).unwrap();
    };
    with_steady("steady.json", true.into());
    with_steady("once.json", Value::Null);
    with_steady("a.json", false.into());
    let with_samples = |name: &str, samples: u32| {
        let text = fs::read_to_string(inside(&folder, "a.json")).unwrap();
        let mut profile: Value = serde_json::from_str(&text).unwrap();
        profile["scene"]["samples"] = samples.into();
        fs::write(inside(&folder, name), profile.to_string()).unwrap();
    };
    with_samples("samples.json", 16);
    with_samples("a.json", 1);
    for (other, says) in [
        ("points.json", "points 500 and 20;"),
        ("pixels.json", "pixels 307200 and 1228800;"),
        ("method.json", "method abuffer and linked-list;"),
        ("device.json", "device llvmpipe and another;"),
        ("steady.json", "steady false and true;"),
        ("samples.json", "samples 1 and 16;"),
        ("all.json", "points 500 and 20, pixels 307200 and 4, method abuffer and peel, device llvmpipe and another;"),
    ] {
        for more in [&[][..], &["--json"], &["--fail-above", "frame=9"]] {
            let (status, stdout, stderr) = run(&folder, &[&["compare", "a.json", other], more].concat());
            let wanted = format!("error: a.json and {other} measure different things: {says} --anyway");
            assert!(status == 1 && stdout.is_empty() && stderr.starts_with(&wanted), "{stdout}{stderr}");
        }
        let (status, stdout, stderr) = run(&folder, &["compare", "a.json", other, "--anyway"]);
        assert!(status == 0 && stdout.contains("frame") && stderr.is_empty(), "{stderr}");
    }
    for other in ["same.json", "old.json", "once.json"] {
        assert_eq!(run(&folder, &["compare", "a.json", other]).0, 0, "{other}");
    }
}

#[test]
fn two_profiles_are_compared_pass_by_pass() {
    let folder = folder();
    let profile = |name: &str, count_ms: f64| {
        let text = format!(
            r#"{{"version": 1, "frames": [{{"gpu_ms": 4, "wall_ms": 5, "passes": [{{"name": "abuffer/count", "gpu_ms": {count_ms}, "invocations": 1, "bytes": 2}}]}}]}}"#
        );
        fs::write(folder.path().join(name), text).unwrap();
    };
    profile("a.json", 2.0);
    profile("b.json", 3.0);
    let (code, text, _) = run(&folder, &["compare", "a.json", "b.json"]);
    assert_eq!(code, 0);
    let row: Vec<_> = text.lines().find(|line| line.contains("abuffer/count")).unwrap().split_whitespace().collect();
    assert_eq!(row, ["abuffer/count", "2.000", "3.000", "75.0%", "1.500", "-", "-"]);
    let (_, json, _) = run(&folder, &["compare", "a.json", "b.json", "--json"]);
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&value["passes"][0]["ratio"], &value["frame"]["ratio"]), (&1.5.into(), &1.0.into()));
    let status = |limit| run(&folder, &["compare", "a.json", "b.json", "--fail-above", limit]).0;
    assert_eq!((status("abuffer/count=1.5"), status("abuffer/count=1.4"), status("frame=1.0")), (0, 1, 0));
    assert_refused(&folder, &["compare", "a.json", "b.json", "--fail-above", "no=1"], 2, &["no pass", "no"]);
}
