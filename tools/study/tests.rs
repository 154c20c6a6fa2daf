//! The committed documents against the committed rows, and the tool on a scene that is measured in moments.

use std::path::Path;

use clap::Parser;
use pellucid_testing::{has_device, root, updates};

use crate::rows::{Study, read_all};
use crate::{Args, MEASURED, page, run};

const REWRITE: &str = "PELLUCID_UPDATE=1 cargo test -p pellucid-lab --example study";

/// Compares a document with its text, or rewrites it.
fn agrees(path: &Path, text: &str) {
    if updates() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let known = std::fs::read_to_string(path).unwrap_or_default();
    assert!(known == text, "{} is stale: {REWRITE} rewrites it", path.display());
}

#[test]
fn documents_are_up_to_date() {
    let studies = read_all(&root().join(MEASURED)).unwrap();
    agrees(&root().join("docs/which-method.md"), &page::text(&studies));
    for (name, svg) in page::figures(&studies) {
        agrees(&root().join("docs").join(page::FIGURES).join(name), &svg);
    }
}

fn studied(words: &[&str]) -> pellucid_engine::Result<()> {
    run(&Args::try_parse_from([&["study"], words].concat()).unwrap())
}

#[test]
fn a_scene_is_measured_once_and_a_page_made_of_it() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let measured = path("measured");
    let words = [
        "-o",
        &measured,
        "--only",
        "stack",
        "--size",
        "24x16",
        "--means",
        "5,15",
        "--frames",
        "1",
        "--warm-up-ms",
        "0",
    ];
    // No time: the file of the device alone.
    studied(&[&words[..], &["--budget-minutes", "0"]].concat()).unwrap();
    let studies = |folder: &str| -> Vec<Study> { read_all(Path::new(folder)).unwrap() };
    assert!(studies(&measured)[0].cases.is_empty());
    let page = path("docs/which-method.md");
    std::fs::create_dir(path("docs")).unwrap();
    studied(&[&words[..], &["--page", &page]].concat()).unwrap();
    let found = studies(&measured);
    let [study] = &found[..] else { panic!("one driver") };
    let means: Vec<f64> = study.cases.iter().map(|m| m.case.mean).collect();
    assert!(means == [5.0, 15.0] && study.cases.iter().all(|m| m.done), "{study:?}");
    for measured in &study.cases {
        let of = |key: &str| measured.rows.iter().find(|row| row.key() == key).unwrap();
        assert_eq!(of("abuffer").rmse(), 0.0);
        assert!(of("weighted").rmse() > 1e-3 && of("abuffer").ms() > 0.0 && of("abuffer").bytes() > 0);
        assert!(
            ["mlab", "moments", "wavelet"].iter().all(|name| measured.rows.iter().any(|row| row.family() == *name))
        );
    }
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("| stack | 5.0 |") && text.contains("24 × 16 pixels"), "{text}");
    // Nothing is measured again.
    studied(&words).unwrap();
    assert_eq!(studies(&measured), found);
    let other = ["-o", &measured, "--size", "24x17"];
    let error = studied(&other).unwrap_err();
    assert!(error.exit_status() == 1 && error.to_string().contains("at 24x16"), "{error}");
}

#[test]
fn command_lines() {
    let parse = |words: &[&str]| Args::try_parse_from([&["study"], words].concat());
    for wrong in [
        &[][..],
        &["-o", "a", "--size", "0x5"],
        &["-o", "a", "--size", "320"],
        &["-o", "a", "--only", "attic"],
        &["-o", "a", "--budget-minutes", "NaN"],
        &["-o", "a", "--means", "0"],
    ] {
        assert_eq!(parse(wrong).unwrap_err().exit_code(), 2, "{wrong:?}");
    }
    let args = parse(&["-o", "a", "--size", "320x240", "--only", "tori", "--only", "stack"]).unwrap();
    assert_eq!((args.size, args.only.len(), args.means.len()), ([320, 240], 2, 5));
    assert!(parse(&["--page", "a.md"]).unwrap().output.is_none());
}
