//! The settings with which a choice by error begins: the best of each mean and error over all scenes.

use std::collections::BTreeSet;

use pellucid_engine::output::Error;
use pellucid_lab::choice::{Start, Starts};

use crate::map::{ERRORS, verdicts};
use crate::rows::{Measured, Study};

/// Settings of each mean and error, of as many methods.
const EACH: usize = 2;

/// The text of crates/lab/src/choice/starts.json.
///
/// # Errors
/// It can't be written as JSON.
pub fn json(studies: &[Study]) -> Result<String, Error> {
    let starts = Starts { cpu: of(studies, |kind| kind == "CPU"), gpu: of(studies, |kind| kind != "CPU") };
    let list = |starts: &[Start]| -> Result<String, serde_json::Error> {
        let lines = starts.iter().map(serde_json::to_string).collect::<Result<Vec<_>, _>>()?;
        Ok(if lines.is_empty() { "[]".to_owned() } else { format!("[\n{}\n]", lines.join(",\n")) })
    };
    let text = list(&starts.cpu).and_then(|cpu| Ok(format!("{{\"cpu\":{cpu},\n\"gpu\":{}}}\n", list(&starts.gpu)?)));
    text.map_err(|error| Error::Report { reason: error.to_string() })
}

fn of(studies: &[Study], is_kind: impl Fn(&str) -> bool) -> Vec<Start> {
    let studies = studies.iter().filter(|study| is_kind(&study.device.kind));
    let cases: Vec<&Measured> = studies.flat_map(|study| &study.cases).collect();
    let targets: BTreeSet<u32> = cases.iter().map(|measured| measured.case.target).collect();
    let mut starts = Vec::new();
    for target in targets {
        let cases: Vec<&Measured> = cases.iter().copied().filter(|measured| measured.case.target == target).collect();
        for (error, _) in ERRORS {
            let mut first: Vec<String> = verdicts(&cases, error).into_iter().map(|verdict| verdict.key).collect();
            // Which points are left out, and that in how far it helps, is another matter on every scene.
            first.retain(|key| !key.contains("detail."));
            first.truncate(EACH);
            if !first.is_empty() {
                starts.push(Start { mean: target.into(), error, first });
            }
        }
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::tests::case;
    use crate::rows::Device;

    #[test]
    fn the_best_two_of_each_mean_and_error() {
        let device = |kind: &str| Device {
            device: "a".to_owned(),
            driver: "b".to_owned(),
            kind: kind.to_owned(),
            pellucid: "0.1.0".to_owned(),
            size: [8, 8],
            frames: 3,
        };
        let rows = [
            ("abuffer", 0.0, 10.0),
            ("linked-list", 0.0, 11.0),
            ("abuffer detail.spacing_px=2", 0.004, 1.0),
            ("hybrid method.k=8", 0.004, 6.0),
        ];
        let cpu = Study { device: device("CPU"), cases: vec![case("tori", 50, &rows), case("tori", 5, &rows[..1])] };
        let gpu = Study { device: device("discrete"), cases: vec![case("tori", 5, &rows[..2])] };
        let text = json(&[cpu, gpu]).unwrap();
        let starts: Starts = serde_json::from_str(&text).unwrap();
        assert_eq!(starts.first("CPU", 50.0, 0.01), ["hybrid method.k=8", "abuffer"]);
        assert_eq!(starts.first("CPU", 50.0, 0.004), ["abuffer", "linked-list"]);
        assert_eq!(starts.first("CPU", 5.0, 0.01), ["abuffer"]);
        assert_eq!(starts.first("discrete", 50.0, 0.0), [""; 0], "rounding is not what was asked for");
        assert_eq!(starts.first("discrete", 50.0, 1e-5), ["abuffer", "linked-list"]);
        // Two means of eight errors, and one.
        assert_eq!(text.lines().count(), 2 * 8 + 8 + 4);
        assert_eq!(serde_json::from_str::<Starts>(&json(&[]).unwrap()).unwrap(), Starts::default());
    }
}
