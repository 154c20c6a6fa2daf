//! The per-pass table of a profile, for people.

use std::time::Duration;

use bytesize::ByteSize;
use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use pellucid_engine::methods::FrameProfile;
use pellucid_engine::pipelines::{Pipelines, Shape};
use pellucid_engine::profile::{self, Profile, median};
use pellucid_engine::totals::Totals;

/// The per-pass table over all frames: least, median and greatest device time, share of the frame, and bytes moved.
///
/// `copy_rate` in bytes per second (reads and writes together), from
/// [`copy_rate`](pellucid_engine::profile::copy_rate).
pub fn profile_table(profile: &Profile, copy_rate: Option<f64>) -> String {
    let mut table = Table::new();
    let line = LineStyle::none().fill('─').junction('─');
    table.load_style(TableStyle::new().top_border(line).header_separator(line).bottom_border(line));
    let header = ["pass", "min ms", "median ms", "max ms", "share", "invocations", "MiB", "GB/s", "of copy rate"];
    let compiled = if matches!(profile.pipelines, Pipelines::Told(_)) { &COMPILED[..] } else { &[] };
    table.set_header(header.iter().chain(compiled));
    let rows = profile.passes();
    let total: f64 = rows.iter().map(|r| r.median).sum();
    for row in &rows {
        let seconds = row.median / 1e3;
        let rate = row.bytes.filter(|_| seconds > 0.0).map(|b| b as f64 / seconds);
        let cells = [
            row.name.to_owned(),
            format!("{:.3}", row.min),
            format!("{:.3}", row.median),
            format!("{:.3}", row.max),
            format!("{:.1}%", 100.0 * row.median / total.max(f64::MIN_POSITIVE)),
            row.invocations.map_or_else(String::new, |n| n.to_string()),
            row.bytes.map_or_else(String::new, |b| format!("{:.1}", b as f64 / f64::from(1 << 20))),
            rate.map_or_else(String::new, |r| format!("{:.2}", r / 1e9)),
            rate.zip(copy_rate).map_or_else(String::new, |(r, c)| format!("{:.0}%", 100.0 * r / c)),
        ];
        let shape = profile.pipelines.of_pass(row.name).unwrap_or_default();
        table.add_row(cells.into_iter().chain(compiled_cells(shape).into_iter().take(compiled.len())));
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{}\n{table}\n{}", head(profile), foot(profile, copy_rate))
}

/// Columns of what the driver's compiler says.
const COMPILED: [&str; 4] = ["registers", "spills", "shared B", "code KiB"];

fn compiled_cells(shape: Shape) -> [String; COMPILED.len()] {
    let whole = |figure: Option<f64>| figure.map_or_else(String::new, |figure| format!("{figure:.0}"));
    let code = shape.code_bytes.map_or_else(String::new, |bytes| format!("{:.1}", bytes / 1024.0));
    [whole(shape.registers), whole(shape.spills), whole(shape.shared_bytes), code]
}

fn head(profile: &Profile) -> String {
    let samples = match profile.samples {
        1 => String::new(),
        samples => format!(" with {samples} samples each (passes and fragments are those of {samples} images)"),
    };
    format!(
        "{} ({}), {} frame(s)\n{} points, {} pixels{samples}, {} fragments, longest list {}",
        profile.device,
        profile.driver,
        profile.frames.len(),
        profile.facts.points,
        profile.pixels,
        profile.facts.fragments,
        profile.facts.max_list
    )
}

fn foot(profile: &Profile, copy_rate: Option<f64>) -> String {
    let median =
        |f: fn(&FrameProfile) -> Duration| median(profile.frames.iter().map(|p| f(p).as_secs_f64() * 1e3).collect());
    let (gpu, submitted, wall) = (median(FrameProfile::gpu), median(|f| f.submitted), median(|f| f.wall));
    let mut lines = vec![format!(
        "passes {gpu:.2} ms of {submitted:.2} ms submitted ({:.1}%), frame with read-back {wall:.2} ms",
        100.0 * gpu / submitted.max(f64::MIN_POSITIVE)
    )];
    let whole: Vec<f64> = profile.frames.iter().filter_map(|f| Some(f.total?.as_secs_f64() * 1e3)).collect();
    if !whole.is_empty() {
        let waits = profile::median(profile.frames.iter().map(|f| f.waits as f64).collect());
        lines.push(format!(
            "without timestamps between passes: {:.2} ms on the device; {waits} wait(s) a frame",
            profile::median(whole)
        ));
    }
    lines.extend(profile.totals.as_ref().map(Totals::line));
    let free = profile.memory.map(|memory| format!("; {} were free before", ByteSize(memory.free())));
    lines.push(format!(
        "device memory: peak {}, fragments {} in {} band(s){}",
        ByteSize(profile.facts.peak_device_bytes),
        ByteSize(profile.facts.fragment_bytes),
        profile.facts.bands,
        free.unwrap_or_default()
    ));
    if let Some(rate) = copy_rate {
        lines.push(format!("copy rate of this device: {:.2} GB/s, reads and writes together", rate / 1e9));
    }
    if profile.pipelines == Pipelines::Untold {
        lines.push(format!(
            "pipelines: {} doesn't tell what its compiler made of them (no VK_KHR_pipeline_executable_properties)",
            profile.device
        ));
    }
    lines.extend(profile.work_line());
    lines.extend(profile.adjustment_lines());
    lines.push(profile.host_text());
    lines.join("\n")
}
