//! The list of hard cases: each passes on the device, and notices the naive formula.

mod common;

use common::with_device;
use pellucid_lab::check::{self, Group, Verdict};

#[test]
fn every_case_passes_and_would_notice_the_naive_formula() {
    with_device(|device| {
        let mut stage = check::stage(device).expect("a stage");
        let mut wrong = Vec::new();
        for case in check::cases() {
            let start = std::time::Instant::now();
            let verdict = case.run(&mut stage);
            println!("{:6.0} ms {:<40} {verdict:?}", start.elapsed().as_secs_f64() * 1e3, case.name);
            if verdict.is_wrong() {
                wrong.push(format!("{}: {verdict:?}", case.name));
            }
            if let Verdict::Found(finding) = verdict
                && finding.naive <= finding.bound
            {
                wrong.push(format!("{} would not notice the naive formula: {finding:?}", case.name));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    });
}

#[test]
fn names_differ() {
    let mut names: Vec<String> = check::cases().into_iter().map(|case| case.name).collect();
    let count = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count);
}

#[test]
fn every_method_has_hard_cases() {
    let cases = check::cases();
    for method in pellucid_engine::scene::METHODS {
        let of = cases.iter().filter(|case| case.name.split('/').next() == Some(*method));
        assert!(*method == "auto" || of.count() > 0, "{method} has none");
    }
}

#[test]
fn the_page_about_numerics_holds_them_all() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/numerics.md");
    let page = std::fs::read_to_string(page).expect("docs/numerics.md");
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    let cases = check::cases();
    let wanted: Vec<String> = check::groups(&cases).iter().map(Group::columns).collect();
    for (row, columns) in rows.iter().zip(&wanted) {
        assert!(
            row.starts_with(columns.as_str()),
            "`pellucid check --markdown` prints the table: {columns}, not {row}"
        );
    }
    assert_eq!(rows.len(), wanted.len());
}
