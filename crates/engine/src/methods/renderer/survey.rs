//! Counts, costs and lists of a frame, without its image.

use super::Renderer;
use super::walk::{Job, largest};
use crate::methods::abuffer::{Lists, Shown};
use crate::methods::cost::Load;
use crate::methods::engine::project;
use crate::methods::lists::ListEngine;
use crate::methods::{Error, Facts, Frame, Timeline, edl, engine_of, projecting};
use crate::passes::project::{DeviceCloud, Stats};
use crate::scene::{Discs, Method};

impl Renderer {
    /// Finds the expected counts of the frame, from projecting and counting alone: nothing is stored, sorted or
    /// blended.
    pub fn survey(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Facts, Error> {
        frame.check()?;
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        self.make_ready(engine, cloud, frame, true)?;
        self.disown_colors();
        let budget = self.budget(engine, cloud, frame);
        let (budget, _) = edl::divided(budget, frame);
        let windows = engine.windows(frame, budget)?;
        if engine.renders_to_survey() {
            self.target.reserve(&self.device, largest(&windows))?;
        }
        let (light_views, samples) = (super::light_views(cloud, frame), engine.samples(frame).unwrap_or(0));
        let (points, gaussians) = (cloud.drawn(), cloud.gaussian_count());
        let mut facts = Facts { points, gaussians, light_views, ..Default::default() };
        let job = Job { samples: 0..samples, survey: true, ..Job::new(engine, frame, budget) };
        self.walk(cloud, &job, &windows, &mut Timeline::new(&self.progress), &mut facts, |_, _| Ok(()))?;
        Ok(facts)
    }

    /// Returns the factors of the cost of a frame of discs, from projecting alone.
    pub fn load(&mut self, cloud: &mut DeviceCloud, frame: &Frame, discs: &Discs) -> Result<Load, Error> {
        frame.check()?;
        let [width, height] = frame.size;
        let (window, how) = ([0, 0, width, height], projecting::discs(frame, cloud, discs));
        let stats = project(&self.device, cloud, (frame, window), &how, &mut Timeline::new(&self.progress))?;
        let splats = stats.iter().map(|s| u64::from(s.visible)).sum();
        Ok(Load { splats, area: Stats::area(&stats), pixels: u64::from(width) * u64::from(height) })
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
