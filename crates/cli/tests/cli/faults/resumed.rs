//! `tradeoff` goes on where it was killed, and doesn't measure anew what it has.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::checker::is_whole;
use super::{assert_failed, command, files, has_device, place, text, with_fault};

const ARGS: [&str; 18] = [
    "tradeoff",
    "in/scene.toml",
    "-q",
    "--size",
    "24x16",
    "-o",
    "out",
    "--quick",
    "--json",
    "--only",
    "abuffer",
    "--only",
    "peel",
    "--only",
    "stochastic",
    "--only",
    "weighted",
    "--seed=1",
];

fn partial(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("out/tradeoff.partial.json")).unwrap()).unwrap()
}

/// Frames of a setting, and how many of them an earlier run timed.
fn frames(setting: &Value, sitting: u64) -> [usize; 2] {
    let frames = setting["frames"].as_array().unwrap();
    [frames.len(), frames.iter().filter(|frame| frame["sitting"].as_u64().unwrap() < sitting).count()]
}

#[test]
fn a_comparison_that_was_killed_renders_only_what_is_missing() {
    if !has_device() {
        return;
    }
    let folder = place();
    // Pictures and what is kept get their names in turns: three for each setting, after those of the reference.
    let killed = with_fault(folder.path(), &ARGS, "kill@output/rename:12");
    assert_eq!(killed.status.code(), None);
    let first = partial(folder.path());
    let settings = |partial: &Value| partial["settings"].as_object().unwrap().clone();
    assert!((1..6).contains(&settings(&first).len()), "{first}");
    let again = with_fault(folder.path(), &ARGS, "kill@output/rename:24");
    assert_eq!(again.status.code(), None);
    let second = partial(folder.path());
    assert!(settings(&second).len() > settings(&first).len());
    // All is measured, but the page can't be written: nothing else of the report is there either.
    fs::create_dir(folder.path().join("out/report.html")).unwrap();
    let blocked = command(folder.path(), &ARGS).output().unwrap();
    assert_failed(&blocked, "a folder in the place of the page", &["out/report.html: this is a folder"]);
    assert!(!folder.path().join("out/tradeoff.csv").exists());
    let third = partial(folder.path());
    assert_eq!([&first, &second, &third].map(|partial| partial["sittings"].as_u64()), [Some(1), Some(2), Some(3)]);
    for (older, newer) in [(&first, &second), (&second, &third)] {
        for (key, setting) in settings(older) {
            let now = &newer["settings"][&key];
            assert!(setting["row"].is_object(), "{key} was tried");
            for part in ["row", "seconds"] {
                assert_eq!(now[part], setting[part], "{key} was not tried again");
            }
            let kept = setting["frames"].as_array().unwrap();
            assert_eq!(&now["frames"].as_array().unwrap()[..kept.len()], &kept[..], "{key}: frames stay");
        }
    }
    for (key, setting) in settings(&third) {
        let before = second["settings"].get(&key).map_or(0, |setting| setting["frames"].as_array().unwrap().len());
        assert_eq!(frames(&setting, 3)[1], before, "{key}: only what was missing was timed");
    }

    // Now nothing is missing: no frame is added, and the page is whole.
    fs::remove_dir(folder.path().join("out/report.html")).unwrap();
    let output = command(folder.path(), &ARGS).output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["sittings"], 4);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), settings(&third).len());
    for row in rows {
        let key = format!("{} {}", row["method"].as_str().unwrap(), row["setting"].as_str().unwrap());
        let setting = &third["settings"][key.trim_end()];
        assert_eq!(row["frames"].as_u64(), Some(frames(setting, 0)[0] as u64), "{key}");
        assert_eq!(row["errors"], setting["row"]["errors"], "{key}");
    }
    let page = fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(page.contains("in 4 runs") && page.trim_end().ends_with("</html>"));
    for (path, bytes) in files(&folder.path().join("out")) {
        if !super::checker::is_temporary(&path) {
            assert_eq!(is_whole(&path, &bytes), Ok(()), "{}", path.display());
        }
    }
    assert!(!folder.path().join("out/tradeoff.partial.json").exists());
}
