//! `pellucid plan`.

use clap::Args;
use pellucid_engine::{Result, plan};
use pellucid_session::{FrameRequest, Prepared, Request, Session};
use serde_json::json;

use super::bar::Bar;
use super::console::Console;
use super::input::InputArgs;
use super::options::DeviceArgs;
use super::touched::{Touched, Touches};

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

impl PlanArgs {
    /// Reads the inputs.
    fn prepare(&self, progress: &Bar) -> Result<Prepared> {
        let frame = FrameRequest { memory_budget: self.device.budget(), counts: true, ..FrameRequest::default() };
        let request = Request { frame, ..self.input.request(None, progress)? };
        Prepared::new(request, progress, progress)
    }
}

impl Touches for PlanArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::reads(self.input.reads()))
    }
}

pub fn run(args: PlanArgs, console: Console) -> Result<()> {
    let progress = console.progress();
    let prepared = args.prepare(&progress)?;
    let mut session = Session::open(&args.device.open(&progress)?, prepared, &progress, &progress)?;
    session.warn(&progress);
    session.settle(&progress)?;
    let steps = session.plan()?;
    progress.finish_and_clear();
    if args.json {
        return console.print_json(&json!(steps));
    }
    let line = |s: &plan::Step| format!("{:<22} {:<3} {}\n", s.name, if s.on { "on" } else { "off" }, s.reason);
    console.print(&steps.iter().map(line).collect::<String>())
}

#[cfg(test)]
mod tests;
