//! The command `check`: names, filters, JSON, status.

use serde_json::Value;

use crate::{assert_refused, done, folder, has_device, run};

#[test]
fn names_are_listed_and_filtered_without_a_device() {
    let folder = folder();
    let (code, list, stderr) = run(&folder, &["check", "--list"]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let names: Vec<&str> = list.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    let cases = pellucid_lab::check::cases();
    assert_eq!(names, cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>());
    assert!(names.len() >= 60);
    assert!(list.lines().zip(&cases).all(|(line, case)| line.ends_with(case.about)));

    let (_, some, _) = run(&folder, &["check", "--list", "soft-base/", "radix/1-"]);
    let wanted = names.iter().filter(|name| name.starts_with("soft-base/") || name.starts_with("radix/1-"));
    assert_eq!(some.lines().count(), wanted.count());
    assert_refused(&folder, &["check", "nonsense"], 2, &["no case matches nonsense", "--list"]);
    assert_refused(&folder, &["check", "--json", "--markdown"], 2, &["--markdown"]);
}

#[test]
fn cases_are_run_and_told_as_lines_as_json_and_as_a_table() {
    if !has_device() {
        return;
    }
    let folder = folder();
    let lines = done(&folder, &["check", "circles/no-radius", "scan/25"]);
    let lines: Vec<&str> = lines.lines().collect();
    assert_eq!(lines.len(), 5, "{lines:?}");
    assert!(lines[..4].iter().all(|line| line.ends_with("pass")), "{lines:?}");
    assert!(lines[4].starts_with("4 passed, 0 failed, 0 not applicable on "), "{lines:?}");
    assert!(lines[..4].iter().all(|line| line.contains("last release    0.00e0")), "{lines:?}");
    // One record is in its place whatever sorts it.
    let stated = done(&folder, &["check", "radix/1-records"]);
    assert!(stated.lines().next().is_some_and(|line| line.contains("naive    stated")), "{stated}");

    let json = done(&folder, &["check", "--json", "abuffer/nearly-opaque"]);
    let document: Value = serde_json::from_str(&json).unwrap();
    let keys: Vec<&str> = document.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys, ["device", "passed", "failed", "not_applicable", "cases"]);
    let case = document["cases"][0].as_object().unwrap();
    let keys: Vec<&str> = case.keys().map(String::as_str).collect();
    assert_eq!(keys, ["name", "about", "verdict", "error", "released", "bound", "naive"]);
    assert_eq!((&case["name"], &case["verdict"]), (&"abuffer/nearly-opaque".into(), &"pass".into()));
    assert!(case["error"].as_f64() <= case["bound"].as_f64() && case["naive"].as_f64() > case["bound"].as_f64());

    let table = done(&folder, &["check", "--markdown", "radix/256", "scan/256"]);
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 4, "{table}");
    assert!(rows[2].starts_with("| `256-elements` | `scan` | ") && rows[2].contains(" | 0 | 0 | 0 | "), "{table}");
}
