//! Options that commands share: the device, and measurements of a frame as files.

use std::io::Write;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use pellucid_core::progress::Phase;
use pellucid_engine::Result;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_io::output::{self, Output};
use pellucid_session::area::Against;
use serde_json::Value;

use super::bar::Bar;
use super::headings;
use super::limit::usage;

/// The device and what it may use.
#[derive(Debug, Args)]
pub struct DeviceArgs {
    /// Device to render on, by index or part of its name.
    ///
    /// `pellucid devices` lists them.
    #[arg(long, value_name = "NAME_OR_INDEX", help_heading = headings::DEVICE)]
    pub device: Option<String>,
    /// Device memory for the fragments of a frame, as in 256MiB.
    ///
    /// Default: three quarters of the memory of the device, less the cloud.
    #[arg(long, value_name = "SIZE", help_heading = headings::DEVICE)]
    memory_budget: Option<ByteSize>,
    /// Keep names and WGSL source in the shaders, for debuggers such as RenderDoc and Nsight.
    ///
    /// No value of a picture changes. Shaders are compiled anew at the first use of this option.
    #[arg(long, help_heading = headings::DEVICE, hide_short_help = true)]
    debug_shaders: bool,
}

impl DeviceArgs {
    /// Returns the device memory for the fragments of a frame, in bytes.
    pub fn budget(&self) -> Option<u64> {
        self.memory_budget.map(|budget| budget.as_u64())
    }

    /// Returns options for opening the device.
    pub fn options(&self) -> DeviceOptions {
        let (device, debug_shaders) = (self.device.clone(), self.debug_shaders);
        DeviceOptions { device, debug_shaders, ..DeviceOptions::from_env() }
    }

    /// Opens the device, in the phase in which points come to it.
    pub fn open(&self, progress: &Bar) -> Result<Device> {
        open(&self.options(), progress)
    }
}

/// Opens a device, in the phase in which points come to it.
pub fn open(options: &DeviceOptions, progress: &Bar) -> Result<Device> {
    progress.begin(Phase::Upload);
    progress.stage("uploading");
    Ok(Device::open(options)?)
}

/// Measurements of a frame, as files.
#[derive(Debug, Args)]
pub struct MeasureArgs {
    /// Write the time of each pass and of each phase on the CPU as JSON.
    #[arg(long, value_name = "FILE.json", help_heading = headings::MEASUREMENTS)]
    pub profile: Option<PathBuf>,
    /// Write a timeline of phases, frames and passes; opens in Perfetto.
    #[arg(long, value_name = "FILE.json", help_heading = headings::MEASUREMENTS)]
    pub trace: Option<PathBuf>,
}

impl MeasureArgs {
    /// True if passes have to be timed.
    pub fn is_asked(&self) -> bool {
        self.profile.is_some() || self.trace.is_some()
    }

    /// The files that are written.
    pub fn writes(&self) -> impl Iterator<Item = Output> {
        let files = [("--profile", &self.profile), ("--trace", &self.trace)];
        files.into_iter().filter_map(|(option, path)| Some(Output::file(option, path.as_deref()?)))
    }

    /// Refuses files that could not be written in the end.
    pub fn check(&self) -> Result<()> {
        for path in [&self.profile, &self.trace].into_iter().flatten() {
            output::check_folder(path)?;
        }
        Ok(())
    }

    /// Writes the files that were asked for.
    pub fn write(&self, profile: &Value, trace: impl FnOnce() -> Value) -> Result<()> {
        self.profile.as_ref().map_or(Ok(()), |path| write_json(path, profile))?;
        self.trace.as_ref().map_or(Ok(()), |path| write_json(path, &trace()))
    }
}

/// Writes a value as JSON, all or nothing.
pub fn write_json(path: &Path, value: &Value) -> Result<()> {
    Ok(output::write_atomically(path, |file| writeln!(file, "{value:#}"))?)
}

/// Refuses a command line by the first of some problems that applies.
pub fn refuse<const N: usize>(problems: [(bool, impl Into<String>); N]) -> Result<()> {
    problems.into_iter().find(|(applies, _)| *applies).map_or(Ok(()), |(_, problem)| Err(usage(problem)))
}

/// Parses a number that fits; `expected` is the error for everything else.
pub fn number(fits: fn(&f64) -> bool, expected: &'static str) -> impl TypedValueParser<Value = f64> {
    move |text: &str| text.parse().ok().filter(fits).ok_or(expected)
}

/// Words for the picture that errors are measured against.
pub const AGAINST: &[(&str, Against)] = &[("center", Against::Center), ("area", Against::Area)];

/// Parses one of some words as the value that it stands for.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    words: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    let value = move |word: String| words.iter().find(|(known, _)| *known == word).map(|(_, value)| *value);
    PossibleValuesParser::new(words.iter().map(|(word, _)| *word))
        .try_map(move |word| value(word).ok_or("no such word"))
}
