//! Results of `check`, as JSON.

use serde_json::{Map, Value, json};

use super::{Case, Counts, Finding, Naive, Verdict, released};

/// All verdicts as one JSON object: the device, how many cases passed and failed, and a row for each.
pub fn document(name: &str, driver: &str, counts: &Counts, results: &[(&Case, Verdict)]) -> Value {
    let Counts { passed, failed, not_applicable } = counts;
    let lacks: Map<String, Value> =
        not_applicable.iter().map(|(lack, count)| (lack.name().to_owned(), json!(count))).collect();
    let cases: Vec<Value> = results.iter().map(|(case, verdict)| row(case, verdict)).collect();
    json!({
        "device": { "name": name, "driver": driver }, "passed": passed, "failed": failed, "not_applicable": lacks,
        "cases": cases,
    })
}

fn row(case: &Case, verdict: &Verdict) -> Value {
    let (name, about) = (&case.name, case.about);
    match verdict {
        Verdict::Found(finding) => {
            let verdict = if finding.passes() { "pass" } else { "fail" };
            let Finding { error, bound, naive } = *finding;
            let mut row = json!({
                "name": name, "about": about, "verdict": verdict,
                "error": number(error), "released": released(name).map(number), "bound": number(bound),
            });
            match naive {
                Naive::Computed(error) => row["naive"] = number(error),
                Naive::Stated { why } => (row["naive"], row["stated"]) = (Value::Null, json!(why)),
            }
            row
        }
        Verdict::NotApplicable(lack, why) => {
            json!({ "name": name, "about": about, "verdict": "not applicable", "lacks": lack.name(), "reason": why })
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
