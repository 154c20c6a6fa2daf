//! The cost of a frame.

use std::time::Duration;

use pellucid_engine::profile::Profile as Frames;

/// Device times and memory of a frame.
pub struct Profile(pub(crate) Frames);

/// A pass of a frame, with all its dispatches together.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Pass {
    /// Method and stage, as in `abuffer/store`.
    pub name: &'static str,
    /// Time on the device.
    pub time: Duration,
    /// Shader invocations, where they are counted.
    pub invocations: Option<u64>,
    /// Bytes that the pass must read and write at least, where that is known.
    pub bytes: Option<u64>,
}

impl Profile {
    /// The passes in the order of their first run.
    pub fn passes(&self) -> Vec<Pass> {
        let passes = self.0.frames.iter().flat_map(|frame| &frame.passes);
        passes.map(|p| Pass { name: p.name, time: p.gpu, invocations: p.invocations, bytes: p.bytes }).collect()
    }

    /// Time on the device of all passes.
    pub fn device_time(&self) -> Duration {
        self.0.frames.iter().map(|frame| frame.gpu()).sum()
    }

    /// Time from the first submission to the picture in host memory.
    pub fn wall_time(&self) -> Duration {
        self.0.frames.iter().map(|frame| frame.wall).sum()
    }

    /// Largest number of device bytes at any time, points and picture included.
    pub fn peak_device_bytes(&self) -> u64 {
        self.0.facts.peak_device_bytes
    }

    /// Fragments of all pixels, of methods that count them.
    pub fn fragments(&self) -> u64 {
        self.0.facts.fragments
    }

    /// Fragments of the pixel with most of them.
    pub fn longest_list(&self) -> u32 {
        self.0.facts.max_list
    }

    /// The profile as JSON, in the form that `pellucid render --profile` writes.
    pub fn to_json(&self) -> String {
        self.0.to_json().to_string()
    }
}
