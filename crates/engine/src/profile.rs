//! The cost of frames: the profile as JSON and as a Chrome trace.

mod host;
mod trace;

use std::time::Duration;

use serde_json::{Value, json};

use crate::gpu::{self, Device, Memory};
use crate::methods::{Facts, Frame, FrameProfile, PassProfile, Rendered};
use crate::progress::Span;

/// Frames of one scene on one device.
#[derive(Debug, Clone)]
pub struct Profile {
    /// The device's name.
    pub device: String,
    /// Driver of the device.
    pub driver: String,
    /// Nanoseconds of one tick of a timestamp.
    pub timestamp_period_ns: f64,
    /// Width × height.
    pub pixels: u64,
    /// The counts of the last frame.
    pub facts: Facts,
    /// List length and number of pixels with it, ascending; empty for methods without lists.
    pub list_histogram: Vec<(u32, u64)>,
    /// The phases of the command, each where it happened. Those of [`Phase::Compile`](crate::progress::Phase::Compile)
    /// lie within others.
    pub host: Vec<Span>,
    /// The frames.
    pub frames: Vec<FrameProfile>,
}

impl Profile {
    /// Returns a profile without frames.
    pub fn new(device: &Device, frame: &Frame) -> Self {
        let info = device.info();
        Self {
            device: info.name.clone(),
            driver: info.driver.clone(),
            timestamp_period_ns: info.timestamp_period_ns,
            pixels: u64::from(frame.size[0]) * u64::from(frame.size[1]),
            facts: Facts::default(),
            list_histogram: Vec::new(),
            host: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// Adds a frame.
    pub fn add(&mut self, rendered: &Rendered) {
        if let Some(fragments) = &rendered.image.fragments {
            self.list_histogram = histogram(fragments);
        }
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
                json!({"gpu_ms": ms(f.gpu()), "wall_ms": ms(f.wall), "waits": f.waits, "passes": passes})
            })
            .collect();
        json!({
            "version": 1,
            "device": {"name": self.device, "driver": self.driver, "timestamp_period_ns": self.timestamp_period_ns},
            "scene": {
                "points": self.facts.points,
                "pixels": self.pixels,
                "fragments": self.facts.fragments,
                "max_list": self.facts.max_list,
                "list_histogram": self.list_histogram,
            },
            "memory": {
                "peak_device_bytes": self.facts.peak_device_bytes,
                "fragment_bytes": self.facts.fragment_bytes,
                "bands": self.facts.bands,
            },
            "host": self.host_json(),
            "frames": frames,
        })
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

/// Returns lengths of lists and how many pixels have each, ascending.
pub fn histogram(lengths: &[u32]) -> Vec<(u32, u64)> {
    let mut sorted = lengths.to_vec();
    sorted.sort_unstable();
    sorted.chunk_by(|a, b| a == b).map(|run| (run[0], run.len() as u64)).collect()
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
