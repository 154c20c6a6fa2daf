//! `pellucid profile`.

use std::process::ExitCode;

use clap::Args;
use pellucid::{Result, scene};

use super::input::{InputArgs, prepare};
use super::talk::Talk;
use super::{DeviceArgs, MeasureArgs};

#[derive(Debug, Args)]
pub struct ProfileArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    measure: MeasureArgs,
    /// Frames to measure.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Print the measurements as JSON, as --profile writes them, instead of the table.
    #[arg(long)]
    json: bool,
}

pub fn run(args: ProfileArgs, talk: Talk) -> Result<ExitCode> {
    args.measure.check()?;
    let progress = talk.progress();
    let resolved = prepare(&args.input, talk, &progress)?;
    progress.finish_and_clear();
    // Device, frames, table or JSON go here.
    let _ = (resolved, args.frames, args.json, args.device);
    Err(scene::Error::Usage("profile is not built yet".into()).into())
}
