//! Compares two profiles: the median time of each pass, the ratio, and if the ratio exceeds the noise.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use pellucid_engine::Result;
use pellucid_io::output;
use serde::Deserialize;
use serde_json::json;

use super::console::Console;
use super::limit::{Limit, Slower};
use super::noise::{MIN_TIMES, Times, Verdict};
use super::tables::table;

/// The part of a profile that is compared.
#[derive(Debug, Deserialize)]
struct Profile {
    #[serde(default)]
    device: ProfiledDevice,
    /// Absent in profiles of version 0.2.0 and before.
    method: Option<String>,
    /// Absent in profiles of version 0.2.0 and before, and of pictures that were rendered once.
    steady: Option<bool>,
    #[serde(default)]
    scene: ProfiledScene,
    frames: Vec<ProfiledFrame>,
}

#[derive(Debug, Default, Deserialize)]
struct ProfiledDevice {
    name: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
struct ProfiledScene {
    points: Option<u64>,
    pixels: Option<u64>,
    samples: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "struct Frame")]
struct ProfiledFrame {
    gpu_ms: Option<f64>,
    passes: Vec<ProfiledPass>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "struct Pass")]
struct ProfiledPass {
    name: String,
    gpu_ms: Option<f64>,
}

/// A pass, or the whole frame, in both profiles; no times where it isn't there or never measured.
#[derive(Debug, PartialEq)]
struct PassComparison {
    name: String,
    a: Times,
    b: Times,
    /// Share of the frame, in [0, 1], in the profile where it is larger.
    share: Option<f64>,
}

impl PassComparison {
    /// Median of B over that of A.
    fn ratio(&self) -> Option<f64> {
        Some(self.b.median()? / self.a.median()?)
    }

    /// The interval that should contain the ratio.
    fn interval(&self) -> Option<[f64; 2]> {
        self.b.ratio_interval(&self.a)
    }

    fn verdict(&self) -> Option<Verdict> {
        self.interval().map(Verdict::from_interval)
    }

    /// True if the pass is long enough for a limit that doesn't name it.
    fn counts(&self) -> bool {
        self.share.is_none_or(|share| share >= MIN_SHARE)
    }
}

/// The name under which the whole frame is listed and limited.
const FRAME: &str = "frame";

/// Passes below this share of the frame are judged, but fail nothing unless they are named.
const MIN_SHARE: f64 = 0.01;

/// Compares two profiles; false if they measure different things, and not `anyway`, or if a limit is broken.
pub fn run(
    [a, b]: [&Path; 2],
    (json, anyway): (bool, bool),
    limits: &[Limit],
    slower: &[Slower],
    console: Console,
) -> Result<bool> {
    let profiles = [read(a)?, read(b)?];
    let differences = differences(&profiles);
    if !differences.is_empty() && !anyway {
        console.report(format_args!(
            "error: {} and {} measure different things: {}; --anyway compares them nevertheless",
            a.display(),
            b.display(),
            differences.join(", ")
        ));
        return Ok(false);
    }
    let rows = rows(&profiles[0], &profiles[1]);
    let mut ratios = Vec::new();
    for limit in limits {
        let row = find(&rows, &limit.metric).ok_or_else(|| limit.unusable("no pass has this name"))?;
        let ratio = row.ratio().ok_or_else(|| limit.unusable("not measured in both profiles"))?;
        ratios.push((limit, ratio));
    }
    let mut intervals = Vec::new();
    for limit in slower {
        intervals.extend(judged(&rows, limit)?.into_iter().map(|judged| (limit, judged)));
    }
    if json {
        console.print_json(&to_json(&rows))?;
    } else {
        console.print(&to_text(&rows))?;
    }
    // Every limit is looked at, so that all broken ones are named.
    let broken = ratios.iter().filter(|(limit, ratio)| limit.is_broken_by(*ratio, console)).count()
        + intervals.iter().filter(|(limit, (name, interval))| limit.is_broken_by(name, *interval, console)).count();
    Ok(broken == 0)
}

