//! The engine of `one-layer`.

use super::record;
use crate::gpu::DeviceInfo;
use crate::methods::bytes::PassRuns;
use crate::methods::engine::{Channels, Counts, Engine, Work, windows_of};
use crate::methods::explain::{Absent, PassGroup, Plan};
use crate::methods::splats::{self, Onto, SOLID_BYTES, solid_projecting};
use crate::methods::{Buffers, Error, Frame, Outcome};
use crate::passes::bands::{Budget, Window};
use crate::passes::bin;
use crate::passes::project::{DeviceCloud, Part};
use crate::passes::raster::Walker;
use crate::scene::OneLayer;

/// The nearest soft points as a transparent layer over everything else.
pub(crate) struct OneLayerEngine {
    /// The threshold of soft points, and the opacity of the layer.
    pub settings: OneLayer,
}

impl Engine for OneLayerEngine {
    fn needs_subgroups(&self, _device: &DeviceInfo) -> bool {
        true
    }

    fn windows(&self, frame: &Frame, budget: Budget) -> Result<Vec<Window>, Error> {
        Ok(windows_of(frame, budget, bin::PIXEL_BYTES + SOLID_BYTES))
    }

    fn channels(&self) -> Channels {
        Channels::NONE
    }

    /// Draws soft points into the layer, then all points, soft ones only behind the layer, and lays the layer over
    /// them. Without a layer it draws the solid points.
    fn render(&self, cloud: &mut DeviceCloud, buffers: &mut Buffers, work: &mut Work<'_>) -> Result<Outcome, Error> {
        let OneLayer { threshold, softness } = self.settings;
        let mut met = Vec::new();
        if cloud.parts(threshold).soft > 0 {
            let how = solid_projecting(work.frame, cloud, Part::Soft { threshold, modulation: None });
            met = work.project(cloud, &how)?;
            if !work.survey {
                buffers.machines.layer.reserve(work.device, work.pixels())?;
            }
            if splats::draw_solid(cloud, buffers, work, (&met, how.footprint, Onto::Layer))? == Outcome::Overflow {
                return Ok(Outcome::Overflow);
            }
        }
        let layered = met.iter().any(|s| s.visible > 0);
        let (part, onto) = if layered {
            (Part::Marked(threshold), Onto::TargetBehindLayer)
        } else {
            (Part::Solid(threshold), Onto::Target)
        };
        let how = solid_projecting(work.frame, cloud, part);
        let stats = work.project(cloud, &how)?;
        if splats::draw_solid(cloud, buffers, work, (&stats, how.footprint, onto))? == Outcome::Overflow {
            return Ok(Outcome::Overflow);
        }
        work.facts.layered += u64::from(layered);
        work.facts.note(&[met, stats].concat(), Walker::Compute);
        if layered && !work.survey {
            let mut recorder = work.device.recorder()?;
            let layer = &buffers.machines.layer;
            record(&mut recorder, layer.pixels(), work.target.pixels(), work.window, softness)?;
            work.timeline.submit(recorder, "one-layer/compose")?;
        }
        work.read_back()?;
        Ok(Outcome::Done)
    }

    fn counts(&self, _buffers: &Buffers, _frame: &Frame, _window: Window) -> Result<Counts, Error> {
        Ok(Counts::default())
    }

    /// The number of solid splats is unknown.
    fn least_bytes(&self, pass: &PassRuns<'_>) -> Option<u64> {
        pass.projected(false)
    }

    fn explain(&self, plan: &mut Plan<'_>) {
        plan.projected();
        splats::explain_windows(plan);
    }
}

/// The pass that lays the layer over everything else.
pub(crate) fn pass_group() -> PassGroup {
    PassGroup::new(&["one-layer/compose"], Absent::Always("no layer of soft points"))
}
