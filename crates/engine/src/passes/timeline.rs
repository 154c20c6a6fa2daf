//! The submissions of a frame, and when its passes ran.

use std::time::{Duration, Instant};

use super::Error;
use super::foresight::{Answer, AnswerPlace, Foresight, Knowledge};
use crate::gpu::{Device, Given, PassTime, Paused, Recorder, Slice, Stamps, Submitted};
use crate::progress::Progress;

/// Submits the work of a frame, and collects its times.
pub struct Timeline {
    progress: Progress,
    /// Time when the first submission began.
    pub start: Option<Instant>,
    /// Each pass with its start, counted from the first submission's. Without a device that tells its clock, the passes
    /// of a submission follow one another from its beginning on.
    pub passes: Vec<(PassTime, Duration)>,
    /// The submissions' times together.
    pub submitted: Duration,
    /// Device time of the submissions together, each from its beginning to its end; `None` unless `stamps` are there.
    pub whole: Option<Duration>,
    /// Places at which the device notes the time.
    pub stamps: Stamps,
    /// Facts about the window in work that are known before it is rendered.
    pub foresight: Foresight,
    /// The value of an override that every pass is given whose shader has it.
    pub given: Option<Given>,
    /// Commands that were recorded so far, where nobody waits for them.
    paused: Option<Paused>,
}

impl Timeline {
    /// Begins without a submission; who watches the progress may cancel the frame at any of them.
    pub fn new(progress: &Progress) -> Self {
        Self::with(progress, Foresight::default())
    }

    /// Returns the same, with what is known of earlier frames. What comes before the first window waits.
    pub fn with(progress: &Progress, mut foresight: Foresight) -> Self {
        // An earlier frame may have ended in the middle of a window.
        foresight.begin(true);
        let (passes, submitted) = (Vec::new(), Duration::ZERO);
        let stamps = Stamps::Passes;
        Self {
            progress: progress.clone(),
            start: None,
            passes,
            submitted,
            whole: None,
            stamps,
            foresight,
            given: None,
            paused: None,
        }
    }

    /// Begins a recording, or goes on with one that nobody waited for.
    pub fn recorder<'a>(&mut self, device: &'a Device) -> Result<Recorder<'a>, Error> {
        let mut recorder = match self.paused.take() {
            Some(paused) => paused.resume(),
            None => device.recorder_with(self.stamps)?,
        };
        recorder.give(self.given);
        Ok(recorder)
    }

    /// Asks what the device counts into `words`, by copies called `name`: waits for what was recorded, unless an upper
    /// bound of the answer is known. `submitted` says in errors what is submitted.
    ///
    /// # Errors
    /// Returns an error if [`Self::submit`] fails.
    pub fn ask<'a>(
        &mut self,
        device: &Device,
        recorder: Recorder<'a>,
        (name, submitted): (&'static str, &str),
        words: &[Slice<'a, u32>],
    ) -> Result<Answer, Error> {
        self.progress.check()?;
        let finished = {
            let mut recorder: Recorder<'_> = recorder;
            if let Some(answer) = self.foresight.ask(device, &mut recorder, name, words)? {
                self.paused = Some(recorder.pause());
                return Ok(answer);
            }
            recorder.submit(submitted)?
        };
        self.add(finished);
        Ok(self.foresight.answer())
    }

    /// Returns what was found, once it was submitted.
    pub fn found(&self, place: AnswerPlace) -> &[u32] {
        self.foresight.found(place)
    }

    /// Submits what was recorded, and waits for it, unless the window does without waiting: then the next recording
    /// goes on from here.
    ///
    /// # Errors
    /// Returns an error if [`Self::submit`] fails.
    pub fn go_on(&mut self, recorder: Recorder<'_>, name: &str) -> Result<(), Error> {
        if self.foresight.knowledge() != Knowledge::Bounds {
            return self.submit(recorder, name);
        }
        self.progress.check()?;
        self.paused = Some(recorder.pause());
        Ok(())
    }

    /// Drops what was recorded and not submitted.
    pub fn drop_paused(&mut self) {
        self.paused = None;
    }

    /// Submits what was recorded, and waits for it. `name` says in errors what was submitted.
    ///
    /// # Errors
    /// The frame was cancelled, and nothing submitted; the device failed; or a count was larger than foreseen.
    pub fn submit(&mut self, recorder: Recorder<'_>, name: &str) -> Result<(), Error> {
        self.progress.check()?;
        let finished = {
            let mut recorder: Recorder<'_> = recorder;
            self.foresight.record_end(&mut recorder);
            recorder.submit(name)?
        };
        self.add(finished);
        if self.foresight.is_met() { Ok(()) } else { Err(Error::Unforeseen) }
    }

    /// Adds a finished submission.
    fn add(&mut self, submission: Submitted) {
        let first = *self.start.get_or_insert(submission.begin);
        let mut end = submission.begin - first;
        for pass in submission.passes {
            // Clocks are compared to about a microsecond, and a pass begins neither before its submission nor before
            // the end of the one before it.
            let start = pass.begin.map_or(end, |begin| begin.saturating_duration_since(first).max(end));
            end = start + pass.gpu;
            self.passes.push((pass, start));
        }
        self.submitted += submission.wall;
        if let Some(whole) = submission.whole {
            self.whole = Some(self.whole.unwrap_or_default() + whole);
        }
    }
}
