//! Depths that take further passes, and the eye-dome lighting that follows from depths.

use super::walk::{Job, largest};
use super::{Renderer, blank};
use crate::methods::abuffer::Shown;
use crate::methods::edl::{self, ShadedDepths};
use crate::methods::lists::ListEngine;
use crate::methods::prelude::*;

impl Renderer {
    /// Finds the further depths that a frame asks for, as far as its method has them: means, and medians, which
    /// eye-dome lighting uses as well.
    pub(super) fn find_depths(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        budget: Budget,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        if frame.depths || frame.shading.edl.edl {
            image.depth_median = self.depths_of(cloud, frame, Shown::Median, budget, timeline)?;
        }
        if frame.depths {
            image.depth_mean = self.depths_of(cloud, frame, Shown::Mean, budget, timeline)?;
        }
        Ok(())
    }

    /// Finds one depth for each pixel; `None` for methods whose images don't follow from sorted lists of all fragments.
    fn depths_of(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        shown: Shown,
        budget: Budget,
        timeline: &mut Timeline,
    ) -> Result<Option<Vec<f32>>, Error> {
        let Some(engine) = ListEngine::showing(&frame.method, shown) else { return Ok(None) };
        if !matches!(frame.method, Method::ABuffer(_) | Method::LinkedList(_)) {
            // The budget is for the buffers of lists as it was for those of the image.
            self.buffers = Buffers::new(&self.device)?;
        }
        let frame = Frame { fragments: false, ..*frame };
        let windows = self.windows(&engine, &frame, budget)?;
        self.make_target(largest(&windows), &frame)?;
        let mut image = blank(None, &engine, &frame);
        let drawn = self.draw(cloud, &Job::new(&engine, &frame, budget), &windows, &mut image, timeline);
        self.disown_colors();
        drawn.map(|_| Some(image.depth))
    }

    /// Applies eye-dome lighting to an image that was put together from regions ([`Self::region`]).
    ///
    /// # Errors
    /// The errors of [`Self::render`].
    pub fn apply_edl(&mut self, cloud: &DeviceCloud, frame: &Frame, image: &mut Image) -> Result<(), Error> {
        let budget = self.budget(engine_of(&frame.method).as_ref(), cloud, frame);
        let (_, shading) = edl::divided(budget, frame);
        self.light_eye_domes(frame, shading, image, &mut Timeline::new(&self.progress))?;
        image.depth_median = image.depth_median.take().filter(|_| frame.depths);
        Ok(())
    }

    /// Lights an image by its depths.
    pub(super) fn light_eye_domes(
        &mut self,
        frame: &Frame,
        budget: u64,
        image: &mut Image,
        timeline: &mut Timeline,
    ) -> Result<(), Error> {
        let Image { rgba, depth, depth_median, .. } = image;
        let surface = ShadedDepths { size: frame.size, depths: depth_median.as_deref().unwrap_or(depth) };
        self.whole = None;
        self.eye_dome.apply(&self.device, &frame.shading.edl, budget, surface, rgba, timeline)
    }
}
