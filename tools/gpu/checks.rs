//! The cases of `pellucid check`, each printed when it is done.

use std::time::Instant;

use pellucid_engine::Result;
use pellucid_gpu::Device;
use pellucid_lab::check::{self, CaseRenderer, Counts, Verdict};
use serde_json::json;

use crate::lines;

/// Runs the cases whose name contains one of these, or all; true if none failed.
pub fn run(device: &Device, names: &[String]) -> Result<bool> {
    let mut stage = CaseRenderer::new(device)?;
    let mut verdicts = Vec::new();
    for case in check::cases() {
        if !names.is_empty() && !names.iter().any(|name| case.name.contains(name.as_str())) {
            continue;
        }
        let begin = Instant::now();
        let verdict = case.run(&mut stage);
        let mut line = json!({ "name": case.name, "ms": lines::ms(begin.elapsed()) });
        match &verdict {
            Verdict::Found(finding) => {
                line["verdict"] = if finding.passes() { "pass" } else { "fail" }.into();
                line["error"] = finding.error.to_string().into();
                line["bound"] = finding.bound.to_string().into();
            }
            Verdict::NotApplicable(lack, why) => {
                line["verdict"] = "not applicable".into();
                line["lacks"] = lack.name().into();
                line["reason"] = why.as_str().into();
            }
            Verdict::Failed(error) => {
                line["verdict"] = "fail".into();
                line["reason"] = error.to_string().into();
            }
        }
        lines::put("case", line);
        verdicts.push(verdict);
    }
    let counts = Counts::new(&verdicts);
    lines::put("check", json!({ "cases": verdicts.len(), "passed": counts.passed, "failed": counts.failed }));
    Ok(counts.is_good())
}
