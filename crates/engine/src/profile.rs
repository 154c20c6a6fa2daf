//! The cost of frames: the profile as JSON and as a Chrome trace.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use pellucid_scene::stored::Reads;
use serde_json::{Value, json};

use crate::gpu::{self, Compilation, Device, Memory, MemoryBudget};
use crate::methods::{Facts, Frame, FrameProfile, PassProfile, Rendered};
use crate::pipelines::Pipelines;
use crate::progress::{Phase, Span};
use crate::spread::Spread;
use crate::totals::Totals;

/// Frames of one scene on one device.
#[derive(Debug, Clone)]
pub struct Profile {
    /// The device's name.
    pub device: String,
    /// Driver of the device.
    pub driver: String,
    /// Nanoseconds of one tick of a timestamp.
    pub timestamp_period_ns: f64,
    /// Name of the method.
    pub method: &'static str,
    /// Width × height.
    pub pixels: u64,
    /// Samples of each pixel's area: passes and counts are those of so many images.
    pub samples: u32,
    /// `true` if the counts of the frames were foreseen, `false` if each frame waited for its own; `None` for a picture
    /// that is rendered once.
    pub steady: Option<bool>,
    /// Nodes and bytes of stores that were read so far; 0 for clouds in memory.
    pub read: Reads,
    /// Most bytes of host memory that the process had so far; `None` where the system doesn't say.
    pub peak_host_bytes: Option<u64>,
    /// Memory of the device that was free before the frames; `None` where the driver doesn't tell.
    pub memory: Option<MemoryBudget>,
    /// The counts of the last frame.
    pub facts: Facts,
    /// List length and number of pixels with it, ascending; empty for methods without lists.
    pub list_histogram: Vec<(u32, u64)>,
    /// Names of the clouds in [`Facts::adjusted`].
    pub clouds: Vec<String>,
    /// The phases of the command, each where it happened. Those of [`Phase::Compile`]
    /// lie within others.
    pub host: Vec<Span>,
    /// The frames.
    pub frames: Vec<FrameProfile>,
    /// Numbers of splats in a tile and the tiles with each, ascending; `None` if nobody asked, empty without tiles.
    pub tile_histogram: Option<Vec<(u32, u64)>>,
    /// Facts of the driver's compiler about the pipelines.
    pub pipelines: Pipelines,
    /// Times of more frames at a steady clock, without any other work between them; `None` unless they were measured.
    pub totals: Option<Totals>,
}

impl Profile {
    /// Returns a profile without frames.
    pub fn new(device: &Device, frame: &Frame) -> Self {
        let info = device.info();
        Self {
            device: info.name.clone(),
            driver: info.driver.clone(),
            timestamp_period_ns: info.timestamp_period_ns,
            method: frame.method.name(),
            steady: None,
            read: Reads::default(),
            peak_host_bytes: None,
            memory: device.memory_budget(),
            pixels: u64::from(frame.size[0]) * u64::from(frame.size[1]),
            samples: frame.samples,
            facts: Facts::default(),
            list_histogram: Vec::new(),
            clouds: Vec::new(),
            host: Vec::new(),
            frames: Vec::new(),
            tile_histogram: None,
            pipelines: Pipelines::default(),
            totals: None,
        }
    }

    /// Adds a frame.
    pub fn add(&mut self, rendered: &Rendered) {
        if let Some(fragments) = &rendered.image.fragments {
            self.list_histogram = histogram(fragments);
        }
        self.samples = rendered.image.samples.max(1);
        self.facts = rendered.facts.clone();
        self.frames.push(rendered.profile.clone());
    }

