//! Samples of lists, in place of what they are blended to.

use super::{Blender, Blending};
use crate::methods::abuffer::{Sampled, Samples};
use crate::methods::prelude::*;

impl Blender {
    /// Records the samples of a band's stored fragments, of every list in order.
    pub(in crate::methods) fn record_fragment_samples<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        blending: &Blending<'a>,
        samples: Sampled<'a>,
    ) -> Result<(), Error> {
        let runs = self.record_every_list(recorder, blending)?;
        let variant = compose::variant(runs.cut, blending.job.raster.footprint, blending.job.discs.falloff);
        Ok(recorder.run(&Samples { sorted: runs.sorted, samples }, (), &runs.over_runs(variant))?)
    }
}
