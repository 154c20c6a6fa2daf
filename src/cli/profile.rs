//! `pellucid profile`.

use std::process::ExitCode;

use clap::Args;
use pellucid::{Result, profile};

use super::input::{InputArgs, prepare};
use super::session::Session;
use super::talk::{Talk, counted, print, print_json};
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
    let mut session = Session::open(&args.device, &resolved, true, &progress)?;
    session.describe(talk);
    // The first frame pays for pipelines and buffers.
    let first = session.render()?;
    session.renderer.recycle(first.image);
    let mut profile = session.profile();
    counted(&progress, "measuring", args.frames.into());
    for _ in 0..args.frames {
        let rendered = session.render()?;
        profile.add(&rendered);
        session.renderer.recycle(rendered.image);
        progress.inc(1);
    }
    let copy_rate = profile::copy_rate(&session.device)?;
    progress.finish_and_clear();
    args.measure.write(&profile)?;
    if args.json {
        print_json(&profile.to_json())?;
    } else {
        print(&format!("{}\n", profile.table(Some(copy_rate))))?;
    }
    Ok(ExitCode::SUCCESS)
}
