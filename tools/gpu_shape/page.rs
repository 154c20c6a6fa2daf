//! The page docs/gpu-shape.md: pipelines on a GPU's compiler, and the estimated time of each pass of the built-in
//! scene.

use std::fmt::Write;

use crate::FAMILY;
use crate::compile::{self, Driver, Lanes, Shape, Shapes};
use crate::estimate::{Bound, Estimate, GPUS, Gpu, estimate};
use crate::record::{Recorded, Recording};
use crate::table;

const HEAD: &str = include_str!("page.md");
/// Changes of one version, by figures of two versions of this page.
const CHANGES: &str = include_str!("changes.md");
/// Estimates below this, in microseconds on the first of the GPUs, share a line.
const SMALL_US: f64 = 50.0;

/// The whole page.
pub fn text(driver: &Driver, recorded: &[Recorded], frames: &[Recording]) -> Result<String, String> {
    let narrow = compile::on(driver, FAMILY, Lanes::ThirtyTwo, recorded)?;
    let wide = compile::on(driver, FAMILY, Lanes::SixtyFour, recorded)?;
    let mut text = HEAD.to_owned();
    let _ =
        writeln!(text, "{}\n\n{}", summary(&narrow), table::markdown(&table::by_label(recorded, &narrow.pipelines)));
    let _ = writeln!(text, "## Waves of 64\n\n{}", widened(recorded, &narrow, &wide));
    let mut gpus = Vec::new();
    let mut missing = String::new();
    for gpu in &GPUS {
        match of_gpu(driver, gpu, recorded) {
            Ok(shapes) => gpus.push((gpu, shapes)),
            Err(error) => missing.push_str(&format!("The {} has no estimate: {error}.\n\n", gpu.name)),
        }
    }
    text.push_str(&estimates(recorded, frames, &gpus));
    text.push_str(&missing);
    text.push_str(CHANGES);
    Ok(text)
}

/// The first of a GPU's families that the driver knows.
fn of_gpu(driver: &Driver, gpu: &Gpu, recorded: &[Recorded]) -> Result<Shapes, String> {
    let mut last = Err(format!("{}: no family", gpu.name));
    for family in gpu.families {
        last = compile::on(driver, family, Lanes::ThirtyTwo, recorded);
        if last.is_ok() {
            break;
        }
    }
    last
}

fn summary(shapes: &Shapes) -> String {
    let all = &shapes.pipelines;
    let count = |which: fn(&Shape) -> bool| all.iter().flatten().filter(|shape| which(shape)).count();
    format!(
        "{}: {} pipelines, {} of them with 8 of 16 waves or more, {} without scratch, {} without spills, {} within 32 KiB of code.",
        shapes.device,
        all.len(),
        count(|s| s.waves >= 8.0),
        count(|s| s.scratch_bytes == 0.0),
        count(|s| s.spilled_vgprs + s.spilled_sgprs == 0.0),
        count(|s| s.code_bytes <= 32768.0),
    )
}

/// Passes that have no say in their subgroups, where waves have 64 lanes.
fn widened(recorded: &[Recorded], narrow: &Shapes, wide: &Shapes) -> String {
    let free = |shapes: &Shapes| -> Vec<_> {
        let shapes = recorded.iter().zip(&shapes.pipelines).filter(|(recorded, _)| recorded.subgroup.is_none());
        shapes.map(|(recorded, shape)| (recorded.clone(), *shape)).collect()
    };
    let lines = |shapes: &Shapes| {
        let (recorded, shapes): (Vec<_>, Vec<_>) = free(shapes).into_iter().unzip();
        table::by_label(&recorded, &shapes)
    };
    let before = lines(narrow);
    let fewer = |line: &table::Line| {
        let known = before.iter().find(|known| known.label == line.label).and_then(|known| known.worst);
        let (Some(known), Some(worst)) = (known, line.worst) else { return true };
        worst.waves < known.waves.min(8.0) || worst.spilled_sgprs > known.spilled_sgprs
    };
    let worse: Vec<_> = lines(wide).into_iter().filter(fewer).collect();
    if worse.is_empty() {
        return "No pass is below 8 waves that isn't with 32 lanes, and none spills more.\n".into();
    }
    format!(
        "Passes with fewer waves than with 32 lanes, and fewer than 8, or with more spills:\n\n{}",
        table::markdown(&worse)
    )
}

