//! Facts of the driver's compiler about the pipelines of a profile: registers, spills, shared memory, size of the code.
//!
//! Drivers name their statistics as they like. Those of RADV, ANV, turnip and NVIDIA's driver are known here; what
//! others say is in the JSON under their own names.

use serde_json::{Map, Value, json};

use crate::gpu::{self, Device, Executable};

/// Names of the registers of an invocation.
const REGISTERS: &[&str] = &["VGPRs", "Register Count", "Registers", "Max live registers", "Full Registers"];
/// Names of what didn't fit into registers, of which all count.
const SPILLS: &[&str] = &["Spilled VGPRs", "Spilled SGPRs", "Spill Count", "Spills", "Local Memory"];
/// Names of the bytes of memory that a workgroup shares.
const SHARED: &[&str] = &["LDS size", "Shared Memory", "Workgroup Memory Size"];
/// Names of the bytes of machine code.
const CODE: &[&str] = &["Code size", "Binary Size", "Code Size"];

/// Figures of a pipeline; `None` where the driver has no such statistic.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shape {
    /// Registers of an invocation.
    pub registers: Option<f64>,
    /// Registers that didn't fit, as the driver counts them; with NVIDIA's driver bytes of local memory.
    pub spills: Option<f64>,
    /// Bytes of memory that a workgroup shares.
    pub shared_bytes: Option<f64>,
    /// Bytes of machine code.
    pub code_bytes: Option<f64>,
}

impl Shape {
    /// Returns the figures of what the driver compiled, of its stages the largest.
    pub fn of(executables: &[Executable]) -> Self {
        executables.iter().map(Self::stage).fold(Self::default(), Self::larger)
    }

    fn stage(executable: &Executable) -> Self {
        let values = |names: &'static [&'static str]| {
            let known = move |name: &str| names.iter().any(|known| known.eq_ignore_ascii_case(name));
            executable.statistics.iter().filter(move |(name, _)| known(name)).map(|(_, value)| *value)
        };
        Self {
            registers: values(REGISTERS).next(),
            spills: values(SPILLS).reduce(|a, b| a + b),
            shared_bytes: values(SHARED).next(),
            code_bytes: values(CODE).next(),
        }
    }

    /// Returns the larger of each figure.
    pub fn larger(self, other: Self) -> Self {
        let larger = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        Self {
            registers: larger(self.registers, other.registers),
            spills: larger(self.spills, other.spills),
            shared_bytes: larger(self.shared_bytes, other.shared_bytes),
            code_bytes: larger(self.code_bytes, other.code_bytes),
        }
    }
}

/// A pipeline of a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct PipelineFacts {
    /// The pass under whose name it ran first.
    pub pass: &'static str,
    /// The pass with what tells the variant from others.
    pub title: String,
    /// Pieces that the driver compiled.
    pub executables: Vec<Executable>,
}

/// Facts about the pipelines of a profile.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Pipelines {
    /// Nobody asked.
    #[default]
    Unasked,
    /// The device doesn't tell.
    Untold,
    /// Facts of every pipeline, by pass and variant.
    Told(Vec<PipelineFacts>),
}

impl Pipelines {
    /// Asks a device that was opened for [statistics](gpu::DeviceOptions::statistics) about all its pipelines so far.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn of(device: &Device) -> Result<Self, gpu::Error> {
        let Some(all) = device.compiled_pipelines()? else { return Ok(Self::Untold) };
        let facts = all.into_iter().map(|(made, executables)| PipelineFacts {
            pass: made.label,
            title: made.title(),
            executables,
        });
        let mut facts: Vec<_> = facts.collect();
        facts.sort_by(|a, b| (a.pass, &a.title).cmp(&(b.pass, &b.title)));
        Ok(Self::Told(facts))
    }

    /// Returns the figures of a pass, of its pipelines the largest; `None` if there are none.
    pub fn of_pass(&self, pass: &str) -> Option<Shape> {
        let Self::Told(all) = self else { return None };
        let of_pass = all.iter().filter(|facts| facts.pass == pass);
        of_pass.map(|facts| Shape::of(&facts.executables)).reduce(Shape::larger)
    }

    /// Returns the list of a profile's JSON; null where the device doesn't tell, `None` if nobody asked.
    pub fn to_json(&self) -> Option<Value> {
        match self {
            Self::Unasked => None,
            Self::Untold => Some(Value::Null),
            Self::Told(all) => Some(all.iter().map(PipelineFacts::to_json).collect()),
        }
    }
}

impl PipelineFacts {
    fn to_json(&self) -> Value {
        let executable = |executable: &Executable| {
            let statistics: Map<String, Value> =
                executable.statistics.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
            json!({"name": executable.name, "subgroup": executable.subgroup, "statistics": statistics})
        };
        let shape = Shape::of(&self.executables);
        json!({
            "pass": self.pass,
            "variant": self.title,
            "registers": shape.registers,
            "spills": shape.spills,
            "shared_bytes": shape.shared_bytes,
            "code_bytes": shape.code_bytes,
            "executables": self.executables.iter().map(executable).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn executable(statistics: &[(&str, f64)]) -> Executable {
        let statistics = statistics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Executable { name: "stage".into(), subgroup: 32, statistics }
    }

    #[test]
    fn drivers_name_the_same_figures_differently() {
        let radv = [
            ("SGPRs", 40.0),
            ("VGPRs", 96.0),
            ("Spilled SGPRs", 2.0),
            ("Spilled VGPRs", 5.0),
            ("LDS size", 512.0),
            ("Code size", 4096.0),
        ];
        let nvidia =
            [("Binary Size", 4096.0), ("Register Count", 96.0), ("Local Memory", 7.0), ("Shared Memory", 512.0)];
        let expected =
            Shape { registers: Some(96.0), spills: Some(7.0), shared_bytes: Some(512.0), code_bytes: Some(4096.0) };
        for statistics in [&radv[..], &nvidia] {
            assert_eq!(Shape::of(&[executable(statistics)]), expected);
        }
        let anv = [("Max live registers", 54.0), ("Spill Count", 0.0), ("Instruction Count", 900.0)];
        let expected = Shape { registers: Some(54.0), spills: Some(0.0), ..Shape::default() };
        assert_eq!(Shape::of(&[executable(&anv)]), expected);
        assert_eq!(Shape::of(&[executable(&[("Temperature", 1.0)])]), Shape::default());
    }

    #[test]
    fn a_pass_has_the_largest_figures_of_its_pipelines_and_their_stages() {
        let facts = |pass, stages: &[f64]| PipelineFacts {
            pass,
            title: format!("{pass} (A=1)"),
            executables: stages.iter().map(|registers| executable(&[("VGPRs", *registers)])).collect(),
        };
        let told = Pipelines::Told(vec![facts("x/a", &[8.0, 24.0]), facts("x/a", &[16.0]), facts("x/b", &[])]);
        assert_eq!(told.of_pass("x/a"), Some(Shape { registers: Some(24.0), ..Shape::default() }));
        assert_eq!(told.of_pass("x/b"), Some(Shape::default()));
        assert_eq!(told.of_pass("x/c"), None);
        let json = told.to_json().expect("asked");
        assert_eq!(json[0]["registers"], 24.0);
        assert_eq!(json[0]["variant"], "x/a (A=1)");
        assert_eq!(json[0]["executables"][1]["statistics"], json!({"VGPRs": 24.0}));
        assert_eq!(json[2]["code_bytes"], Value::Null);
        assert_eq!(Pipelines::Untold.to_json(), Some(Value::Null));
        assert_eq!(Pipelines::Unasked.to_json(), None);
    }
}
