//! Sessions of commands: on the device of the arguments, with the command's progress.

use std::io::Write;
use std::path::Path;

use pellucid_engine::gpu::{Device, DeviceOptions};
use pellucid_engine::profile::Profile;
use pellucid_engine::progress::Phase;
use pellucid_engine::{Result, output};
use pellucid_session::{Prepared, Session};
use serde_json::Value;

use super::bar::Bar;
use super::console::Console;
use super::{DeviceArgs, MeasureArgs};

/// Opens the device and brings a prepared request to it, with method and opacity decided.
pub fn open(args: &DeviceArgs, prepared: Prepared, progress: &Bar, console: Console) -> Result<Session> {
    let mut session = upload(args, prepared, false, progress)?;
    session.decide(&console)?;
    Ok(session)
}

/// Opens the device and brings a prepared request to it; the method is the scene's, or for `auto` one of the same
/// image.
pub fn upload(args: &DeviceArgs, prepared: Prepared, by_windows: bool, progress: &Bar) -> Result<Session> {
    progress.begin(Phase::Upload);
    progress.stage("uploading");
    Session::upload(&device(args)?, prepared, by_windows, progress)
}

/// Opens the device of the arguments.
pub fn device(args: &DeviceArgs) -> Result<Device> {
    Ok(Device::open(&DeviceOptions { device: args.device.clone(), ..DeviceOptions::from_env() })?)
}

impl MeasureArgs {
    /// Writes the files that were asked for.
    pub fn write(&self, profile: &Profile) -> Result<()> {
        self.write_profile(&profile.to_json())?;
        self.write_trace(profile)
    }

    /// Writes the profile, if it was asked for.
    pub fn write_profile(&self, profile: &Value) -> Result<()> {
        match &self.profile {
            Some(path) => write_json(path, profile),
            None => Ok(()),
        }
    }

    /// Writes the trace, if it was asked for.
    pub fn write_trace(&self, profile: &Profile) -> Result<()> {
        if let Some(path) = &self.trace {
            write_json(path, &profile.to_trace())?;
        }
        Ok(())
    }
}

/// Writes a value as JSON, all or nothing.
pub fn write_json(path: &Path, value: &Value) -> Result<()> {
    output::write_atomically(path, |file| writeln!(file, "{value:#}"))?;
    Ok(())
}
