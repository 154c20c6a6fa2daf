//! Frames whose random samples are drawn in parts.

use std::cell::RefCell;

use super::walk::{Job, is_whole, largest};
use super::{Begun, Rendered, Renderer, edl};
use crate::io::has_memory;
use crate::methods::DrawnPart;
use crate::methods::parts::{PartLayout, Plane};
use crate::methods::prelude::*;

impl Renderer {
    /// Draws some random samples of each pixel of a frame, or ensembles, and hands their sums to the host: all parts of
    /// a frame, drawn by whatever renderers of equal devices with whatever memory budgets, give the image of
    /// [`Self::render`] to the byte ([`Self::resolve_parts`]). [`Frame::sample_steps`] tells where samples may be cut;
    /// a part may be empty.
    ///
    /// # Errors
    /// A frame whose samples can't be drawn in parts, samples that are no part of it, and those of [`Self::render`].
    pub fn draw_part(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        samples: Range<u32>,
    ) -> Result<DrawnPart, Error> {
        let layout = layout(frame)?;
        let steps = layout.steps();
        if !steps.allows(&samples) {
            let (Range { start, end }, total, step) = (samples, steps.total, steps.step);
            return Err(Error::SampleRange { start, end, total, step });
        }
        // Lists are counted once, not with each part.
        let frame = Frame { fragments: frame.fragments && samples.start == 0, ..spreading(frame) };
        self.with_timeline(|renderer, timeline| renderer.part_by(cloud, (&frame, layout), samples, timeline))
    }

    fn part_by(
        &mut self,
        cloud: &mut DeviceCloud,
        (frame, layout): (&Frame, PartLayout),
        samples: Range<u32>,
        timeline: &mut Timeline,
    ) -> Result<DrawnPart, Error> {
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        let ([width, height], bytes) = (frame.size, layout.bytes(samples.clone()));
        if !has_memory(bytes) {
            return Err(Error::HostMemory { width, height, bytes });
        }
        let mut begun = self.begin(engine, cloud, frame, timeline, false)?;
        if samples.is_empty() {
            begun.windows.clear();
        }
        let sums = RefCell::new(SamplePart::new(layout, samples.clone()));
        let job = Job { samples, sums: Some(&sums), ..Job::new(engine, frame, begun.budget) };
        let mut image = Image { width, height, ..Image::default() };
        let mut facts = self.draw(cloud, &job, &begun.windows, &mut image, timeline)?;
        let part = sums.into_inner();
        image.fragments = part.all(Plane::Lengths).map(<[u32]>::to_vec);
        let profile = self.end(engine, &begun, timeline, &mut facts, (frame, &image), cloud);
        Ok(DrawnPart { part, profile, facts })
    }

    /// Returns the image of a frame whose parts were drawn ([`Self::draw_part`]) and put together
    /// ([`SamplePart::add`]): the bytes of [`Self::render`]. No point is drawn, and of the cloud only its brightest
    /// color counts; the counts are those of the windows in which the sums were resolved.
    ///
    /// # Errors
    /// Parts that are not all samples of this frame, a device that fails, and a frame that [`Self::progress`] cancels.
    pub fn resolve_parts(&mut self, cloud: &DeviceCloud, frame: &Frame, parts: &SamplePart) -> Result<Rendered, Error> {
        let layout = layout(frame)?;
        parts.check(frame)?;
        self.with_timeline(|renderer, timeline| renderer.resolve_by(cloud, (frame, layout), parts, timeline))
    }

    fn resolve_by(
        &mut self,
        cloud: &DeviceCloud,
        (frame, layout): (&Frame, PartLayout),
        parts: &SamplePart,
        timeline: &mut Timeline,
    ) -> Result<Rendered, Error> {
        frame.check()?;
        self.progress.check()?;
        let engine = engine_of(&frame.method);
        let engine = engine.as_ref();
        self.check_memory(engine, frame)?;
        self.device.reset_peak();
        let waits = self.device.waits();
        let (budget, shading) = edl::divided(self.budget(engine, cloud, frame), frame);
        let windows = self.windows(engine, frame, budget)?;
        self.make_target(largest(&windows), frame)?;
        let begun = Begun { waits, lights: (0, 0), budget, shading, windows };
        let mut image = self.begin_image(engine, frame)?;
        if !begun.windows.iter().all(|window| is_whole(*window, frame)) {
            self.target.bring_colors(&self.device)?;
        }
        let mut facts = self.begin_windows(cloud, &[*frame]);
        // Lengths of lists came with the parts.
        let of_window = Frame { fragments: false, ..spreading(frame) };
        let job = Job { samples: 0..layout.steps().total, ..Job::new(engine, &of_window, budget) };
        for window in begun.windows.iter().copied() {
            let (mut work, buffers) = self.work((&job, &of_window), window, timeline, &mut facts);
            engine.resolve(cloud, buffers, &mut work, parts)?;
            self.deliver(engine, &of_window, window, &mut image)?;
        }
        if self.target.leaves_colors() {
            image.rgba = Vec::new();
        }
        image.fragments = parts.all(Plane::Lengths).map(<[u32]>::to_vec);
        let profile = self.end(engine, &begun, timeline, &mut facts, (frame, &image), cloud);
        Ok(Rendered { image, profile, facts })
    }
}

/// Returns what the parts of a frame hold.
fn layout(frame: &Frame) -> Result<PartLayout, Error> {
    PartLayout::of(frame).ok_or(Error::NoParts { method: frame.method.name() })
}

/// A frame with the standard errors that another one wants for whatever reason.
fn spreading(frame: &Frame) -> Frame {
    Frame { spread: frame.wants_spread(), ..*frame }
}
