//! The submissions of a frame, and when its passes ran.

use std::time::{Duration, Instant};

use super::Error;
use crate::gpu::{PassTime, Recorder, Submitted};
use crate::progress::Progress;

/// Submits the work of a frame, and collects its times.
pub struct Timeline {
    progress: Progress,
    /// When the first submission began.
    pub start: Option<Instant>,
    /// Each pass with its start, counted from the first submission's. The passes of a submission follow one another from its
    /// beginning on.
    pub passes: Vec<(PassTime, Duration)>,
    /// The submissions' times together.
    pub submitted: Duration,
}

impl Timeline {
    /// Begins without a submission; who watches the progress may cancel the frame at any of them.
    pub fn new(progress: &Progress) -> Self {
        Self { progress: progress.clone(), start: None, passes: Vec::new(), submitted: Duration::ZERO }
    }

    /// Submits what was recorded, and waits for it. `name` says in errors what was submitted.
    ///
    /// # Errors
    /// The frame was cancelled, and nothing submitted; or the device failed.
    pub fn submit(&mut self, recorder: Recorder<'_>, name: &str) -> Result<(), Error> {
        self.progress.check()?;
        self.add(recorder.submit(name)?);
        Ok(())
    }

    /// Adds a finished submission.
    fn add(&mut self, submission: Submitted) {
        let mut start = submission.begin - *self.start.get_or_insert(submission.begin);
        for pass in submission.passes {
            let gpu = pass.gpu;
            self.passes.push((pass, start));
            start += gpu;
        }
        self.submitted += submission.wall;
    }
}
