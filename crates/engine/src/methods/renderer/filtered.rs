//! Windows of methods that filter the image of 1-pixel points.

use super::{Frame, Renderer, Work, depth_range, projecting};
use crate::methods::image_space::{self, WindowJob, windows};
use crate::methods::peel_layers::LayersJob;
use crate::methods::{Error, Outcome, bands};
use crate::passes::project::{DeviceCloud, Projecting};
use crate::passes::raster::Walker;
use crate::scene::{ImageSpace, PeelLayers};

impl Renderer {
    /// A window of `image-space`. What its filters have to do only the image tells: a survey renders it, too.
    pub(super) fn filtered(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        filters: ImageSpace,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let how = projecting(frame, cloud);
        let job = self.filter_job(cloud, frame, filters, work, &how);
        let target = (!work.survey).then_some(&self.target);
        self.filterer.render(&self.device, &job, target, work.timeline, work.facts)?;
        self.finish(cloud, work);
        Ok(Outcome::Done)
    }

    /// A window of `peel-layers`. How many layers there are only peeling tells: a survey does it, too.
    pub(super) fn layered(
        &mut self,
        cloud: &mut DeviceCloud,
        frame: &Frame,
        PeelLayers { filters, layers }: PeelLayers,
        work: &mut Work<'_>,
    ) -> Result<Outcome, Error> {
        let how = projecting(frame, cloud);
        if work.survey {
            self.target.reserve(&self.device, bands::pixels(work.window))?;
        }
        let image = self.filter_job(cloud, frame, filters, work, &how);
        let (counted, read_back) = (frame.fragments, !work.survey);
        let job = LayersJob { image, layers, counted, read_back };
        let (images, target) = (&mut self.filterer, &self.target);
        self.layer_peeler.render(images, &self.device, &job, target, work.timeline, work.facts)?;
        self.finish(cloud, work);
        Ok(Outcome::Done)
    }

    /// Sets the view to a window with all around it that its filters reach.
    fn filter_job<'a>(
        &self,
        cloud: &'a mut DeviceCloud,
        frame: &Frame,
        filters: ImageSpace,
        work: &Work<'_>,
        how: &'a Projecting,
    ) -> WindowJob<'a> {
        let (window, layers) = (work.window, image_space::layers(&frame.method));
        let outer = windows::grown(window, image_space::halo(&filters, layers.unwrap_or(1)), frame.size);
        cloud.set_view(&frame.camera, frame.size, outer, how);
        let distance = filters.min_layer_distance.unwrap_or((0.01 * cloud.diagonal()) as f32);
        let [_, far] = depth_range(frame);
        let (wide, transparent) = (self.wide_atomics, layers.is_some());
        WindowJob { cloud, window, outer, how, filters, distance, far, wide, transparent }
    }

    fn finish(&self, cloud: &DeviceCloud, work: &mut Work<'_>) {
        if !work.survey {
            self.progress.inc(bands::pixels(work.window));
        }
        work.facts.note(&cloud.stats(), Walker::Compute);
    }
}
