//! `pellucid check`.

use std::process::ExitCode;

use clap::Args;
use pellucid_engine::Result;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_lab::check::{self, Case, Counts, Finding, Naive, Verdict};

use super::console::Console;
use super::limit::usage;
use super::touched::{Touched, Touches};

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Run only cases whose name contains one of these, as in `abuffer/` or `faint`; by default all.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Device to run on, by index or part of its name, as `pellucid devices` lists them.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// List the cases with a description, without running them.
    #[arg(long)]
    list: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
    /// Print a Markdown table with one row per case, shared by several methods, as in docs/numerics.md.
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
}

impl Touches for CheckArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::default())
    }
}

pub fn run(args: CheckArgs, console: Console) -> Result<ExitCode> {
    let asked = |case: &Case| args.names.is_empty() || args.names.iter().any(|name| case.name.contains(name.as_str()));
    let cases: Vec<Case> = check::cases().into_iter().filter(asked).collect();
    if cases.is_empty() {
        let names = args.names.join(", ");
        return Err(usage(format!("no case matches {names}; `pellucid check --list` lists all")));
    }
    if args.list {
        console.print(&cases.iter().map(|case| format!("{:<36} {}\n", case.name, case.about)).collect::<String>())?;
        return Ok(ExitCode::SUCCESS);
    }
    let device = Device::open(&DeviceOptions { device: args.device, ..DeviceOptions::from_env() })?;
    let mut stage = check::CaseRenderer::new(&device)?;
    let progress = console.progress();
    progress.set_length(cases.len() as u64);
    let mut results = Vec::new();
    for case in &cases {
        progress.set_message(case.name.clone());
        let verdict = case.run(&mut stage);
        device.check_validation()?;
        if !args.json && !args.markdown {
            progress.suspend(|| console.print(&line(case, &verdict)))?;
        }
        results.push((case, verdict));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let info = device.info();
    let counts = Counts::new(results.iter().map(|(_, verdict)| verdict));
    if args.json {
        console.print_json(&check::document(&info.name, &info.driver, &counts, &results))?;
    } else if args.markdown {
        console.print(&check::markdown(&results))?;
    } else {
        console.print(&format!("{counts} on {}\n", info.name))?;
    }
    Ok(status(&counts))
}

/// 1 if a case failed, and also if none passed: a device that can run no case is not verified.
fn status(counts: &Counts) -> ExitCode {
    if counts.is_good() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The error in units in the last place of a float32 at 1, where it is that small.
fn ulp(finding: &Finding) -> f64 {
    finding.error / f64::from(f32::EPSILON)
}

fn line(case: &Case, verdict: &Verdict) -> String {
    let name = &case.name;
    match verdict {
        Verdict::Found(finding) => {
            let Finding { error, bound, naive } = finding;
            let word = if finding.passes() { "pass" } else { "FAIL" };
            let before = check::released(name).map_or("new".to_owned(), |error| format!("{error:.2e}"));
            let naive = match naive {
                Naive::Computed(error) => format!("{error:.2e}"),
                Naive::Stated { .. } => "stated".to_owned(),
            };
            let ulp = ulp(finding);
            format!(
                "{name:<36} error {error:9.2e}  last release {before:>9}  bound {bound:9.2e}  naive {naive:>9}  {ulp:9.2} ulp of 1  {word}\n"
            )
        }
        Verdict::NotApplicable(lack, why) => format!("{name:<36} not applicable ({}): {why}\n", lack.name()),
        Verdict::Failed(error) => format!("{name:<36} FAIL: {error}\n"),
    }
}

#[cfg(test)]
mod tests {
    use pellucid_lab::check::Lack;
    use serde_json::{Value, json};

    use super::*;

    /// A case for each way in which one comes out.
    fn results(cases: &[Case]) -> Vec<(&Case, Verdict)> {
        let found = |error, naive| Verdict::Found(Finding { error, bound: 1e-6, naive });
        let failed = usage("lost");
        let verdicts = [
            found(1e-7, Naive::Computed(f64::INFINITY)),
            found(2e-6, Naive::Stated { why: "it would allocate too much" }),
            found(f64::NAN, Naive::Computed(1.0)),
            Verdict::NotApplicable(Lack::Subgroups, "no subgroups".into()),
            Verdict::Failed(failed),
        ];
        cases.iter().zip(verdicts).collect()
    }

    #[test]
    fn failures_and_nothing_passed_are_status_1() {
        let counts = |passed, failed| Counts { passed, failed, not_applicable: vec![(Lack::Subgroups, 3)] };
        let status = |passed, failed| format!("{:?}", status(&counts(passed, failed)));
        let [good, bad] = [ExitCode::SUCCESS, ExitCode::FAILURE].map(|code| format!("{code:?}"));
        assert_eq!([status(1, 0), status(1, 1), status(0, 1), status(0, 0)], [good, bad.clone(), bad.clone(), bad]);
    }

    #[test]
    fn lines_and_rows_say_how_a_case_came_out() {
        let cases = check::cases();
        let results = results(&cases);
        let lines: Vec<String> = results.iter().map(|(case, verdict)| line(case, verdict)).collect();
        let parts = ["pass", "FAIL", "FAIL", "not applicable (subgroups): no subgroups", "FAIL: lost"];
        for ((text, part), case) in lines.iter().zip(parts).zip(&cases) {
            assert!(text.starts_with(&case.name) && text.trim_end().ends_with(part), "{text}");
        }
        assert!(lines[0].contains("naive       inf") && lines[1].contains("naive    stated"), "{lines:?}");
        let before = check::released(&cases[0].name).expect("measured");
        assert!(lines[0].contains(&format!("last release {:>9}", format!("{before:.2e}"))), "{}", lines[0]);
        let counts = Counts::new(results.iter().map(|(_, verdict)| verdict));
        let document = check::document("a device", "its driver", &counts, &results);
        assert_eq!((&document["passed"], &document["failed"]), (&1.into(), &3.into()));
        assert_eq!(document["not_applicable"], json!({ "subgroups": 1 }));
        let verdicts: Vec<&str> = (0..5).filter_map(|i| document["cases"][i]["verdict"].as_str()).collect();
        assert_eq!(verdicts, ["pass", "fail", "fail", "not applicable", "fail"]);
        let case = |i: usize| &document["cases"][i];
        assert_eq!((&case(0)["naive"], &case(0)["released"]), (&"inf".into(), &before.into()));
        assert_eq!((&case(1)["naive"], &case(1)["stated"]), (&Value::Null, &"it would allocate too much".into()));
        assert_eq!(case(2)["error"], "NaN");
        assert_eq!((&case(3)["reason"], &case(3)["lacks"]), (&"no subgroups".into(), &"subgroups".into()));
        assert_eq!(case(4)["reason"], "lost");
    }
}
