//! The list of hard cases: each passes on the device, and notices the naive formula.

mod common;

use common::with_device;
use pellucid::check::{self, Verdict};

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
