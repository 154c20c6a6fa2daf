//! A device that is lost or has no memory left, simulated: an error that says what helps, nothing written, and the
//! validation layers have nothing to say about what is taken down after it.

use std::process::Output;

use pellucid_scene::{Family, Method};
use pellucid_testing::long_or;

use super::checker::{Allowed, complaints};
use super::{assert_failed, command, files, has_device, meeting, place, text};

const RENDER: [&str; 7] = ["render", "in/scene.toml", "-q", "--size", "40x30", "-o", "out/a.exr"];
const PROFILE: [&str; 10] =
    ["profile", "in/scene.toml", "-q", "--size", "16x12", "--frames", "1", "--profile", "out/p.json", "--json"];
const LIGHT: [&str; 11] = [
    "prepare",
    "in/cloud.ply",
    "-q",
    "-o",
    "out/p.ply",
    "--light",
    "0,0,-1",
    "--shadow-resolution",
    "64",
    "--seed",
    "1",
];
const TRADEOFF: [&str; 9] =
    ["tradeoff", "in/scene.toml", "-q", "--size", "16x12", "-o", "new", "--quick", "--only=peel"];
const STRESS: [&str; 11] =
    ["stress", "-q", "-o", "new", "--quick", "--method", "sorted", "--frames", "1", "--max-fragments", "4096"];

/// Runs a check on the rendering of a picture by each method, and in each way that the table of methods has to draw the
/// same.
fn for_renders(methods: impl IntoIterator<Item = Method>, check: impl Fn(&[&str])) {
    for method in methods {
        let plain = [&RENDER[..], &["--method", method.name()]].concat();
        check(&plain);
        for setting in method.also() {
            let setting = format!("method.{setting}");
            check(&[&plain[..], &["--set", &setting]].concat());
        }
    }
}

/// Runs with a fault and validation; the files must be as they were. `None` if it ended before the fault, as it should.
fn failed(args: &[&str], fault: &str) -> Option<Output> {
    let folder = place();
    std::fs::write(folder.path().join("out/a.exr"), "old").unwrap();
    let before = files(folder.path());
    let output = meeting(command(folder.path(), args), fault).env("PELLUCID_VALIDATION", "1").output().unwrap();
    if output.status.success() {
        assert_eq!(text(&output.stderr), "", "{args:?} {fault}");
        return None;
    }
    let found = complaints(&before, &files(folder.path()), Allowed::Nothing);
    assert!(found.is_empty(), "{args:?} {fault}: {found:?}");
    assert!(!folder.path().join("new").exists(), "{args:?} {fault}: no folder without content");
    Some(output)
}

fn assert_lost(args: &[&str], fault: &str) -> bool {
    let output = failed(args, fault);
    if let Some(output) = &output {
        let parts = ["the device was lost during ", "try again", "--size", "--memory-budget", "--device"];
        assert_failed(output, &format!("{args:?} {fault}"), &parts);
    }
    output.is_some()
}

fn assert_out_of_memory(args: &[&str], fault: &str) -> bool {
    let output = failed(args, fault);
    if let Some(output) = &output {
        let parts = ["out of device memory: ", " needs ", " in use; ", "use a smaller --memory-budget or --size"];
        assert_failed(output, &format!("{args:?} {fault}"), &parts);
    }
    output.is_some()
}

#[test]
fn a_lost_device_is_an_error_that_says_what_helps() {
    if !has_device() {
        return;
    }
    for fault in ["submit", "wait", "submit:2", "wait:4"] {
        assert!(assert_lost(&RENDER, &format!("device-lost@{fault}")), "{fault}");
    }
    for_renders(Method::all(), |args| assert!(assert_lost(args, "device-lost@wait:3"), "{args:?}"));
    let others: [(&[&str], &str); 4] =
        [(&PROFILE, "wait:9"), (&LIGHT, "submit:3"), (&TRADEOFF, "wait:2"), (&STRESS, "wait:8")];
    for (args, point) in others {
        assert!(assert_lost(args, &format!("device-lost@{point}")), "{args:?}");
    }
    assert!(!assert_lost(&RENDER, "device-lost@submit:100000"), "a fault that never comes is none");
}

