//! The engine of `image-space`, and the parts that `peel-layers` shares with it.

use super::{Filter, FilterJob, Filterer, halo, least_bytes, windows};
use crate::methods::points;
use crate::methods::prelude::*;
use crate::scene::{ImageSpace, Iterations};

/// A filtered image of points.
pub(crate) struct ImageSpaceEngine {
    /// The filters.
    pub filters: ImageSpace,
}

impl ImageSpaceEngine {
    fn filtering(&self) -> Filtering {
        Filtering { filters: self.filters, layers: None }
    }
}

impl Engine for ImageSpaceEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        self.filtering().windows(frame, budget)
    }

    /// Filters look at the pixels around.
    fn takes_fours(&self) -> bool {
        false
    }

    fn extent(&self, _frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::pixels(self.filtering().halo().into())
    }

    fn projects(&self) -> bool {
        false
    }

    /// The filters' work depends on the image, so a survey renders it, too.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let how = work.frame.projecting_points(cloud);
        let job = self.filtering().job(cloud, work, &how);
        buffers.resources.own.of::<Filterer>(work.device)?.render(work, &job)?;
        finish(cloud, work);
        Ok(Outcome::Done)
    }
}

impl Explain for ImageSpaceEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        least_bytes(pass.name, pass.facts, pass.cloud, self.filters.cull)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        self.filtering().explain(plan);
    }
}

/// Adds a finished window.
pub(crate) fn finish(cloud: &DeviceCloud, work: &mut Work<'_>) {
    work.finish();
    work.facts.note(&cloud.stats(), Walker::Compute);
}

/// The filters of an image, or of some layers of images.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filtering {
    /// The filters.
    pub filters: ImageSpace,
    /// Layers at most, if images are layers of another one.
    pub layers: Option<u32>,
}

impl Filtering {
    /// Cuts a frame into windows whose images fit, with their halos.
    ///
    /// # Errors
    /// The halo of a single pixel does not fit.
    pub fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        super::frame_windows(frame.size, self, budget)
    }

    /// Returns the number of pixels around a window that its filters reach.
    pub fn halo(&self) -> u32 {
        halo(&self.filters, self.layers.unwrap_or(1))
    }

    /// Sets the view to a window with all around it that its filters reach.
    pub fn job<'a>(&self, cloud: &'a mut DeviceCloud, work: &Work<'_>, how: &'a Projecting) -> FilterJob<'a> {
        let (frame, window, filters) = (work.frame, work.window, self.filters);
        let outer = windows::grown(window, self.halo(), frame.size);
        cloud.set_view(&frame.camera, frame.size, outer, how);
        let distance = filters.min_layer_distance.unwrap_or((0.01 * cloud.diagonal()) as f32);
        let [_, far] = frame.depth_range();
        let (wide, transparent) = (work.switches.wide_atomics, self.layers.is_some());
        FilterJob { cloud, window, outer, how, filters, distance, far, wide, transparent }
    }

    /// The plan of a frame.
    pub fn explain(&self, plan: &mut FramePlan<'_>) {
        plan.cleared();
        plan.not_projected();
        self.explain_points(plan);
        plan.found();
        self.explain_filters(plan);
        let [width, height] = plan.frame.size;
        if self.layers.is_some() {
            plan.add("peel-layers/blend", true, "blends each layer behind those before it");
            plan.add("peel-layers/summary", true, "after each batch of layers the host checks whether more are left");
        } else {
            plan.add("image/clear", true, "image-space/deliver skips tiles that are all background");
            plan.add("image-space/deliver", true, format!("copies tiles to {width} × {height} pixels"));
        }
        plan.rest(&PASSES, "the method blends layers and does not deliver each by itself");
    }

    /// Finding the nearest points.
    fn explain_points(&self, plan: &mut FramePlan<'_>) {
        plan.add("image-space/clear", true, "nearest points and work lists start empty");
        if self.layers.is_some() {
            plan.add("peel-layers/clear", true, "counts of layers start at zero");
            plan.add("image/clear", true, "pixels without layers stay empty");
        }
        let culled =
            if self.filters.cull { "points that face away are left out" } else { "points that face away stay" };
        let (any, why) = (plan.facts.points > 0, plan.why);
        let reason = if any { format!("{why}; {culled}") } else { "there are no points".to_owned() };
        plan.nearest(points::NEAREST, any, &reason);
    }

    /// Making an image of them and filtering it.
    fn explain_filters(&self, plan: &mut FramePlan<'_>) {
        let facts = plan.facts;
        let tiles = facts.image_tiles;
        plan.add("image-space/measure", true, format!("finds what each of {tiles} tiles holds"));
        if let Some(most) = self.layers {
            let reason = format!(
                "{} of at most {most} layers have points; the first layer without any ends the search",
                facts.layers
            );
            plan.add("peel-layers/next", true, reason);
        }
        plan.add("image-space/list", true, "lists for each filter the tiles it may change");
        let shading = plan.shading();
        plan.add("image-space/resolve", true, format!("turns the index of the nearest point into a color; {shading}"));
        for (filter, listed) in Filter::ALL.into_iter().zip(facts.filtered_tiles) {
            let (name, iterations, what) = asked(filter, &self.filters);
            let reason = match iterations {
                Iterations::Count(0) => "the filter is switched off".to_owned(),
                Iterations::Count(count) => {
                    format!("{count} iteration(s) over tiles with {what}: {listed} of {tiles} tiles")
                }
                Iterations::Auto => {
                    let (runs, most) = (facts.closing_runs[filter as usize], iterations.most());
                    format!(
                        "{runs} of at most {most} iterations had tiles with {what}: {listed} visits of {tiles} tiles"
                    )
                }
            };
            // Its dispatches are recorded, if empty: the host does not know what an image holds.
            plan.add(name, iterations.most() > 0, reason);
        }
        plan.add("image-space/summary", true, "reports how many tiles each filter visited");
    }
}

/// The pass of a filter, the number of its iterations, and its purpose.
fn asked(filter: Filter, filters: &ImageSpace) -> (&'static str, Iterations, &'static str) {
    let antialias = Iterations::Count(filters.antialias.into());
    match filter {
        Filter::Fill => ("image-space/fill", filters.fill, "background next to points"),
        Filter::Occlusion => {
            ("image-space/occlusion", filters.occlusion, "points that lie min_layer_distance or more behind others")
        }
        Filter::Smooth => ("image-space/smooth", Iterations::Count(filters.smooth), "points"),
        Filter::Antialias => ("image-space/antialias", antialias, "edges in depth"),
    }
}

/// The passes of filtered images.
const PASSES: [&str; 10] = [
    "image-space/clear",
    "image-space/measure",
    "image-space/resolve",
    "image-space/list",
    "image-space/fill",
    "image-space/occlusion",
    "image-space/smooth",
    "image-space/antialias",
    "image-space/summary",
    "image-space/deliver",
];

/// Returns the passes of filtered images.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&PASSES, Absent::Method("no image-space filters"))
}
