//! Sweep of `pellucid stress`.

use pellucid_lab::report::stress::{self as lab, Entry, Report, Settings};
use pyo3::prelude::*;

use crate::devices::Device;
use crate::failure::Failure;
use crate::work;

/// Differences from the whole sweep, or from the quick one.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SweepExtent {
    quick: bool,
    methods: Option<Vec<String>>,
    sides: Option<Vec<u32>>,
    layers: Option<Vec<u32>>,
    frames: Option<u32>,
    max_fragments: Option<u64>,
    max_seconds: Option<f64>,
    seed: u64,
    command: String,
}

/// Largest side of the scenes, and largest number of layers: what a frame and a list can have.
const MOST: u32 = 16_384;

impl SweepExtent {
    fn settings(&self) -> Result<Settings, Failure> {
        let names = self.methods.as_deref().unwrap_or_default();
        names.iter().try_for_each(|name| known(name))?;
        let entries = Entry::of_methods(names);
        let default = if self.quick { Settings::quick(entries) } else { Settings::full(entries) };
        let max_seconds = self.max_seconds.unwrap_or(default.max_seconds);
        if max_seconds.is_nan() || max_seconds <= 0.0 {
            return Err(Failure::Value(format!("max_seconds: expected a number above 0, found {max_seconds}")));
        }
        Ok(Settings {
            sides: ascending("sides", &self.sides, default.sides)?,
            layers: ascending("layers", &self.layers, default.layers)?,
            frames: self.frames.unwrap_or(default.frames).max(1),
            max_fragments: self.max_fragments.unwrap_or(default.max_fragments),
            max_seconds,
            seed: self.seed,
            ..default
        })
    }
}

fn known(name: &str) -> Result<(), Failure> {
    let names = Entry::methods();
    if names.contains(&name) {
        return Ok(());
    }
    Err(Failure::Value(format!("methods: expected some of {}, found {name:?}", names.join(", "))))
}

fn ascending(name: &str, given: &Option<Vec<u32>>, default: Vec<u32>) -> Result<Vec<u32>, Failure> {
    let Some(given) = given else { return Ok(default) };
    let mut values = given.clone();
    values.sort_unstable();
    values.dedup();
    match values.iter().find(|value| !(1..=MOST).contains(*value)) {
        Some(value) => Err(Failure::Value(format!("{name}: expected integers from 1 to {MOST}, found {value}"))),
        None if values.is_empty() => Err(Failure::Value(format!("{name}: expected at least one integer, found none"))),
        None => Ok(values),
    }
}

/// Run the sweep and return the JSON of `pellucid stress`.
#[pyfunction]
#[pyo3(signature = (device, extent, listener=None))]
pub fn stress(
    py: Python<'_>,
    device: &Device,
    extent: SweepExtent,
    listener: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let device = device.device()?;
    work::run(py, listener, move |talk| {
        let settings = extent.settings()?;
        talk.progress.set_message("stress");
        talk.progress.set_length(settings.cells() as u64);
        let sweep = lab::run(&device, &settings, &talk.progress)?;
        let report = Report { sweep: &sweep, settings: &settings, device: device.info(), command: &extent.command };
        Ok(report.json().to_string())
    })
}
