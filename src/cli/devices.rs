//! `pellucid devices`.

use std::process::ExitCode;

use clap::Args;
use pellucid::{Result, scene};

use super::talk::Talk;

#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Device that would be asked for: its index or a part of its name.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// Print the list as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: DevicesArgs, _talk: Talk) -> Result<ExitCode> {
    // The list goes here.
    let _ = (args.device, args.json);
    Err(scene::Error::Usage("devices is not built yet".into()).into())
}
