//! Frames as samples.

use std::cell::{Cell, RefCell};

use super::Renderer;
use super::walk::Job;
use crate::methods::deep::{DeepEngine, DeepSource, Sink};
use crate::methods::prelude::*;
use crate::output::deep::State;

impl Renderer {
    /// Returns the largest number of samples that the deep image of a frame has, from projecting and counting alone.
    ///
    /// # Errors
    /// The errors of [`Self::deep`].
    pub fn most_samples(&mut self, cloud: &mut DeviceCloud, frame: &Frame, state: State) -> Result<u64, Error> {
        Ok(self.go_through(cloud, frame, state, (true, &mut |_, _| Ok(())))?.1)
    }

    /// Hands the samples of a frame to `sink`, the pixels row by row, whatever the windows: at most those of a band at
    /// a time.
    ///
    /// # Errors
    /// A method without samples ([`crate::methods::deep::check`]), a frame that does not fit, a device that fails, a
    /// frame that [`Self::progress`] cancels, and the errors of `sink`.
    pub fn deep(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        state: State,
        sink: &mut Sink<'_>,
    ) -> Result<Facts, Error> {
        Ok(self.go_through(cloud, frame, state, (false, sink))?.0)
    }

    /// Returns the counts of a frame, and how many samples it has at most.
    fn go_through(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        state: State,
        (survey, sink): (bool, &mut Sink<'_>),
    ) -> Result<(Facts, u64), Error> {
        frame.check()?;
        let source = DeepSource::of(&frame.method).ok_or(Error::NoSamples { method: frame.method.name() })?;
        let frame = &Frame { fragments: false, ..*frame };
        // A sink's own borrows need not live longer than the engine.
        let mut forward = |lengths: &[u32], samples: &[_]| sink(lengths, samples);
        let engine = DeepEngine { source, state, sink: RefCell::new(&mut forward), most: Cell::new(0) };
        self.make_ready(&engine, cloud, frame, false)?;
        self.disown_colors();
        self.device.reset_peak();
        let mut timeline = Timeline::new(&self.progress);
        timeline.stamps = Stamps::None;
        self.cast_shadows(&engine, cloud, frame, &mut timeline)?;
        let budget = self.budget(&engine, cloud, frame);
        let windows = engine.windows(frame, budget)?;
        let mut facts = self.begin_windows(cloud, &[*frame]);
        let job = Job { survey, by_rows: true, ..Job::new(&engine, frame, budget) };
        let done = |renderer: &mut Self, _, _| Ok(renderer.progress.check()?);
        self.walk(cloud, &job, &windows, &mut timeline, &mut facts, done)?;
        facts.peak_device_bytes = self.device.peak_bytes();
        Ok((facts, engine.most.get()))
    }
}