#[test]
fn too_little_memory_on_the_device_is_an_error_that_names_what_needed_it() {
    if !has_device() {
        return;
    }
    for nth in [1, 4, 12] {
        assert!(assert_out_of_memory(&RENDER, &format!("out-of-memory@allocate:{nth}")), "{nth}");
    }
    for_renders(Method::all(), |args| {
        assert!(assert_out_of_memory(args, "out-of-memory@allocate:15"), "{args:?}");
    });
    assert!(assert_out_of_memory(&LIGHT, "out-of-memory@allocate:5"));
    assert!(assert_out_of_memory(&TRADEOFF, "out-of-memory@allocate:10"));
    let busy = failed(&RENDER, "out-of-memory@submit:2").unwrap();
    assert_failed(&busy, "a submission", &["vkQueueSubmit2", "out of device memory", "--memory-budget or --size"]);
}

#[test]
#[ignore = "long: every submission and allocation of a third of each family's methods"]
fn a_device_that_fails_at_any_time() {
    if !has_device() {
        return;
    }
    for_renders(Family::ALL.iter().flat_map(|family| family.methods().step_by(3)), |args| {
        let lost = |point: &str, nth: usize| assert_lost(args, &format!("device-lost@{point}:{nth}"));
        let submissions = (1..).step_by(long_or(1, 7)).take_while(|nth| lost("submit", *nth));
        // Each is waited for.
        submissions.for_each(|nth| assert!(lost("wait", nth), "{args:?}: submission {nth} is not waited for"));
        (1..).step_by(long_or(1, 16)).find(|nth| !assert_out_of_memory(args, &format!("out-of-memory@allocate:{nth}")));
    });
}

#[test]
fn a_sweep_skips_cells_that_exceed_device_memory() {
    if !has_device() {
        return;
    }
    let folder = place();
    let args = [&STRESS[..], &["--json"]].concat();
    let mut skipped = 0;
    // Of the renderer, of the points, of the first frame of a cell, and of the frames that are timed.
    for nth in [5, 20, 40, 45, 60] {
        let mut run = command(folder.path(), &args);
        let output = run.env("PELLUCID_FAULT", format!("out-of-memory@allocate:{nth}")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let reasons = report["skipped"].as_array().unwrap().iter().map(|skipped| skipped["reason"].as_str().unwrap());
        skipped += reasons.filter(|reason| reason.contains("out of device memory: ")).count();
    }
    assert!(skipped > 3, "{skipped}");
}

#[test]
fn a_comparison_skips_settings_that_exceed_device_memory_and_leaves_no_picture() {
    if !has_device() {
        return;
    }
    let mut skipped = 0;
    for nth in [78, 90, 100, 112] {
        let folder = place();
        let args = [&TRADEOFF[..], &["--only=weighted", "--json"]].concat();
        let mut run = command(folder.path(), &args);
        let output = run.env("PELLUCID_FAULT", format!("out-of-memory@allocate:{nth}")).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let reasons = report["skipped"].as_array().unwrap().iter().map(|skipped| skipped["reason"].as_str().unwrap());
        skipped += reasons.filter(|reason| reason.contains("out of device memory: ")).count();
        let of = |row: &serde_json::Value| ["picture", "difference"].map(|key| row[key].as_str().unwrap().to_owned());
        let mut named: Vec<String> = report["rows"].as_array().unwrap().iter().flat_map(of).collect();
        let causes = report["causes"].as_array().unwrap().iter();
        named.extend(causes.map(|cause| cause["difference"].as_str().unwrap().to_owned()));
        named.push("reference.png".to_owned());
        let written = files(&folder.path().join("new"));
        let pictures =
            written.keys().map(|path| path.to_string_lossy().into_owned()).filter(|name| name.ends_with(".png"));
        named.sort();
        assert_eq!(pictures.collect::<Vec<_>>(), named, "allocation {nth}");
    }
    assert!(skipped > 1);
}

#[test]
fn a_check_on_a_device_that_is_lost_fails_and_says_so() {
    if !has_device() {
        return;
    }
    let folder = place();
    let run = command(folder.path(), &["check", "abuffer/list-of", "--json"]);
    let output = meeting(run, "device-lost@wait:3").env("PELLUCID_VALIDATION", "1").output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(1), ""));
    assert!(text(&output.stdout).contains("the device was lost during "));
    serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap();
}