fn estimates(recorded: &[Recorded], frames: &[Recording], gpus: &[(&Gpu, Shapes)]) -> String {
    let mut text = "## Estimated frames\n\n".to_owned();
    text.push_str("The built-in scene at 1280 × 720, µs: **m** bound by memory, **a** by arithmetic, **l** by the latency of one wave.\n");
    for (gpu, shapes) in gpus {
        text.push_str(&crashes(gpu, recorded, shapes));
    }
    for frame in frames {
        let _ = write!(text, "\n### {}\n\n| pass |", frame.method);
        gpus.iter().for_each(|(gpu, _)| _ = write!(text, " {} |", gpu.name));
        let _ = writeln!(text, "\n|---|{}", "--:|".repeat(gpus.len()));
        let mut totals = vec![0.0; gpus.len()];
        let mut rest = vec![0.0; gpus.len()];
        let mut small = 0;
        for pass in &frame.profile.passes {
            let found: Vec<Option<Estimate>> =
                gpus.iter().map(|(gpu, shapes)| of_pass(recorded, frame, gpu, shapes, pass)).collect();
            let Some(first) = found.iter().flatten().next() else { continue };
            let us = |e: &Option<Estimate>| e.map_or(0.0, |e| e.us);
            totals.iter_mut().zip(&found).for_each(|(total, e)| *total += us(e));
            if first.us < SMALL_US {
                small += 1;
                rest.iter_mut().zip(&found).for_each(|(rest, e)| *rest += us(e));
                continue;
            }
            let _ = write!(text, "| {} |", pass.name);
            found.iter().for_each(|e| _ = write!(text, " {} |", cell(e)));
            text.push('\n');
        }
        let sum = |values: &[f64]| values.iter().map(|us| format!(" {us:.0} |")).collect::<String>();
        if small > 0 {
            let _ = writeln!(text, "| {small} smaller |{}", sum(&rest));
        }
        let _ = writeln!(text, "| **all** |{}", sum(&totals));
    }
    text
}

/// A sentence on pipelines that the driver's compiler crashes at, if there are any.
fn crashes(gpu: &Gpu, recorded: &[Recorded], shapes: &Shapes) -> String {
    let lines = table::by_label(recorded, &shapes.pipelines);
    let crashed: Vec<_> = lines.iter().filter(|line| line.crashed > 0).collect();
    if crashed.is_empty() {
        return String::new();
    }
    let each = crashed.iter().map(|line| format!("{} of {} of `{}`", line.crashed, line.pipelines, line.label));
    let each: Vec<_> = each.collect();
    format!(
        "\nFor the {} ({}) the driver's compiler crashes at some pipelines, which is its fault: {}. Where a frame has no \
         other of that pass, the cell is empty, and the total goes without it.\n",
        gpu.name,
        shapes.device,
        each.join(", ")
    )
}

fn cell(estimate: &Option<Estimate>) -> String {
    let letter = |bound| match bound {
        Bound::Memory => "m",
        Bound::Arithmetic => "a",
        Bound::Latency => "l",
    };
    estimate.map_or_else(String::new, |e| format!("{:.0} {}", e.us, letter(e.bound)))
}

/// A pass by the pipeline of its label that keeps a SIMD busy longest.
fn of_pass(
    recorded: &[Recorded],
    frame: &Recording,
    gpu: &Gpu,
    shapes: &Shapes,
    pass: &pellucid_engine::methods::PassProfile,
) -> Option<Estimate> {
    let of_frame = |recorded: &Recorded| recorded.label == pass.name && frame.pipelines.contains(recorded);
    let shapes = recorded.iter().zip(&shapes.pipelines).filter_map(|(recorded, shape)| Some((recorded, (*shape)?)));
    let found = shapes.filter(|(recorded, _)| of_frame(recorded));
    let (recorded, shape) = found.max_by(|a, b| a.1.inverse_throughput.total_cmp(&b.1.inverse_throughput))?;
    let lanes = recorded.subgroup.map(|here| [f64::from(here), f64::from(shape.lanes)]);
    estimate(gpu, pass, &shape, lanes)
}