/// Returns what two profiles don't have in common, among what the times depend on; what one doesn't tell is no
/// difference.
fn differences([a, b]: &[Profile; 2]) -> Vec<String> {
    let number = |value: Option<u64>| value.map(|value| value.to_string());
    let steady = |profile: &Profile| profile.steady.map(|steady| steady.to_string());
    let facts = [
        ("points", number(a.scene.points), number(b.scene.points)),
        ("pixels", number(a.scene.pixels), number(b.scene.pixels)),
        ("samples", number(a.scene.samples), number(b.scene.samples)),
        ("method", a.method.clone(), b.method.clone()),
        ("device", a.device.name.clone(), b.device.name.clone()),
        ("steady", steady(a), steady(b)),
    ];
    let differing = facts.into_iter().filter_map(|(name, a, b)| Some((name, a?, b?))).filter(|(_, a, b)| a != b);
    differing.map(|(name, a, b)| format!("{name} {a} and {b}")).collect()
}

fn find<'a>(rows: &'a [PassComparison], name: &str) -> Option<&'a PassComparison> {
    rows.iter().find(|row| row.name == name)
}

/// The names and intervals that a limit applies to.
///
/// # Errors
/// The named pass is missing. The noise can't be estimated, either of the named pass or, without a name, of the frame.
fn judged<'a>(rows: &'a [PassComparison], limit: &Slower) -> Result<Vec<(&'a str, [f64; 2])>> {
    let name = limit.pass.as_deref().unwrap_or(FRAME);
    let row = find(rows, name).ok_or_else(|| limit.unusable("no pass has this name"))?;
    let interval = row.interval().ok_or_else(|| limit.unusable(&too_few(row)))?;
    if limit.pass.is_some() {
        return Ok(vec![(&row.name, interval)]);
    }
    let counting = rows.iter().filter(|row| row.counts());
    Ok(counting.filter_map(|row| Some((row.name.as_str(), row.interval()?))).collect())
}

fn too_few(row: &PassComparison) -> String {
    format!(
        "no noise estimate: each profile needs {MIN_TIMES} frames (--frames), but `{}` was measured in {} of A and {} of B",
        row.name,
        row.a.count(),
        row.b.count()
    )
}

fn read(path: &Path) -> Result<Profile, output::Error> {
    let text = std::fs::read_to_string(path).map_err(|source| output::Error::Read { path: path.to_owned(), source })?;
    serde_json::from_str(&text).map_err(|error| output::Error::Decode {
        path: path.to_owned(),
        reason: format!("not a profile as --profile writes it: {error}"),
    })
}

/// The frame first, then the passes in the order of A, then those that only B has.
fn rows(a: &Profile, b: &Profile) -> Vec<PassComparison> {
    let mut seen = HashSet::new();
    let passes = a.frames.iter().chain(&b.frames).flat_map(|frame| &frame.passes);
    let names: Vec<&str> = passes.map(|pass| pass.name.as_str()).filter(|name| seen.insert(*name)).collect();
    let whole = |profile: &Profile| Times::new(profile.frames.iter().filter_map(|frame| frame.gpu_ms).collect());
    let (whole_a, whole_b) = (whole(a), whole(b));
    let share = |pass: &Times, frame: &Times| Some(pass.median()? / frame.median()?);
    let (mut times_a, mut times_b) = (pass_times(a), pass_times(b));
    let passes: Vec<PassComparison> = names
        .into_iter()
        .map(|name| {
            let [a, b] = [&mut times_a, &mut times_b].map(|times| Times::new(times.remove(name).unwrap_or_default()));
            let share = [share(&a, &whole_a), share(&b, &whole_b)].into_iter().flatten().reduce(f64::max);
            PassComparison { name: name.to_owned(), a, b, share }
        })
        .collect();
    let frame = PassComparison { name: FRAME.to_owned(), a: whole_a, b: whole_b, share: Some(1.0) };
    std::iter::once(frame).chain(passes).collect()
}