    /// Returns the profile in the form that the interface documents, version 1.
    pub fn to_json(&self) -> Value {
        let ms = |d: Duration| d.as_secs_f64() * 1e3;
        let pass = |p: &PassProfile| json!({"name": p.name, "gpu_ms": ms(p.gpu), "invocations": p.invocations, "bytes": p.bytes});
        let frames: Vec<Value> = self
            .frames
            .iter()
            .map(|f| {
                let passes: Vec<Value> = f.passes.iter().map(pass).collect();
                json!({
                    "gpu_ms": ms(f.gpu()),
                    "total_ms": f.total.map(ms),
                    "wall_ms": ms(f.wall),
                    "waits": f.waits,
                    "passes": passes,
                })
            })
            .collect();
        let mut whole = json!({
            "version": 1,
            "device": {"name": self.device, "driver": self.driver, "timestamp_period_ns": self.timestamp_period_ns},
            "method": self.method,
            "steady": self.steady,
            "scene": {
                "points": self.facts.shown,
                "pixels": self.pixels,
                "samples": self.samples,
                "fragments": self.facts.fragments,
                "max_list": self.facts.max_list,
                "list_histogram": self.list_histogram,
                "nodes_read": self.read.nodes,
                "bytes_read": self.read.bytes,
            },
            "memory": {
                "peak_device_bytes": self.facts.peak_device_bytes,
                "device_budget_bytes": self.memory.map(|memory| memory.budget),
                "device_used_bytes": self.memory.map(|memory| memory.used),
                "peak_host_bytes": self.peak_host_bytes,
                "fragment_bytes": self.facts.fragment_bytes,
                "bands": self.facts.bands,
            },
            "host": self.host_json(),
            "frames": frames,
        });
        if let Some(totals) = &self.totals {
            whole["totals"] = totals.to_json();
        }
        if let Some(adjusted) = &self.facts.adjusted {
            whole["ensembles"] = adjusted.to_json(&self.clouds);
        }
        if let Some([tiles, lists]) = self.spreads() {
            let json = |spread: Option<Spread>| spread.map_or(Value::Null, Spread::to_json);
            whole["work"] = json!({"tile_splats": json(tiles), "pixel_fragments": json(lists)});
        }
        if let Some(pipelines) = self.pipelines.to_json() {
            whole["pipelines"] = pipelines;
        }
        whole
    }

    /// Returns how splats are spread over tiles and fragments over pixels, each `None` where there are none of either;
    /// `None` if nobody asked.
    fn spreads(&self) -> Option<[Option<Spread>; 2]> {
        let tiles = self.tile_histogram.as_ref()?;
        Some([Spread::of(tiles), Spread::of(&self.list_histogram)])
    }

    /// Returns a line for people: least, median and most work of a tile and of a pixel; `None` where there is none, and
    /// if nobody asked.
    pub fn work_line(&self) -> Option<String> {
        let [tiles, lists] = self.spreads()?;
        let of = [tiles.map(|s| s.text("splats", "tile")), lists.map(|s| s.text("fragments", "pixel"))];
        let parts: Vec<String> = of.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("work, least / median / most: {}", parts.join("; ")))
    }

    /// Returns a line for people on each cloud whose points are dealt to ensembles, and one on the time that it took;
    /// none for other methods.
    pub fn adjustment_lines(&self) -> Vec<String> {
        let Some(adjusted) = &self.facts.adjusted else { return Vec::new() };
        let order = self.host_times()[Phase::Order as usize];
        adjusted.lines(&self.clouds).into_iter().chain([adjustment_time(order)]).collect()
    }

    /// Returns device times of each pass over all frames, in the order of their first run.
    pub fn passes(&self) -> Vec<PassTimes> {
        let mut names: Vec<&'static str> = Vec::new();
        for pass in self.frames.iter().flat_map(|f| &f.passes) {
            if !names.contains(&pass.name) {
                names.push(pass.name);
            }
        }
        names.into_iter().map(|name| self.row(name)).collect()
    }

    fn row(&self, name: &'static str) -> PassTimes {
        let runs: Vec<&PassProfile> = self.frames.iter().flat_map(|f| &f.passes).filter(|p| p.name == name).collect();
        let mut times: Vec<f64> = runs.iter().map(|p| p.gpu.as_secs_f64() * 1e3).collect();
        times.sort_by(f64::total_cmp);
        PassTimes {
            name,
            min: times.first().copied().unwrap_or(0.0),
            max: times.last().copied().unwrap_or(0.0),
            median: median(times),
            invocations: runs.last().and_then(|p| p.invocations),
            bytes: runs.last().and_then(|p| p.bytes),
        }
    }
}

