//! The shapes of passes as a Markdown table: of each label the worst of its pipelines.

use std::fmt::Write;

use crate::compile::Shape;
use crate::record::Recorded;

/// The worst of some pipelines with one label.
pub struct Line {
    pub label: String,
    pub pipelines: usize,
    /// `None` where all of them crash the driver's compiler.
    pub worst: Option<Shape>,
    /// Number of those that crash it.
    pub crashed: usize,
}

/// Returns a line for each label, those that crash the compiler first, then the fewest waves, the most scratch and
/// registers.
pub fn by_label(recorded: &[Recorded], shapes: &[Option<Shape>]) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (recorded, shape) in recorded.iter().zip(shapes) {
        let place = lines.iter().position(|line| line.label == recorded.label).unwrap_or_else(|| {
            lines.push(Line { label: recorded.label.clone(), pipelines: 0, worst: None, crashed: 0 });
            lines.len() - 1
        });
        let line = &mut lines[place];
        line.pipelines += 1;
        match (shape, &line.worst) {
            (None, _) => line.crashed += 1,
            (Some(shape), None) => line.worst = Some(*shape),
            (Some(shape), Some(known)) => line.worst = Some(worst(known, shape)),
        }
    }
    let rank = |line: &Line| {
        let shape = |s: &Shape| [s.waves, -s.scratch_bytes, -s.vgprs, -s.code_bytes];
        (-(line.crashed as f64), line.worst.as_ref().map(shape))
    };
    lines.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
    lines
}

/// The worse of each.
fn worst(a: &Shape, b: &Shape) -> Shape {
    Shape {
        lanes: a.lanes.max(b.lanes),
        vgprs: a.vgprs.max(b.vgprs),
        sgprs: a.sgprs.max(b.sgprs),
        spilled_vgprs: a.spilled_vgprs.max(b.spilled_vgprs),
        spilled_sgprs: a.spilled_sgprs.max(b.spilled_sgprs),
        scratch_bytes: a.scratch_bytes.max(b.scratch_bytes),
        lds_bytes: a.lds_bytes.max(b.lds_bytes),
        waves: a.waves.min(b.waves),
        code_bytes: a.code_bytes.max(b.code_bytes),
        latency: a.latency.max(b.latency),
        inverse_throughput: a.inverse_throughput.max(b.inverse_throughput),
        compile_ms: a.compile_ms.max(b.compile_ms),
    }
}

pub fn markdown(lines: &[Line]) -> String {
    let mut text = "| pass | pipelines | waves of 16 | VGPRs | SGPRs | spilled | scratch B/lane | LDS B | code KiB | latency | inverse throughput | compile ms |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n"
        .to_owned();
    for Line { label, pipelines, worst, crashed } in lines {
        let label = match crashed {
            0 => label.clone(),
            _ => format!("{label} (the driver crashes at {crashed}: its fault)"),
        };
        let Some(s) = worst else {
            let _ = writeln!(text, "| {label} | {pipelines} |{}", " – |".repeat(10));
            continue;
        };
        let spilled = s.spilled_vgprs + s.spilled_sgprs;
        let _ = writeln!(
            text,
            "| {label} | {pipelines} | {} | {} | {} | {spilled} | {} | {} | {:.1} | {} | {} | {:.0} |",
            s.waves,
            s.vgprs,
            s.sgprs,
            s.scratch_bytes,
            s.lds_bytes,
            s.code_bytes / 1024.0,
            s.latency,
            s.inverse_throughput,
            s.compile_ms
        );
    }
    text
}
