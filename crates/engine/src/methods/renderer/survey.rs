//! Counts and lists of a frame, without its image.

use super::Renderer;
use super::walk::{Job, first_counts};
use crate::methods::abuffer::{Lists, Shown};
use crate::methods::lists::ListEngine;
use crate::methods::{Error, Facts, Frame, Timeline, engine_of};
use crate::passes::project::DeviceCloud;
use crate::scene::{Discs, Method};

impl Renderer {
    /// Finds the expected counts of the frame, from projecting and counting alone: nothing is stored, sorted or
    /// blended.
    pub fn survey(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Facts, Error> {
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        let mut timeline = Timeline::new(&self.progress);
        let begun = self.begin(engine, cloud, frame, &mut timeline, true)?;
        let (light_views, light_resolution) = begun.lights;
        let mut facts = Facts { light_views, light_resolution, ..first_counts(cloud) };
        let samples = 0..engine.samples(frame).unwrap_or(0);
        let job = Job { samples, survey: true, ..Job::new(engine, frame, begun.budget) };
        self.walk(cloud, &job, &begun.windows, &mut timeline, &mut facts, |_, _, _| Ok(()))?;
        Ok(facts)
    }

    /// Returns the lists of a frame that fits in one window and band, before sorting: for tests and inspection.
    pub fn lists(&mut self, cloud: &mut DeviceCloud, frame: &Frame, discs: Discs) -> Result<Lists, Error> {
        frame.check()?;
        let engine = ListEngine { discs, linked: matches!(frame.method, Method::LinkedList(_)), shown: Shown::First };
        let budget = self.budget(&engine, cloud, frame);
        let mut timeline = Timeline::new(&self.progress);
        engine.lists(&self.device, cloud, &mut self.buffers, (frame, budget), &mut timeline)
    }
}