/// Device times of a pass over some frames.
#[derive(Debug, Clone, PartialEq)]
pub struct PassTimes {
    /// The pass.
    pub name: &'static str,
    /// Least time of a frame in milliseconds.
    pub min: f64,
    /// Median time of a frame in milliseconds.
    pub median: f64,
    /// Greatest time of a frame in milliseconds.
    pub max: f64,
    /// Shader invocations of the last frame; `None` where nothing counts them.
    pub invocations: Option<u64>,
    /// Bytes that the pass of the last frame must read and write at least; `None` where that is not known.
    pub bytes: Option<u64>,
}

/// Returns the median of some numbers, 0 if empty.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => 0.0,
        _ if n % 2 == 1 => values[n / 2],
        _ => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// Says how long points were dealt to ensembles, by the time of the phase [`Phase::Order`].
pub fn adjustment_time(order: Duration) -> String {
    format!("adjustment of the numbers of points: {:.1} ms", order.as_secs_f64() * 1e3)
}

/// Returns lengths of lists and how many pixels have each, ascending.
pub fn histogram(lengths: &[u32]) -> Vec<(u32, u64)> {
    // Few of them differ, while a sorted copy of those of a large picture may not fit into memory.
    let mut counts = BTreeMap::new();
    for run in lengths.chunk_by(|a, b| a == b) {
        *counts.entry(run[0]).or_insert(0) += run.len() as u64;
    }
    counts.into_iter().collect()
}

/// Returns bytes per second, reads and writes together, of the device's own copy between two buffers: the yardstick for
/// passes.
pub fn copy_rate(device: &Device) -> Result<f64, gpu::Error> {
    const BYTES: u64 = 64 << 20;
    const COPIES: usize = 5;
    let from = device.buffer::<u32>("copy source", BYTES / 4, Memory::Device)?;
    let to = device.buffer::<u32>("copy target", BYTES / 4, Memory::Device)?;
    let mut recorder = device.recorder()?;
    // The first touches the memory.
    recorder.fill("profile/fill", from.all(), 0)?;
    for _ in 0..=COPIES {
        recorder.copy("profile/copy", from.all(), to.all())?;
    }
    let submitted = recorder.submit("profile/copy")?;
    let times = submitted.passes.iter().skip(2).map(|p| p.gpu.as_secs_f64()).collect();
    Ok(2.0 * BYTES as f64 / median(times).max(f64::MIN_POSITIVE))
}

impl Profile {
    /// Adds the phases of a command, and the pipelines that its device made meanwhile.
    pub fn add_host(&mut self, phases: Vec<Span>, compilations: &[Compilation]) {
        self.host.extend(phases);
        let span = |made: &Compilation| Span { phase: Phase::Compile, begin: made.begin, length: made.time };
        self.host.extend(compilations.iter().map(span));
    }

    /// Returns the time of each phase, by [`Phase::ALL`]. Making pipelines does not count for the phase that it lies
    /// within.
    pub fn host_times(&self) -> [Duration; Phase::ALL.len()] {
        let mut times = [Duration::ZERO; Phase::ALL.len()];
        for span in &self.host {
            times[span.phase as usize] += span.length;
        }
        for compile in self.host.iter().filter(|span| span.phase == Phase::Compile) {
            if let Some(around) = self.host.iter().find(|span| encloses(span, compile)) {
                let time = &mut times[around.phase as usize];
                *time = time.saturating_sub(compile.length);
            }
        }
        times
    }

    /// Returns a line for people: the phases that took time, in milliseconds.
    pub fn host_text(&self) -> String {
        let phase = |(phase, time): (Phase, Duration)| format!("{} {:.1} ms", phase.name(), time.as_secs_f64() * 1e3);
        let phases: Vec<String> = self.shown_phases().map(phase).collect();
        format!("host: {}", phases.join(", "))
    }

