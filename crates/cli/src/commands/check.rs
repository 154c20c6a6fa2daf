//! `pellucid check`.

use std::process::ExitCode;

use clap::Args;
use pellucid_engine::gpu::{Device, DeviceOptions};
use pellucid_engine::{Result, scene};
use pellucid_lab::check::{self, Case, Finding, Verdict};
use serde_json::{Value, json};

use super::talk::{Talk, print, print_json};

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Only cases whose name contains one of these, as in `abuffer/` or `faint`; by default all.
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Device to run on: its index or a part of its name, as `pellucid devices` lists them.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// Name the cases and what each is about, without running any.
    #[arg(long)]
    list: bool,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
    /// Print a table in Markdown, a row for what several methods have in common, as in docs/numerics.md.
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
}

pub fn run(args: CheckArgs, talk: Talk) -> Result<ExitCode> {
    let asked = |case: &Case| args.names.is_empty() || args.names.iter().any(|name| case.name.contains(name.as_str()));
    let cases: Vec<Case> = check::cases().into_iter().filter(asked).collect();
    if cases.is_empty() {
        let names = args.names.join(", ");
        return Err(scene::Error::Usage(format!("no case is called {names}; `pellucid check --list` names all")).into());
    }
    if args.list {
        print(&cases.iter().map(|case| format!("{:<36} {}\n", case.name, case.about)).collect::<String>())?;
        return Ok(ExitCode::SUCCESS);
    }
    let device = Device::open(&DeviceOptions { device: args.device, ..DeviceOptions::from_env() })?;
    let mut stage = check::stage(&device)?;
    let progress = talk.progress();
    progress.set_length(cases.len() as u64);
    let mut results = Vec::new();
    for case in &cases {
        progress.set_message(case.name.clone());
        let verdict = case.run(&mut stage);
        device.check_validation()?;
        if !args.json && !args.markdown {
            progress.suspend(|| print(&line(case, &verdict)))?;
        }
        results.push((case, verdict));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let info = device.info();
    let count = Count::of(&results);
    if args.json {
        print_json(&document(&info.name, &info.driver, &results))?;
    } else if args.markdown {
        print(&check::markdown(&results))?;
    } else {
        let Count { passed, failed, apart } = count;
        print(&format!("{passed} passed, {failed} failed, {apart} not applicable on {}\n", info.name))?;
    }
    Ok(count.status())
}

/// How many cases came out how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Count {
    passed: usize,
    failed: usize,
    /// Neither.
    apart: usize,
}

impl Count {
    fn of(results: &[(&Case, Verdict)]) -> Self {
        let failed = results.iter().filter(|(_, verdict)| verdict.is_wrong()).count();
        let apart = results.iter().filter(|(_, verdict)| matches!(verdict, Verdict::NotApplicable(_))).count();
        Self { passed: results.len() - failed - apart, failed, apart }
    }

    fn status(self) -> ExitCode {
        if self.failed > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS }
    }
}

fn document(name: &str, driver: &str, results: &[(&Case, Verdict)]) -> Value {
    let Count { passed, failed, .. } = Count::of(results);
    let cases: Vec<Value> = results.iter().map(|(case, verdict)| row(case, verdict)).collect();
    json!({ "device": { "name": name, "driver": driver }, "passed": passed, "failed": failed, "cases": cases })
}

/// The error in units in the last place of a float32 at 1, where it is that small.
fn ulp(finding: &Finding) -> f64 {
    finding.error / f64::from(f32::EPSILON)
}

fn line(case: &Case, verdict: &Verdict) -> String {
    let name = &case.name;
    match verdict {
        Verdict::Found(finding) => {
            let Finding { error, bound, .. } = finding;
            let word = if finding.passes() { "pass" } else { "FAIL" };
            format!("{name:<36} error {error:9.2e}  bound {bound:9.2e}  {:9.2} ulp of 1  {word}\n", ulp(finding))
        }
        Verdict::NotApplicable(why) => format!("{name:<36} not applicable: {why}\n"),
        Verdict::Failed(error) => format!("{name:<36} FAIL: {error}\n"),
    }
}

fn row(case: &Case, verdict: &Verdict) -> Value {
    let (name, about) = (&case.name, case.about);
    match verdict {
        Verdict::Found(finding) => {
            let verdict = if finding.passes() { "pass" } else { "fail" };
            let Finding { error, bound, naive } = *finding;
            json!({
                "name": name, "about": about, "verdict": verdict,
                "error": number(error), "bound": number(bound), "naive": number(naive),
            })
        }
        Verdict::NotApplicable(why) => {
            json!({ "name": name, "about": about, "verdict": "not applicable", "reason": why })
        }
        Verdict::Failed(error) => {
            json!({ "name": name, "about": about, "verdict": "fail", "reason": error.to_string() })
        }
    }
}

/// JSON has no infinity.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A case for each way in which one comes out.
    fn results(cases: &[Case]) -> Vec<(&Case, Verdict)> {
        let found = |error| Verdict::Found(Finding { error, bound: 1e-6, naive: f64::INFINITY });
        let failed = scene::Error::Usage("lost".into());
        let verdicts = [
            found(1e-7),
            found(2e-6),
            found(f64::NAN),
            Verdict::NotApplicable("no subgroups".into()),
            Verdict::Failed(failed.into()),
        ];
        cases.iter().zip(verdicts).collect()
    }

    #[test]
    fn what_is_not_applicable_neither_passed_nor_failed() {
        let cases = check::cases();
        let results = results(&cases);
        let count = Count::of(&results);
        assert_eq!(count, Count { passed: 1, failed: 3, apart: 1 });
        assert_eq!(format!("{:?}", count.status()), format!("{:?}", ExitCode::FAILURE));
        let fine = Count { failed: 0, ..count };
        assert_eq!(format!("{:?}", fine.status()), format!("{:?}", ExitCode::SUCCESS));
    }

    #[test]
    fn lines_and_rows_say_how_a_case_came_out() {
        let cases = check::cases();
        let results = results(&cases);
        let lines: Vec<String> = results.iter().map(|(case, verdict)| line(case, verdict)).collect();
        let parts = ["pass", "FAIL", "FAIL", "not applicable: no subgroups", "FAIL: lost"];
        for ((text, part), case) in lines.iter().zip(parts).zip(&cases) {
            assert!(text.starts_with(&case.name) && text.trim_end().ends_with(part), "{text}");
        }
        let document = document("a device", "its driver", &results);
        assert_eq!((&document["passed"], &document["failed"]), (&1.into(), &3.into()));
        let verdicts: Vec<&str> = (0..5).filter_map(|i| document["cases"][i]["verdict"].as_str()).collect();
        assert_eq!(verdicts, ["pass", "fail", "fail", "not applicable", "fail"]);
        assert_eq!(document["cases"][0]["naive"], "inf");
        assert_eq!(document["cases"][2]["error"], "NaN");
        assert_eq!(
            (&document["cases"][3]["reason"], &document["cases"][4]["reason"]),
            (&"no subgroups".into(), &"lost".into())
        );
    }
}
