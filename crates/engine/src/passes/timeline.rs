//! When the passes of a frame ran.

use std::time::{Duration, Instant};

use crate::gpu::{PassTime, Submitted};

/// Collects the submissions of a frame.
#[derive(Debug, Default)]
pub struct Timeline {
    /// When the first submission began.
    pub start: Option<Instant>,
    /// Each pass with its start, counted from the first submission's without the host's work between submissions.
    pub passes: Vec<(PassTime, Duration)>,
    /// The submissions' times together.
    pub submitted: Duration,
}

impl Timeline {
    /// Adds a finished submission.
    pub fn add(&mut self, submission: Submitted) {
        self.start.get_or_insert_with(|| Instant::now() - submission.wall);
        let mut start = self.submitted;
        for pass in submission.passes {
            let gpu = pass.gpu;
            self.passes.push((pass, start));
            start += gpu;
        }
        self.submitted += submission.wall;
    }
}
