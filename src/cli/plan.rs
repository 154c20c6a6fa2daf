//! `pellucid plan`.

use std::process::ExitCode;

use clap::Args;
use pellucid::{Result, scene};

use super::DeviceArgs;
use super::input::{InputArgs, prepare};
use super::talk::Talk;

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: PlanArgs, talk: Talk) -> Result<ExitCode> {
    let progress = talk.progress();
    let resolved = prepare(&args.input, talk, &progress)?;
    progress.finish_and_clear();
    // The plan goes here.
    let _ = (resolved, args.json, args.device);
    Err(scene::Error::Usage("plan is not built yet".into()).into())
}
