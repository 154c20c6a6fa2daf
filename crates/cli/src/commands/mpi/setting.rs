//! Requirements of a command: what ranks count and share, and on which devices.

use std::path::Path;

use pellucid_engine::methods::Stop;
use pellucid_engine::{Result, gpu};

use super::ranks::Ranks;
use crate::commands::DeviceArgs;
use crate::commands::mpi_args::{SharingArgs, Wanted};
use crate::commands::render::{RenderArgs, is_png};

/// Requirements of a command on a stage.
pub struct Setting<'a> {
    pub device: &'a DeviceArgs,
    /// True if list lengths are counted.
    pub counted: bool,
    pub stop: Stop,
    pub share: Wanted,
    /// True if other depths are wanted beside those of first fragments.
    pub depths: bool,
}

impl<'a> Setting<'a> {
    /// Returns the inputs of a picture.
    pub fn of(args: &'a RenderArgs, sharing: &SharingArgs, output: &Path) -> Self {
        Self {
            device: &args.device,
            counted: args.aov || args.measure.is_asked(),
            stop: args.stop(output),
            share: sharing.share,
            depths: args.aov && !is_png(output),
        }
    }
}

/// The device of a rank: the one that is asked for, or, where the host has several GPUs, that of the rank's number on the host.
pub fn device_of(asked: &DeviceArgs, ranks: &Ranks) -> Result<Option<String>> {
    if asked.device.is_some() {
        return Ok(asked.device.clone());
    }
    let (all, _) = gpu::devices(None)?;
    let gpus: Vec<usize> =
        all.iter().filter(|d| d.kind.contains("discrete") && d.lacks.is_empty()).map(|d| d.index).collect();
    Ok(if gpus.len() > 1 { Some(gpus[ranks.local() % gpus.len()].to_string()) } else { None })
}
