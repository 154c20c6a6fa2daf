//! `pellucid devices`.

use bytesize::ByteSize;
use clap::Args;
use pellucid_engine::{Result, methods};
use pellucid_gpu as gpu;
use serde_json::json;

use super::console::Console;
use super::touched::{Touched, Touches};

#[derive(Debug, Args)]
pub struct DevicesArgs {
    /// Mark the device that this index or part of a name selects.
    #[arg(long, value_name = "NAME_OR_INDEX")]
    device: Option<String>,
    /// Print the list as JSON.
    #[arg(long)]
    json: bool,
}

/// The first Mesa whose driver for CPUs was measured to be faster.
const FAST_MESA: u32 = 25;

/// Mesa's version where its driver for CPUs has a faster successor.
fn slow_mesa(driver: &str) -> Option<&str> {
    let version = driver.strip_prefix("llvmpipe Mesa ")?.split_whitespace().next()?;
    let major = version.split('.').next()?.parse::<u32>().ok()?;
    (major < FAST_MESA).then_some(version)
}

impl Touches for DevicesArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::default())
    }
}

pub fn run(args: DevicesArgs, console: Console) -> Result<()> {
    let (devices, taken) = gpu::devices(args.device.as_deref())?;
    if args.json {
        let list: Vec<_> = devices
            .iter()
            .map(|d| {
                let memory = json!({
                    "heap_bytes": d.heap_bytes,
                    "budget_bytes": d.memory.map(|memory| memory.budget),
                    "used_bytes": d.memory.map(|memory| memory.used),
                });
                json!({
                    "index": d.index,
                    "name": d.name,
                    "driver": d.driver,
                    "lacks": lacks(d),
                    "memory": memory,
                    "taken": taken == Some(d.index),
                })
            })
            .collect();
        return console.print_json(&json!(list));
    }
    let mut text = String::new();
    for d in &devices {
        let mark = if taken == Some(d.index) { '*' } else { ' ' };
        let lacks = match lacks(d) {
            lacks if lacks.is_empty() => "nothing".to_owned(),
            lacks => lacks.join(", "),
        };
        text += &format!("{mark} {} {} ({}, {}); lacks {lacks}\n", d.index, d.name, d.kind, d.driver);
        text += &format!("    {}\n", memory(d));
        if let Some(version) = slow_mesa(&d.driver) {
            text += &format!(
                "    Mesa {version} is old: with Mesa 25 most methods take a tenth to a third less time on a CPU \
                 (docs/performance.md)\n"
            );
        }
    }
    text += if taken.is_some() { "* selected\n" } else { "no device can be used\n" };
    console.print(&text)
}

/// Memory of a device, and how much of it is free.
fn memory(device: &gpu::DeviceInfo) -> String {
    let all = ByteSize(device.heap_bytes);
    match device.memory {
        Some(memory) => format!("memory: {} of {all} free", ByteSize(memory.free())),
        None => format!("memory: {all}; the driver doesn't tell how much is free (no VK_EXT_memory_budget)"),
    }
}

/// Features that a device lacks: those without which it can't be used, else those that some methods need.
fn lacks(device: &gpu::DeviceInfo) -> Vec<String> {
    let methods = methods::without_subgroups(device);
    if !device.lacks.is_empty() || methods.is_empty() {
        return device.lacks.clone();
    }
    let methods = methods.join(", ");
    vec![format!("subgroups of 8 to 32 invocations (needed by {methods}, and by soft methods with solid points)")]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_driver_for_cpus_is_told_from_a_new_one_and_from_others() {
        assert_eq!(slow_mesa("llvmpipe Mesa 22.3.6 (LLVM 15.0.6)"), Some("22.3.6"));
        assert_eq!(slow_mesa("llvmpipe Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)"), None);
        assert_eq!(slow_mesa("llvmpipe Mesa git"), None);
        assert_eq!(slow_mesa("radv Mesa 22.3.6"), None);
        assert_eq!(slow_mesa(""), None);
    }
}
