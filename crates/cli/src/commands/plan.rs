//! `pellucid plan`.

use std::process::ExitCode;

use clap::Args;
use pellucid_engine::{Result, plan};
use pellucid_session::{FrameRequest, Prepared, Request};
use serde_json::json;

use super::DeviceArgs;
use super::console::Console;
use super::input::InputArgs;
use super::session;

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
    let memory_budget = args.device.memory_budget.map(|budget| budget.as_u64());
    let frame = FrameRequest { memory_budget, counts: true, ..FrameRequest::default() };
    let request = Request { frame, ..args.input.request(None, &progress, console)? };
    let prepared = Prepared::new(request, &console, &progress)?;
    let mut session = session::open(&args.device, prepared, &progress, console)?;
    session.warn(&console);
    // Count lists as `profile` does, except for methods without lists.
    session.frame.fragments = !session.frame.counts_on_demand();
    let facts = session.renderer.survey(&mut session.uploaded.cloud, &session.frame)?;
    progress.finish_and_clear();
    let mut steps =
        plan::plan(&session.device, &session.frame, &facts, session.renderer.switches.wide_atomics, &session.why);
    // The first pass takes the points, and their colors.
    if let Some(first) = steps.iter_mut().find(|step| step.on) {
        first.reason = [std::slice::from_ref(&first.reason), &session.assembled().colorings].concat().join("; ");
    }
    if args.json {
        console.print_json(&json!(steps))?;
    } else {
        let line = |s: &plan::Step| format!("{:<22} {:<3} {}\n", s.name, if s.on { "on" } else { "off" }, s.reason);
        console.print(&steps.iter().map(line).collect::<String>())?;
    }
    Ok(ExitCode::SUCCESS)
}
