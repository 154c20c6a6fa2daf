//! Requirements of a command: what ranks count and share, and on which devices.

use pellucid_engine::{Result, gpu};

use super::ranks::Ranks;
use crate::commands::DeviceArgs;
use crate::commands::mpi_args::Wanted;

/// Requirements of a command on a stage.
pub struct Setting<'a> {
    pub device: &'a DeviceArgs,
    pub share: Wanted,
}

/// The device of a rank: the one that is asked for, or, where the host has several GPUs, that of the rank's number on
/// the host.
pub fn device_of(asked: &DeviceArgs, ranks: &Ranks) -> Result<Option<String>> {
    if asked.device.is_some() {
        return Ok(asked.device.clone());
    }
    let (all, _) = gpu::devices(None)?;
    let gpus: Vec<usize> =
        all.iter().filter(|d| d.kind.contains("discrete") && d.lacks.is_empty()).map(|d| d.index).collect();
    Ok(if gpus.len() > 1 { Some(gpus[ranks.local() % gpus.len()].to_string()) } else { None })
}
