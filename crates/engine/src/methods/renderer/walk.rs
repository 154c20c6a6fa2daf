//! The walk over the windows of a frame.

use std::cell::{Cell, RefCell};

use super::{LONGEST, Renderer};
use crate::methods::mean::{self, Mean};
use crate::methods::prelude::*;
use crate::methods::several::Several;
use crate::spread;

/// The work on each window of a frame.
#[derive(Clone)]
pub(super) struct Job<'a> {
    /// The engine.
    pub engine: &'a dyn Engine,
    /// The frame.
    pub frame: &'a Frame,
    /// The frames of its images, one after the other in each window: of each alone, or of four at once.
    pub images: Vec<Frame>,
    /// The memory that may be used.
    pub budget: Budget,
    /// Samples or ensembles to draw.
    pub samples: Range<u32>,
    /// Place for sums of samples, which then are not resolved to an image.
    pub sums: Option<&'a RefCell<SamplePart>>,
    /// Counts to which those of this work are added.
    pub counted: Option<Facts>,
    /// `true` if counting is enough.
    pub survey: bool,
    /// `true` if windows learn their counts from earlier frames.
    pub learns: bool,
    /// `true` if windows are cut by rows first, because pixels are handed on row by row.
    pub by_rows: bool,
}

/// The turn of one of the images of a window.
#[derive(Clone, Copy)]
struct Turn<'a, 'j> {
    job: &'a Job<'j>,
    frame: &'a Frame,
    /// `true` for the first image: it brings the points of the window.
    is_first: bool,
    several: Option<&'a Cell<Option<Several>>>,
}

impl<'a> Job<'a> {
    /// Returns the rendering of a frame that learns nothing from earlier ones, without samples.
    pub fn new(engine: &'a dyn Engine, frame: &'a Frame, budget: Budget) -> Self {
        Self {
            engine,
            frame,
            images: vec![*frame],
            budget,
            samples: 0..0,
            sums: None,
            counted: None,
            survey: false,
            learns: false,
            by_rows: false,
        }
    }
}

