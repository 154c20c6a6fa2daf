//! Outputs that can't be written, whoever asks: what root may do is no way around.

use std::fs;

use super::checker::{Allowed, complaints};
use super::{CASES, assert_failed, command, files, place};

/// The arguments of a case with another folder for its output.
fn redirected(args: &[&str], folder: &str) -> Vec<String> {
    let into = |arg: &&str| match arg.strip_prefix("out") {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("{folder}{rest}"),
        _ => (*arg).to_owned(),
    };
    args.iter().map(into).collect()
}

fn assert_refused(args: &[String], parts: &[&str]) {
    let folder = place();
    fs::write(folder.path().join("file"), "old").unwrap();
    for case in CASES {
        case.files.iter().for_each(|name| fs::create_dir_all(folder.path().join("taken").join(name)).unwrap());
    }
    let before = files(folder.path());
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let output = command(folder.path(), &args).output().unwrap();
    assert_failed(&output, &format!("{args:?}"), parts);
    let found = complaints(&before, &files(folder.path()), Allowed::Nothing);
    assert!(found.is_empty(), "{args:?}: {found:?}");
    assert!(!folder.path().join("none").exists(), "{args:?}");
}

#[test]
fn outputs_that_can_not_be_written_are_refused_by_every_command() {
    // A report's folder is made if it is missing.
    let reports: [&[&str]; 3] = [
        &["scene", "tori", "-o", "out"],
        &["stress", "-o", "out", "--quick"],
        &["tradeoff", "in/scene.toml", "-o", "out"],
    ];
    for args in reports {
        assert_refused(&redirected(args, "file"), &["file is a file and not a folder"]);
        assert_refused(&redirected(args, "file/deeper/new"), &["file is a file and not a folder"]);
    }
    for case in CASES.into_iter().filter(|case| case.args[0] != "scene") {
        assert_refused(&redirected(case.args, "none"), &["none/", "no folder none; create it first"]);
        assert_refused(&redirected(case.args, "file"), &["file/", "file is a file and not a folder"]);
        assert_refused(&redirected(case.args, "file/deeper"), &["file/", "file is a file and not a folder"]);
        assert_refused(&redirected(case.args, "taken"), &["taken/", "this is a folder"]);
    }
    assert_refused(&redirected(CASES[0].args, "taken"), &["taken/inner.ply: this is a folder"]);
}

/// Nobody, not even root, makes files in /proc.
#[cfg(target_os = "linux")]
#[test]
fn folders_that_take_no_files_are_refused_before_any_work() {
    for case in CASES {
        // The input is missing too, where it can: the target is looked at first.
        let args: Vec<&str> =
            case.args.iter().map(|arg| if *arg == "in/scene.toml" { "in/no.toml" } else { arg }).collect();
        assert_refused(&redirected(&args, "/proc"), &["/proc", "can't be written: "]);
    }
    let reports: [&[&str]; 2] = [&["stress", "-o", "out/new"], &["tradeoff", "in/no.toml", "-o", "out/new/er"]];
    reports.iter().for_each(|args| assert_refused(&redirected(args, "/proc"), &["/proc/new", "can't be written: "]));
}
