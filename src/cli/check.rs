//! `pellucid check`.

use std::process::ExitCode;

use clap::Args;
use pellucid::check::{self, Case, Finding, Verdict};
use pellucid::gpu::{Device, DeviceOptions};
use pellucid::{Result, scene};
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
    let (mut rows, mut wrong, mut passed) = (Vec::new(), 0, 0);
    for case in &cases {
        progress.set_message(case.name.clone());
        let verdict = case.run(&mut stage);
        device.check_validation()?;
        wrong += usize::from(verdict.is_wrong());
        passed += usize::from(matches!(verdict, Verdict::Found(finding) if finding.passes()));
        if args.json {
            rows.push(row(case, &verdict));
        } else {
            progress.suspend(|| print(&line(case, &verdict)))?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    if args.json {
        let info = device.info();
        let device = json!({ "name": info.name, "driver": info.driver });
        print_json(&json!({ "device": device, "passed": passed, "failed": wrong, "cases": rows }))?;
    } else {
        let apart = cases.len() - passed - wrong;
        print(&format!("{passed} passed, {wrong} failed, {apart} not applicable on {}\n", device.info().name))?;
    }
    Ok(if wrong > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS })
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
            // JSON has no infinity.
            let error = if finding.error.is_finite() { json!(finding.error) } else { json!(finding.error.to_string()) };
            json!({ "name": name, "about": about, "verdict": verdict, "error": error, "bound": finding.bound })
        }
        Verdict::NotApplicable(why) => {
            json!({ "name": name, "about": about, "verdict": "not applicable", "reason": why })
        }
        Verdict::Failed(error) => {
            json!({ "name": name, "about": about, "verdict": "fail", "reason": error.to_string() })
        }
    }
}
