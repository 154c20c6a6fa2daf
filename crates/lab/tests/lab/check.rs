//! The list of hard cases: each passes on the device and notices the naive formula. On llvmpipe, where its results are
//! known, none may be missing, none get much worse than in the last release, and docs/numerics.md must hold what comes
//! out.

use pellucid_engine::methods::{self, Renderer};
use pellucid_lab::check::{self, Case, Counts, Verdict};
use pellucid_scene::Method;
use pellucid_testing::{is_llvmpipe, root, updates, with_device};

use crate::by_halves;

/// Cases on llvmpipe, all of which apply there.
const CASES: usize = 692;

/// Runs every second case on each of two devices; the verdicts in the order of the cases, and whether the devices are
/// llvmpipe. `None` without a device.
fn run() -> Option<(Vec<Verdict>, bool)> {
    let halves = by_halves(|half| {
        let mut found = None;
        with_device(|device| {
            let mut stage = check::CaseRenderer::new(device).expect("a stage");
            let cases = check::cases().into_iter().skip(half).step_by(2);
            found = Some((cases.map(|case| case.run(&mut stage)).collect::<Vec<_>>(), is_llvmpipe(device)));
        });
        found
    });
    let [Some((even, is_llvmpipe)), Some((odd, _))] = halves else { return None };
    let mut odd = odd.into_iter();
    Some((even.into_iter().flat_map(|verdict| [Some(verdict), odd.next()]).flatten().collect(), is_llvmpipe))
}

/// Failures on any device.
fn wrong(results: &[(&Case, Verdict)]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (case, verdict) in results {
        if verdict.is_wrong() {
            wrong.push(format!("{}: {verdict:?}", case.name));
        }
        if let Verdict::Found(finding) = verdict
            && finding.naive.is_noticed(finding.bound) == Some(false)
        {
            wrong.push(format!("{} would not notice the naive formula: {finding:?}", case.name));
        }
    }
    wrong
}

/// Regressions on the device of the release.
fn worse(results: &[(&Case, Verdict)]) -> Vec<String> {
    let mut worse = Vec::new();
    for (case, verdict) in results {
        match verdict {
            Verdict::NotApplicable(lack, why) => worse.push(format!("{} lacks {}: {why}", case.name, lack.name())),
            Verdict::Found(finding) => worse.extend(check::regression(&case.name, finding).map(|r| r.to_string())),
            Verdict::Failed(_) => {}
        }
    }
    let counts = Counts::new(results.iter().map(|(_, verdict)| verdict));
    if (counts.passed, results.len()) != (CASES, CASES) {
        worse.push(format!("{counts} of {} cases, but llvmpipe passes {CASES}", results.len()));
    }
    worse
}

fn rows(page: &str) -> Vec<&str> {
    page.lines().filter(|line| line.starts_with("| `")).collect()
}

/// Writes what this release measures into the table of errors and the page about numerics.
fn update(results: &[(&Case, Verdict)]) {
    let path = root().join("docs/numerics.md");
    let page = std::fs::read_to_string(&path).expect("docs/numerics.md");
    let table = check::markdown(results);
    let start = page.find("| case |").expect("the table's head");
    let rest = page[start..].find("\n\n").map_or("", |end| &page[start + end + 1..]);
    std::fs::write(path, format!("{}{table}{rest}", &page[..start])).expect("written");
    std::fs::write(root().join("crates/lab/src/check/released.txt"), check::released_table(results)).expect("written");
}

#[test]
fn every_case_passes_would_notice_the_naive_formula_and_is_no_worse_than_released() {
    let cases = check::cases();
    let Some((verdicts, is_llvmpipe)) = run() else { return };
    assert_eq!(verdicts.len(), cases.len());
    let results: Vec<(&Case, Verdict)> = cases.iter().zip(verdicts).collect();
    for (case, verdict) in &results {
        println!("{:<40} {verdict:?}", case.name);
    }
    let mut wrong = wrong(&results);
    if is_llvmpipe && updates() {
        update(&results);
        println!("docs/numerics.md and released.txt were written; the next run compares with them");
    } else if is_llvmpipe {
        wrong.extend(worse(&results));
        let page = std::fs::read_to_string(root().join("docs/numerics.md")).expect("docs/numerics.md");
        let table = check::markdown(&results);
        let differ =
            rows(&page).into_iter().zip(rows(&table)).filter(|(known, found)| numbers(known) != numbers(found));
        wrong.extend(differ.map(|(known, found)| {
            format!("docs/numerics.md is stale (PELLUCID_UPDATE=1 writes it): {known}, not {found}")
        }));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The columns of a row that do not depend on how the device of this run rounds: all but the error, the fourth.
fn numbers(row: &str) -> Vec<&str> {
    row.split('|').enumerate().filter(|(i, _)| *i != 4).map(|(_, cell)| cell.trim()).collect()
}

#[test]
fn names_differ() {
    let mut names: Vec<String> = check::cases().into_iter().map(|case| case.name).collect();
    assert_eq!(names.len(), CASES);
    names.sort();
    names.dedup();
    assert_eq!(names.len(), CASES);
}

#[test]
fn every_method_has_hard_cases() {
    let cases = check::cases();
    for method in pellucid_scene::METHODS {
        let of = cases.iter().filter(|case| case.name.split('/').next() == Some(*method));
        assert!(*method == "auto" || of.count() > 0, "{method} has none");
    }
}

#[test]
fn the_page_about_numerics_holds_them_all_with_the_errors_of_the_release() {
    let page = std::fs::read_to_string(root().join("docs/numerics.md")).expect("docs/numerics.md");
    let (rows, cases) = (rows(&page), check::cases());
    let groups = check::groups(&cases);
    for (row, group) in rows.iter().zip(&groups) {
        let columns = group.columns();
        assert!(
            row.starts_with(&columns),
            "tests/lab/check.rs with PELLUCID_UPDATE=1 writes the table: {columns}, not {row}"
        );
        // The table was written by the run that is the release's.
        let cells: Vec<&str> = row[columns.len()..].split('|').map(str::trim).collect();
        assert_eq!(cells[0], cells[1], "{row}");
    }
    assert_eq!(rows.len(), groups.len());
}

/// `pellucid devices` says which methods need what tiles of splats need, and the error of a frame does.
#[test]
fn methods_that_go_through_tiles_are_listed() {
    with_device(|device| {
        let mut renderer = Renderer::new(device).expect("a renderer");
        let listed = methods::need_subgroups(device.info());
        // `stochastic` can do without here, and doesn't.
        let goes = |method: &Method| listed.contains(&method.name()) || matches!(method, Method::Stochastic(_));
        let error = methods::Error::NoSubgroups { device: String::new() }.to_string();
        assert!(listed.len() >= 8 && listed.iter().all(|name| error.contains(name)), "{listed:?}");
        for subject in check::subjects() {
            let method = subject.frame.method;
            // An A-buffer does without tiles where it must, and soft points do where there are no solid ones.
            if matches!(method, Method::ABuffer(_)) || method.soft().is_some() || subject.name != method.name() {
                continue;
            }
            let rendered = subject.render_arranged(&mut renderer, &subject.arranged()).expect("rendered");
            let through_tiles = rendered.profile.passes.iter().any(|pass| pass.name.starts_with("bin/"));
            assert_eq!(through_tiles, goes(&method), "{}", subject.name);
        }
    });
}
