//! Cost of a frame.

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
    /// Time that the pass took on the device.
    pub time: Duration,
    /// Number of shader invocations; `None` where they are not counted.
    pub invocations: Option<u64>,
    /// Smallest number of bytes that the pass must read and write; `None` where it is unknown.
    pub bytes: Option<u64>,
}

impl Profile {
    /// Returns the passes in the order of their first run; none unless they were timed
    /// ([`FrameBuilder::timed`](crate::FrameBuilder::timed)).
    pub fn passes(&self) -> Vec<Pass> {
        let passes = self.0.frames.iter().flat_map(|frame| &frame.passes);
        passes.map(|p| Pass { name: p.name, time: p.gpu, invocations: p.invocations, bytes: p.bytes }).collect()
    }

    /// Returns the time that the frame took on the device.
    pub fn device_time(&self) -> Duration {
        self.0.frames.iter().map(|frame| frame.device()).sum()
    }

    /// Returns the time from the first submission to the picture in host memory.
    pub fn wall_time(&self) -> Duration {
        self.0.frames.iter().map(|frame| frame.wall).sum()
    }

    /// Returns the largest number of device bytes in use at any time, points and picture included.
    pub fn peak_device_bytes(&self) -> u64 {
        self.0.facts.peak_device_bytes
    }

    /// Returns the number of fragments of all pixels; 0 for methods that don't count them.
    pub fn fragments(&self) -> u64 {
        self.0.facts.fragments
    }

    /// Returns the number of fragments of the pixel with the most; 0 for methods that don't count them.
    pub fn longest_list(&self) -> u32 {
        self.0.facts.max_list
    }

    /// Returns the profile as JSON, in the form that `pellucid render --profile` writes.
    pub fn to_json(&self) -> String {
        self.0.to_json().to_string()
    }
}