impl Renderer {
    /// Renders the windows of a frame into an image, the mean of its images if they are several, or keeps their sums.
    pub(super) fn draw(
        &mut self,
        cloud: &mut DeviceCloud,
        job: &Job<'_>,
        windows: &[Window],
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<Facts, Error> {
        let begun = self.begin_windows(cloud, &job.images);
        let mut facts = job.counted.clone().unwrap_or(begun);
        let mut mean = job.frame.is_mean().then(|| Mean::new(job.frame, image));
        self.walk(cloud, job, windows, timeline, &mut facts, |renderer, window, number| {
            let frame = &job.images[number];
            if job.sums.is_some() {
                return Ok(renderer.progress.check()?);
            }
            if let (Some(mean), Some(_)) = (&mut mean, frame.four) {
                return renderer.deliver_four(job.engine, frame, window, (mean, image));
            }
            renderer.deliver(job.engine, frame, window, image)?;
            mean.iter_mut().for_each(|mean| mean.add(image, window, number == 0));
            Ok(())
        })?;
        mean.into_iter().for_each(|mean| mean.finish(image));
        Ok(facts)
    }

    /// Goes through the windows of a frame in their order, and cuts those that turn out too large. Each finished window
    /// is handed to `done`, with the number of the image. All images of a window come before the next one, so that
    /// points that come to the device window by window come once.
    pub(super) fn walk(
        &mut self,
        cloud: &mut DeviceCloud,
        job: &Job<'_>,
        windows: &[Window],
        timeline: &mut Timeline,
        facts: &mut Facts,
        mut done: impl FnMut(&mut Self, Window, usize) -> Result<(), Error>,
    ) -> Result<(), Error> {
        facts.images += job.images.len() as u64;
        let mut left: Vec<Window> = windows.iter().rev().copied().collect();
        while let Some(window) = left.pop() {
            if !job.survey && !is_whole(window, job.frame) {
                self.target.bring_colors(&self.device)?;
            }
            let found = Cell::default();
            let several = (job.images.len() > 1 && self.switches.together).then_some(&found);
            for (number, frame) in job.images.iter().enumerate() {
                let turn = Turn { job, frame, is_first: number == 0, several };
                match self.window(cloud, turn, window, timeline, facts)? {
                    Outcome::Done => done(self, window, number)?,
                    // Its halves begin with the first image again.
                    Outcome::Overflow => {
                        split(job, cloud, window, &mut left)?;
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Begins to go through the windows of a frame. Returns its first counts.
    pub(super) fn begin_windows(&mut self, cloud: &DeviceCloud, images: &[Frame]) -> Facts {
        let pixels = |frame: &Frame| u64::from(frame.size[0]) * u64::from(frame.size[1]);
        self.progress.set_length(images.iter().map(pixels).sum());
        self.progress.set_position(0);
        self.whole = None;
        first_counts(cloud)
    }

    /// Copies a window that is in the target into the image, with its counts.
    pub(super) fn deliver(
        &mut self,
        engine: &dyn Engine,
        frame: &Frame,
        window: Window,
        image: &mut Image,
    ) -> Result<(), Error> {
        self.progress.check()?;
        self.whole = is_whole(window, frame).then(|| bands::pixels(window));
        self.target.deliver(window, image);
        copy_counts(frame, window, engine.counts(&self.buffers, frame, window)?, image);
        Ok(())
    }

    /// Adds a window of four images that is in the target to the sums of a picture, with its counts.
    fn deliver_four(
        &mut self,
        engine: &dyn Engine,
        frame: &Frame,
        window: Window,
        (mean, image): (&mut Mean, &mut Image),
    ) -> Result<(), Error> {
        self.progress.check()?;
        let (part, is_first) = (frame.part(window), frame.four == Some(0));
        let (colors, depths) = self.target.on_host(bands::pixels(part));
        let counts = engine.counts(&self.buffers, frame, part)?;
        mean.add_four((colors, &counts), window, is_first, image.width as usize);
        if is_first {
            mean::set_depths(image, window, depths);
        }
        Ok(())
    }

    /// Renders or surveys a window. The counts of a window that must be cut are dropped. A window whose counts were
    /// predicted wrongly is rendered once more.
    fn window(
        &mut self,
        cloud: &mut DeviceCloud,
        turn: Turn<'_, '_>,
        window: Window,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        let job = turn.job;
        timeline.foresight.begin(!job.learns || self.submitted > LONGEST);
        loop {
            let before = facts.clone();
            let outcome = self.attempt(cloud, turn, window, timeline, facts);
            timeline.drop_paused();
            let waited = timeline.foresight.knowledge() == Knowledge::None;
            match outcome {
                Ok(Outcome::Done) => {
                    if job.learns {
                        timeline.foresight.finish();
                    }
                    return outcome;
                }
                // An upper bound may not fit where a count does.
                Ok(Outcome::Overflow) if !waited => {}
                Err(ref error) if !waited && error.is_refusal() => {}
                _ => {
                    *facts = before;
                    return outcome;
                }
            }
            *facts = before;
            timeline.foresight.miss();
        }
    }

    /// Renders or surveys a window once, with the counts that are known or predicted.
    fn attempt(
        &mut self,
        cloud: &mut DeviceCloud,
        Turn { job, frame, is_first, several }: Turn<'_, '_>,
        window: Window,
        timeline: &mut Timeline,
        facts: &mut Facts,
    ) -> Result<Outcome, Error> {
        if is_first {
            several.into_iter().for_each(|last| last.set(None));
            if self.bring(cloud, job, window, timeline)? == Outcome::Overflow {
                return Ok(Outcome::Overflow);
            }
        }
        self.buffers.resources.bins.forget_tile_counts();
        let (mut work, buffers) = self.work((job, frame), frame.part(window), timeline, facts);
        work.several = several;
        work.timeline.given = frame.four.map(|_| (mean::QUARTERS, 1.0));
        let outcome = job.engine.render(cloud, buffers, &mut work);
        work.timeline.given = None;
        let outcome = outcome?;
        if outcome == Outcome::Done {
            for note in std::mem::take(&mut work.later) {
                note(work.facts, work.timeline);
            }
            if self.notes_tiles && !job.survey {
                spread::add(&mut facts.tile_histogram, &self.buffers.resources.bins.tile_counts()?);
            }
        }
        Ok(outcome)
    }

    /// Returns a window in work, and the buffers for it.
    pub(super) fn work<'a>(
        &'a mut self,
        (job, frame): (&Job<'a>, &'a Frame),
        window: Window,
        timeline: &'a mut Timeline,
        facts: &'a mut Facts,
    ) -> (Work<'a>, &'a mut Buffers) {
        let work = Work {
            device: &self.device,
            frame,
            window,
            several: None,
            budget: job.budget,
            samples: job.samples.clone(),
            sums: job.sums,
            target: &self.target,
            timeline,
            facts,
            progress: &self.progress,
            switches: self.switches,
            survey: job.survey,
            later: Vec::new(),
        };
        (work, &mut self.buffers)
    }
}

/// Returns the counts of a frame of which no window was rendered yet.
pub(super) fn first_counts(cloud: &DeviceCloud) -> Facts {
    Facts { points: cloud.drawn(), shown: cloud.shown(), gaussians: cloud.gaussian_count(), ..Facts::default() }
}

/// Returns `true` for the window that is the whole image.
pub(super) fn is_whole(window: Window, frame: &Frame) -> bool {
    window == [0, 0, frame.size[0], frame.size[1]]
}

/// Returns the number of pixels of the largest window.
pub(super) fn largest(windows: &[Window]) -> u64 {
    windows.iter().map(|w| bands::pixels(*w)).max().unwrap_or(1)
}

/// Puts the halves of a window that overflowed back on the list.
fn split(job: &Job<'_>, cloud: &DeviceCloud, window: Window, windows: &mut Vec<Window>) -> Result<(), Error> {
    let halves = if job.by_rows {
        bands::halves(window)
    } else if cloud.supply().is_some() {
        // Points at the border of two windows come with both.
        bands::square_halves(window)
    } else {
        job.engine.halves(window)
    };
    let [a, b] = halves.ok_or(Error::PixelOverflow { x: window[0], y: window[1] })?;
    windows.extend([b, a]);
    Ok(())
}

/// Copies a window's counts into those of the image.
fn copy_counts(frame: &Frame, window: Window, counts: Counts, image: &mut Image) {
    copy_values(frame, window, counts.fragments, image.fragments.as_mut());
    copy_values(frame, window, counts.layers, image.layers.as_mut());
    copy_values(frame, window, counts.stderr, image.stderr.as_mut());
}

fn copy_values<T: Copy>(frame: &Frame, window: Window, values: Option<Vec<T>>, image: Option<&mut Vec<T>>) {
    let (Some(values), Some(image)) = (values, image) else { return };
    let width = (window[2] - window[0]) as usize;
    for (row, values) in values.chunks(width).enumerate() {
        let to = (window[1] as usize + row) * frame.size[0] as usize + window[0] as usize;
        image[to..to + width].copy_from_slice(values);
    }
}