/// Returns a time per frame for each pass name; a pass that runs several times in a frame (bands) counts as a sum.
fn pass_times(profile: &Profile) -> HashMap<&str, Vec<f64>> {
    let mut times: HashMap<&str, Vec<f64>> = HashMap::new();
    for frame in &profile.frames {
        let mut sums: HashMap<&str, f64> = HashMap::new();
        for pass in &frame.passes {
            if let Some(time) = pass.gpu_ms {
                *sums.entry(&pass.name).or_default() += time;
            }
        }
        sums.into_iter().for_each(|(name, sum)| times.entry(name).or_default().push(sum));
    }
    times
}

fn to_json(rows: &[PassComparison]) -> serde_json::Value {
    let row = |row: &PassComparison| {
        json!({
            "name": row.name,
            "a_ms": row.a.median(),
            "b_ms": row.b.median(),
            "ratio": row.ratio(),
            "interval": row.interval(),
            "share": row.share,
            "verdict": row.verdict().map(Verdict::name),
        })
    };
    let (frame, passes) = rows.split_at(1.min(rows.len()));
    json!({ "frame": frame.first().map(row), "passes": passes.iter().map(row).collect::<Vec<_>>() })
}

fn to_text(rows: &[PassComparison]) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
    let line = |row: &PassComparison| {
        [
            row.name.clone(),
            number(row.a.median()),
            number(row.b.median()),
            row.share.map_or("-".to_owned(), |share| format!("{:.1}%", 100.0 * share)),
            number(row.ratio()),
            row.interval().map_or("-".to_owned(), |[low, high]| format!("{low:.3}–{high:.3}")),
            verdict_text(row),
        ]
    };
    let header = ["pass", "A ms", "B ms", "share", "B/A", "interval", "verdict"];
    let table = table(header, rows.iter().map(line), 1..6);
    let notes: String = notes(rows).iter().map(|note| format!("{note}\n")).collect();
    format!("{}\n{notes}", table.trim_fmt())
}

fn verdict_text(row: &PassComparison) -> String {
    match row.verdict() {
        None if row.a.count() == 0 && row.b.count() > 0 => "only in B".to_owned(),
        None if row.b.count() == 0 && row.a.count() > 0 => "only in A".to_owned(),
        None => "-".to_owned(),
        Some(verdict) if row.counts() => verdict.name().to_owned(),
        Some(verdict) => format!("({})", verdict.name()),
    }
}

/// Notes on the table.
fn notes(rows: &[PassComparison]) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(row) = find(rows, FRAME).filter(|row| row.interval().is_none()) {
        notes.push(too_few(row));
    }
    if rows.iter().any(|row| row.verdict().is_some() && !row.counts()) {
        notes.push("in parentheses: less than 1% of the frame; --fail-slower checks it only by name".to_owned());
    }
    notes
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
        let row = |name: &str, a: &[f64], b: &[f64], share| {
            let [a, b] = [a, b].map(|times| Times::new(times.to_vec()));
            PassComparison { name: name.into(), a, b, share }
        };
        let count = row("x/count", &[3.0, 5.0, 10.0], &[], Some(5.0 / 6.0));
        assert_eq!(rows, [row(FRAME, &[4.0, 6.0, 11.0], &[3.0, 6.0], Some(1.0)), count, row("y", &[], &[], None)]);
        // The median of two frames of 3 and 6 is 4.5.
        assert_eq!(rows[0].ratio(), Some(0.75));
        assert_eq!(rows[1].ratio(), None);
    }

    #[test]
    fn many_passes_take_time_that_grows_with_their_number() {
        // Each looked for among all others, these would be 10¹⁰ comparisons.
        let passes: Vec<String> = (0..100_000).map(|i| format!("{{\"name\": \"{i}\", \"gpu_ms\": {i}}}")).collect();
        let a = profile(&format!("{{\"gpu_ms\": 1, \"passes\": [{}]}}", passes.join(",")));
        let rows = rows(&a, &a);
        assert_eq!(rows.len(), 100_001);
        assert_eq!((rows[7].name.as_str(), rows[7].a.median()), ("6", Some(6.0)));
    }
}
