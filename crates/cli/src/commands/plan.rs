//! `pellucid plan`.

use std::process::ExitCode;

use clap::Args;
use pellucid_engine::methods::Stop;
use pellucid_engine::{Result, plan};
use serde_json::json;

use super::DeviceArgs;
use super::console::{Console, print, print_json};
use super::input::InputArgs;
use super::loaded::prepare;
use super::session::Session;

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Print the plan as JSON.
    #[arg(long)]
    pub json: bool,
}

pub fn run(args: PlanArgs, console: Console) -> Result<ExitCode> {
    let progress = console.progress();
    let resolved = prepare(&args.input, console, &progress)?;
    let mut session = Session::open(&args.device, &resolved, true, Stop::Exact, &progress)?;
    session.warn(&resolved, console);
    // Count lists as `profile` does, except for methods without lists.
    session.frame.fragments = !session.frame.counts_on_demand();
    let facts = session.renderer.survey(&mut session.cloud, &session.frame)?;
    progress.finish_and_clear();
    let mut steps =
        plan::plan(&session.device, &session.frame, &facts, session.renderer.switches.wide_atomics, &session.why);
    // The first pass takes the points, and their colors.
    if let Some(first) = steps.iter_mut().find(|step| step.on) {
        first.reason = [std::slice::from_ref(&first.reason), &resolved.colorings].concat().join("; ");
    }
    if args.json {
        print_json(&json!(steps))?;
    } else {
        let line = |s: &plan::Step| format!("{:<22} {:<3} {}\n", s.name, if s.on { "on" } else { "off" }, s.reason);
        print(&steps.iter().map(line).collect::<String>())?;
    }
    Ok(ExitCode::SUCCESS)
}
