//! `pellucid devices`.

use std::process::ExitCode;

use clap::Args;
use pellucid_engine::{Result, gpu, methods};
use serde_json::json;

use super::console::{Console, print, print_json};

#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Device that would be asked for: its index or a part of its name.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// Print the list as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: DevicesArgs, _talk: Console) -> Result<ExitCode> {
    let (devices, taken) = gpu::devices(args.device.as_deref())?;
    if args.json {
        let list: Vec<_> = devices
            .iter()
            .map(|d| json!({"index": d.index, "name": d.name, "driver": d.driver, "lacks": d.lacks, "taken": taken == Some(d.index)}))
            .collect();
        print_json(&json!(list))?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut text = String::new();
    for d in &devices {
        let mark = if taken == Some(d.index) { '*' } else { ' ' };
        let methods = methods::without_subgroups(d);
        let lacks = if !d.lacks.is_empty() {
            d.lacks.join(", ")
        } else if methods.is_empty() {
            "nothing".to_owned()
        } else {
            let methods = methods.join(", ");
            format!("subgroups of 8 to 32 invocations, which {methods} need, and soft methods with solid points")
        };
        text += &format!("{mark} {} {} ({}, {}); lacks {lacks}\n", d.index, d.name, d.kind, d.driver);
    }
    text += if taken.is_some() { "* would be taken\n" } else { "none can be taken\n" };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}
