//! The times of a frame.

use std::time::{Duration, Instant};

use crate::gpu::PassTime;

/// A pass of a frame, with all its dispatches together.
#[derive(Debug, Clone, PartialEq)]
pub struct PassProfile {
    /// Name as in `plan`.
    pub name: &'static str,
    /// Device time.
    pub gpu: Duration,
    /// Shader invocations; `None` where nothing counts them.
    pub invocations: Option<u64>,
    /// Bytes that the pass must read and write at least; `None` where that is not known.
    pub bytes: Option<u64>,
}

/// Times of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameProfile {
    /// The passes in order of their first run.
    pub passes: Vec<PassProfile>,
    /// Time when the first submission began.
    pub begin: Instant,
    /// Each dispatch in order with its start relative to the frame's, for the trace.
    pub timeline: Vec<(PassTime, Duration)>,
    /// Time from the first submission to the end of the last one's wait, without the host's work between them.
    pub submitted: Duration,
    /// Device time of the submissions, each from its beginning to its end; `None` where the passes were timed
    /// ([`Renderer::timed`](super::Renderer::timed)), which keeps them apart.
    pub total: Option<Duration>,
    /// Time from the first submission to the end of the last read-back.
    pub wall: Duration,
    /// Number of submissions that the host waited for.
    pub waits: u64,
}

impl FrameProfile {
    /// Returns `true` if the starts of all passes are those that the device tells by its own clock.
    pub fn is_calibrated(&self) -> bool {
        self.timeline.iter().all(|(pass, _)| pass.begin.is_some())
    }

    /// Returns the device time of the frame: as a whole if that was found, else that of all passes.
    pub fn device(&self) -> Duration {
        self.total.unwrap_or_else(|| self.gpu())
    }

    /// Returns device time of all passes.
    pub fn gpu(&self) -> Duration {
        self.passes.iter().map(|p| p.gpu).sum()
    }
}
