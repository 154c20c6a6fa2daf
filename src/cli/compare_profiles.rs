//! Two profiles side by side: the median time of each pass, and the ratio.

use std::path::Path;

use pellucid::{Result, output};
use serde::Deserialize;
use serde_json::json;

use super::limit::Limit;
use super::talk::{print, print_json};

/// The part of a profile that is compared.
#[derive(Debug, Deserialize)]
struct Profile {
    frames: Vec<Frame>,
}

#[derive(Debug, Deserialize)]
struct Frame {
    gpu_ms: Option<f64>,
    passes: Vec<Pass>,
}

#[derive(Debug, Deserialize)]
struct Pass {
    name: String,
    gpu_ms: Option<f64>,
}

/// A pass, or the whole frame, in both profiles. `None`: not there or never measured.
#[derive(Debug, PartialEq)]
struct Row {
    name: String,
    a_ms: Option<f64>,
    b_ms: Option<f64>,
}

impl Row {
    /// B over A.
    fn ratio(&self) -> Option<f64> {
        Some(self.b_ms? / self.a_ms?)
    }
}

/// The name under which the whole frame is listed and limited.
const FRAME: &str = "frame";

/// Compares two profiles; false if a limit is broken.
pub fn run(a: &Path, b: &Path, json: bool, limits: &[Limit]) -> Result<bool> {
    let rows = rows(&read(a)?, &read(b)?);
    let mut within = true;
    let mut ratios = Vec::new();
    for limit in limits {
        let Some(row) = rows.iter().find(|row| row.name == limit.metric) else {
            return Err(limit.unusable("there is no pass of this name"));
        };
        let Some(ratio) = row.ratio() else {
            return Err(limit.unusable("not measured in both profiles"));
        };
        ratios.push((limit, ratio));
    }
    if json {
        print_json(&to_json(&rows))?;
    } else {
        print(&to_text(&rows))?;
    }
    for (limit, ratio) in ratios {
        within &= !limit.is_broken_by(ratio);
    }
    Ok(within)
}

fn read(path: &Path) -> Result<Profile, output::Error> {
    let text = std::fs::read_to_string(path).map_err(|source| output::Error::Read { path: path.to_owned(), source })?;
    serde_json::from_str(&text).map_err(|error| output::Error::Decode {
        path: path.to_owned(),
        reason: format!("not a profile as --profile writes it: {error}"),
    })
}

/// The frame first, then the passes in the order of A, then those that only B has.
fn rows(a: &Profile, b: &Profile) -> Vec<Row> {
    let mut names: Vec<&str> = Vec::new();
    for pass in a.frames.iter().chain(&b.frames).flat_map(|frame| &frame.passes) {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    let whole = |profile: &Profile| median(profile.frames.iter().filter_map(|frame| frame.gpu_ms).collect());
    let frame = Row { name: FRAME.to_owned(), a_ms: whole(a), b_ms: whole(b) };
    let passes = names.into_iter().map(|name| Row {
        name: name.to_owned(),
        a_ms: median(pass_times(a, name)),
        b_ms: median(pass_times(b, name)),
    });
    std::iter::once(frame).chain(passes).collect()
}

/// One time for each frame that measured the pass; a pass that runs several times in a frame (bands) counts as a sum.
fn pass_times(profile: &Profile, name: &str) -> Vec<f64> {
    let of_frame = |frame: &Frame| {
        let times = frame.passes.iter().filter(|pass| pass.name == name).filter_map(|pass| pass.gpu_ms);
        times.fold(None, |sum, time| Some(sum.unwrap_or(0.0) + time))
    };
    profile.frames.iter().filter_map(of_frame).collect()
}

/// The middle value, or the mean of the middle two.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let upper = *values.get(middle)?;
    if values.len() % 2 == 1 { Some(upper) } else { Some(0.5 * (values.get(middle - 1)? + upper)) }
}

fn to_json(rows: &[Row]) -> serde_json::Value {
    let row = |row: &Row| json!({ "name": row.name, "a_ms": row.a_ms, "b_ms": row.b_ms, "ratio": row.ratio() });
    let (frame, passes) = rows.split_at(1.min(rows.len()));
    json!({ "frame": frame.first().map(row), "passes": passes.iter().map(row).collect::<Vec<_>>() })
}

fn to_text(rows: &[Row]) -> String {
    let mut table = comfy_table::Table::new();
    table.load_style(comfy_table::presets::NOTHING).set_header(["pass", "A ms", "B ms", "B/A"]);
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
    for row in rows {
        table.add_row([row.name.clone(), number(row.a_ms), number(row.b_ms), number(row.ratio())]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(comfy_table::CellAlignment::Right);
    }
    table.trim_fmt() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(frames: &str) -> Profile {
        serde_json::from_str(&format!("{{\"version\": 1, \"frames\": [{frames}]}}")).unwrap()
    }

    #[test]
    fn medians_of_frames_and_sums_within_a_frame() {
        let frame = |gpu: f64, count: f64, again: f64| {
            format!(
                "{{\"gpu_ms\": {gpu}, \"passes\": [{{\"name\": \"x/count\", \"gpu_ms\": {count}}}, \
                 {{\"name\": \"x/count\", \"gpu_ms\": {again}}}]}}"
            )
        };
        // Sums 3, 5, 10: median 5. Frames 4, 6, 11: median 6.
        let a = profile(&[frame(4.0, 1.0, 2.0), frame(11.0, 9.0, 1.0), frame(6.0, 2.0, 3.0)].join(","));
        let b = profile(
            "{\"gpu_ms\": 3, \"passes\": [{\"name\": \"y\", \"gpu_ms\": null}]}, {\"gpu_ms\": 6, \"passes\": []}",
        );
        let rows = rows(&a, &b);
        let row = |name: &str, a_ms, b_ms| Row { name: name.into(), a_ms, b_ms };
        // The median of two frames of 3 and 6 is 4.5.
        assert_eq!(rows, [row(FRAME, Some(6.0), Some(4.5)), row("x/count", Some(5.0), None), row("y", None, None)]);
        assert_eq!(rows[0].ratio(), Some(0.75));
        assert_eq!(rows[1].ratio(), None);
    }
}