    /// Returns the phases that took time, and those that every command has, with their milliseconds.
    fn host_json(&self) -> Vec<Value> {
        let phase = |(phase, time): (Phase, Duration)| json!({"name": phase.name(), "ms": time.as_secs_f64() * 1e3});
        self.shown_phases().map(phase).collect()
    }

    fn shown_phases(&self) -> impl Iterator<Item = (Phase, Duration)> {
        let is_shown =
            |(phase, time): &(Phase, Duration)| !time.is_zero() || matches!(phase, Phase::Read | Phase::Frame);
        Phase::ALL.into_iter().zip(self.host_times()).filter(is_shown)
    }
}

/// Returns `true` if a phase runs while pipelines are made.
fn encloses(span: &Span, compile: &Span) -> bool {
    span.phase != Phase::Compile && (span.begin..span.begin + span.length).contains(&compile.begin)
}

/// Rows of the trace: their thread numbers.
const HOST: u32 = 0;
const DEVICE: u32 = 1;

impl Profile {
    /// Phases of the host, frames and dispatches in the Chrome trace event format, in microseconds since the first of
    /// them. The row of the host has the phases, the frames within them, and the pipelines that were made; the row of
    /// the device has the dispatches. Events are in the order of their starts.
    pub fn to_trace(&self) -> Value {
        let begins = self.host.iter().map(|span| span.begin).chain(self.frames.iter().map(|frame| frame.begin));
        let mut events = Vec::new();
        if let Some(origin) = begins.min() {
            events.extend(self.host.iter().map(|span| phase(span, origin)));
            for (number, frame) in self.frames.iter().enumerate() {
                add_frame(&mut events, number, frame, frame.begin - origin);
            }
        }
        sort_events(&mut events);
        for (thread, name) in [(HOST, "host"), (DEVICE, "device")] {
            events.push(json!({"name": "thread_name", "ph": "M", "pid": 0, "tid": thread, "args": {"name": name}}));
        }
        json!({"traceEvents": events, "displayTimeUnit": "ms", "otherData": {"device row": self.placing()}})
    }
}

impl Profile {
    /// Says how the passes of the trace are placed.
    fn placing(&self) -> &'static str {
        match self.frames.iter().all(FrameProfile::is_calibrated) {
            true => "passes at their times by the device's clock, which was compared with the host's",
            false => "passes of a submission one after another from its begin: this device doesn't tell its clock",
        }
    }
}

/// Sorts events of a trace by their starts, and those that start together so that one that encloses another comes
/// first.
pub fn sort_events(events: &mut [Value]) {
    let micros = |event: &Value, key: &str| event[key].as_f64().unwrap_or(0.0);
    events.sort_by(|a, b| {
        micros(a, "ts").total_cmp(&micros(b, "ts")).then_with(|| micros(b, "dur").total_cmp(&micros(a, "dur")))
    });
}

fn phase(span: &Span, origin: Instant) -> Value {
    event(span.phase.name(), [span.begin - origin, span.length], HOST, &json!({}))
}

/// Adds a frame that began at a time, and its dispatches.
fn add_frame(events: &mut Vec<Value>, number: usize, frame: &FrameProfile, begin: Duration) {
    events.push(event(&format!("frame {number}"), [begin, frame.wall], HOST, &json!({})));
    for (pass, start) in &frame.timeline {
        let counts = json!({"invocations": pass.invocations});
        events.push(event(pass.name, [begin + *start, pass.gpu], DEVICE, &counts));
    }
}

/// An event with its start and its length.
fn event(name: &str, [start, length]: [Duration; 2], thread: u32, args: &Value) -> Value {
    let micros = |time: Duration| time.as_secs_f64() * 1e6;
    json!({"name": name, "ph": "X", "ts": micros(start), "dur": micros(length), "pid": 0, "tid": thread, "args": args})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_by_hand() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }

    #[test]
    fn histograms_by_hand() {
        assert_eq!(histogram(&[]), []);
        assert_eq!(histogram(&[2, 0, 2, 7, 0, 2]), [(0, 2), (2, 3), (7, 1)]);
    }
}
