//! The engine of `peel-layers`.

use super::{LayerPeeler, LayersJob};
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Channels, Counts, Engine, Work};
use crate::methods::explain::{Absent, Explain, FramePlan, PassGroup};
use crate::methods::image_space::{self, Filtering};
use crate::methods::{Buffers, Error, Frame, Outcome};
use crate::passes::bands::{Budget, Window};
use crate::passes::project::{DeviceCloud, PointExtent};
use crate::scene::PeelLayers;

/// Layers of filtered images of points, blended.
pub(crate) struct PeelLayersEngine {
    /// Filters and layers.
    pub settings: PeelLayers,
}

impl PeelLayersEngine {
    fn filtering(&self) -> Filtering {
        Filtering { filters: self.settings.filters, layers: Some(self.settings.layers) }
    }
}

impl Engine for PeelLayersEngine {
    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        self.filtering().windows(frame, budget)
    }

    fn renders_to_survey(&self) -> bool {
        true
    }

    fn extent(&self, _frame: &Frame, _cloud: &DeviceCloud) -> PointExtent {
        PointExtent::pixels(self.filtering().halo().into())
    }

    fn projects(&self) -> bool {
        false
    }

    fn channels(&self) -> Channels {
        Channels { layers: true, ..Channels::NONE }
    }

    /// Only peeling finds the number of layers, so a survey peels, too.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let how = work.frame.projecting_points(cloud);
        let image = self.filtering().job(cloud, work, &how);
        let (layers, counted, read_back) = (self.settings.layers, work.frame.fragments, !work.survey);
        let peeler = buffers.resources.own.of::<LayerPeeler>(work.device)?;
        peeler.render(work, &LayersJob { image, layers, counted, read_back })?;
        image_space::finish(cloud, work);
        Ok(Outcome::Done)
    }

    fn counts(&self, buffers: &Buffers, frame: &Frame, window: Window) -> Result<Counts, Error> {
        let peeler = buffers.resources.own.there::<LayerPeeler>().filter(|_| frame.fragments);
        let layers = peeler.map(|peeler| peeler.read_layers(window)).transpose()?;
        Ok(Counts { layers, ..Counts::default() })
    }
}

impl Explain for PeelLayersEngine {
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        image_space::least_bytes(pass.name, pass.facts, pass.cloud, self.settings.filters.cull)
    }

    fn explain(&self, plan: &mut FramePlan<'_>) {
        self.filtering().explain(plan);
    }
}

/// Returns the passes that layers of filtered images have besides those of one.
pub(crate) fn pass_group() -> PassGroup {
    let names = ["peel-layers/clear", "peel-layers/next", "peel-layers/blend", "peel-layers/summary"];
    PassGroup::new(&names, Absent::Method("no layers of point surfaces"))
}
