//! Measures the parts of an approximation's error, against an image whose fragments have no order.

use pellucid_core::image::LinearImage;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_scene::{Hybrid, Method};

use super::TradeoffRun;
use crate::report::tradeoff::Look;
use crate::report::tradeoff::looks::{Exact, look};
use pellucid_session::candidates::{Formation, Setting};

impl TradeoffRun<'_> {
    /// Returns the parts of the error of a setting's image; `None` for exact ones and for opaque points.
    pub(super) fn look(&mut self, setting: &Setting, image: &LinearImage) -> Result<Option<Look>> {
        if setting.is_exact(&self.occasion) || self.made.covered.is_empty() {
            return Ok(None);
        }
        if self.unordered.is_none() {
            self.unordered = Some(self.render_unordered()?);
        }
        let unordered = self.unordered.as_ref().and_then(Option::as_ref);
        Ok(look(&Exact { reference: &self.made.reference, covered: &self.made.covered, unordered }, image))
    }

    /// The mean color of all fragments by opacity, with the exact coverage: none but opaque ones, which hide what has
    /// no order, are among the nearest of `hybrid`. Only of discs, and if the device can draw it.
    fn render_unordered(&mut self) -> Result<Option<LinearImage>> {
        let Formation::Discs(discs) = self.occasion.formation else { return Ok(None) };
        let method = Method::Hybrid(Hybrid { discs, k: 1, core_alpha_min: 1.0, ..Hybrid::default() });
        let frame = Frame { method, samples: self.made.samples, ..self.frame };
        let mut renderer = Renderer::new(self.device)?;
        let cloud = self.clouds.on_device(&renderer, 1, &frame.detail)?;
        match renderer.render(cloud, &frame) {
            Ok(rendered) => Ok(Some(self.linear(&rendered.image)?)),
            Err(error) if error.is_refusal() => Ok(None),
            Err(error) => Err(error.into()),
        }
    }
}
