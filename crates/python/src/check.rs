//! The hard cases of `pellucid check`.

use pellucid_lab::check::{self as lab, Case, Counts};
use pyo3::prelude::*;

use crate::devices::Device;
use crate::failure::Failure;
use crate::work;

/// Run the cases whose names contain one of these, by default all, and return the JSON of `pellucid check`.
#[pyfunction]
#[pyo3(signature = (device, names, listener=None))]
pub fn check(
    py: Python<'_>,
    device: &Device,
    names: Vec<String>,
    listener: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let device = device.device()?;
    work::run(py, listener, move |talk| {
        let asked = |case: &Case| names.is_empty() || names.iter().any(|name| case.name.contains(name.as_str()));
        let cases: Vec<Case> = lab::cases().into_iter().filter(asked).collect();
        if cases.is_empty() {
            return Err(Failure::Value(format!("names: no case matches {}", names.join(", "))));
        }
        let mut stage = lab::CaseRenderer::new(&device)?;
        talk.progress.set_message("checking");
        talk.progress.set_length(cases.len() as u64);
        let mut results = Vec::new();
        for case in &cases {
            talk.go_on()?;
            let verdict = case.run(&mut stage);
            device.check_validation()?;
            results.push((case, verdict));
            talk.progress.inc(1);
        }
        let counts = Counts::new(results.iter().map(|(_, verdict)| verdict));
        let info = device.info();
        Ok(lab::document(&info.name, &info.driver, &counts, &results).to_string())
    })
}
